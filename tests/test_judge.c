/* judge: under way */
#include "test_boards.h"

TEST_MAIN()
{
}
