/* For links whose information is NaN or negative, rigcal_rig_advise wrote one line more
 * than it said, beyond the capacity. */
#include <string.h>

#include "test_rigs.h"

static test_rig r;

static void test_no_more_lines_are_written_than_told(void)
{
    const rigcal_real information[3] = {-2, RC(-1e30), TEST_NAN};
    test_rng rng = test_seed(1);
    rigcal_link links[RIGCAL_LINKS(3)];
    rigcal_advice advice[4];
    size_t n;

    TEST_WANTS_RAM(sizeof(test_rig) + 12000);
    test_rig_random(&r, &rng, 3, 1, 6);
    test_rig_see_all(&r, &rng, 0);
    for (int k = 0; k < 3; k++) {
        for (int32_t groups = 1; groups <= 3; groups++) {
            memset(links, 0, sizeof links);
            FILL(advice);
            for (int i = 0; i < 3; i++) {
                links[i].information = information[k];
                r.group[i] = (i < groups) ? i : groups - 1;
            }
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_advise(advice, (size_t)groups - 1, &n, links, &r.rig));
            TEST_ASSERT_EQUAL((size_t)groups - 1, n);
            ASSERT_UNTOUCHED(advice[n]);
            for (size_t line = 0; line < n; line++) {
                TEST_ASSERT_NOT_EQUAL(r.group[advice[line].a], r.group[advice[line].b]);
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_no_more_lines_are_written_than_told);
}
