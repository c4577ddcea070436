/* Views of a source, which are read more than once:
 *
 *   - a source that failed while a step of the search was tried was not heard: the search
 *     took it for a bad step and went on
 *   - rigcal_rig_links wrote beyond its memory where the source named another camera than
 *     when the views were checked
 *
 * tests/test_sources.c tries all functions. */
#include <string.h>

#include "test_boards.h"

static test_boards b;
static size_t calls, at;
static int32_t other_camera;

#define WANTS_BOARDS TEST_WANTS_RAM(sizeof(test_boards) + 20000)

static rigcal_status view_that_fails(rigcal_rig_view *view, size_t index, void *context)
{
    (void)context;
    *view = b.views[index];
    return (++calls == at) ? RIGCAL_ERR_DAMAGED : RIGCAL_OK;
}

static rigcal_status pose_that_changes(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    *pose = b.own[index];
    if (++calls == at) {
        pose->camera = other_camera;
    }
    return RIGCAL_OK;
}

static void make(void)
{
    test_rng rng = test_seed(5000);

    test_boards_make(&b, &rng, 2, 3, 2, 0.3, 0);
    test_boards_solve(&b);
}

static void test_a_source_that_fails_is_heard_whenever_it_does(void)
{
    static test_boards before;
    rigcal_rig_fit fit;
    size_t n;

    WANTS_BOARDS;
    make();
    b.rig.views = NULL;
    b.rig.view_source = view_that_fails;
    before = b;
    calls = at = 0;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    n = calls;
    for (at = 1; at <= n; at++) {
        b = before;
        calls = 0;
        ASSERT_REFUSED(RIGCAL_ERR_DAMAGED, fit, rigcal_rig_adjust(&fit, NULL, &b.rig));
        TEST_ASSERT_EQUAL_size_t(at, calls);
    }
}

static void test_links_stay_in_their_memory(void)
{
    static const int32_t WRONG[] = {-1, 2, 1 << 20};
    struct {
        rigcal_link link;
        char after[64];
    } memory;
    int32_t n_groups, at_fault;

    WANTS_BOARDS;
    make();
    b.rig.view_poses = NULL;
    b.rig.view_pose_source = pose_that_changes;
    for (int k = 0; k < 4; k++) {
        calls = 0;
        at = b.rig.n_views + 2; /* the second view, when it is read again */
        other_camera = (k < 3) ? WRONG[k] : 0;
        FILL(memory.after);
        ASSERT_STATUS((k < 3) ? RIGCAL_ERR_RANGE : RIGCAL_ERR_TWICE,
                      rigcal_rig_links(&memory.link, 1, &n_groups, &at_fault, &b.rig));
        ASSERT_UNTOUCHED(memory.after);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_source_that_fails_is_heard_whenever_it_does);
    RUN_TEST(test_links_stay_in_their_memory);
}
