#include "test_support.h"
TEST_MAIN()
{
}
