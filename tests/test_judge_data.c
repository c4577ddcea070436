/* judge and cause on real cameras: the sets of examples/data, in which no view must be
 * named, and the stereo set with one view, or all views of a camera, in reverse. It reads
 * files, so it runs only on a host. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_support.h"

enum { LINE = 1024, NAME = 32, CAMERAS = 4, PLACES = 24, VIEWS = 48, POINTS = 12000 };

static struct {
    char cameras[CAMERAS][NAME], places[PLACES][NAME];
    rigcal_camera camera[CAMERAS];
    rigcal_transform cams[CAMERAS], rig_from[PLACES];
    int32_t group[CAMERAS];
    rigcal_rig_view views[VIEWS];
    rigcal_view_pose own[VIEWS], second[VIEWS];
    rigcal_observation o[POINTS], room[POINTS];
    uint8_t left_out[VIEWS], takes[VIEWS];
    rigcal_judged_view judged[VIEWS];
    rigcal_choice choice;
    rigcal_judgement judgement;
    rigcal_real work[RIGCAL_JUDGE_WORK(CAMERAS, PLACES) +
                     RIGCAL_CHOOSE_WORK(CAMERAS, PLACES, VIEWS)];
    rigcal_rig rig;
} r;

static FILE *open_data(const char *set, const char *file)
{
    char path[LINE], header[LINE];
    FILE *stream;

    snprintf(path, sizeof path, "%s/%s/%s", RIGCAL_DATA_DIR, set, file);
    stream = fopen(path, "r");
    TEST_ASSERT_NOT_NULL_MESSAGE(stream, path);
    TEST_ASSERT_NOT_NULL(fgets(header, sizeof header, stream));
    return stream;
}

/* The number of a name in a list. A new name is added. */
static int number_of(char names[][NAME], size_t *n, int most, const char *name)
{
    for (size_t i = 0; i < *n; i++) {
        if (strcmp(names[i], name) == 0) {
            return (int)i;
        }
    }
    TEST_ASSERT_TRUE(*n < (size_t)most);
    snprintf(names[*n], NAME, "%s", name);
    return (int)(*n)++;
}

static void read_cameras(const char *set)
{
    FILE *const stream = open_data(set, "cameras.csv");
    char line[LINE], name[NAME];

    while (fgets(line, sizeof line, stream) != NULL) {
        double v[15] = {RIGCAL_LENS_BROWN};

        if (sscanf(line, "%31[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", name, &v[1],
                   &v[2], &v[3], &v[4], &v[5], &v[6], &v[7], &v[8], &v[9], &v[10],
                   &v[11]) >= 7) {
            r.camera[number_of(r.cameras, &r.rig.n_cameras, CAMERAS, name)] =
                test_camera(v);
        }
    }
    fclose(stream);
}

/* Sorts views by placement: the file has them in another order. */
static int by_placement(const void *a, const void *b)
{
    const rigcal_rig_view *const p = a, *const q = b;

    return p->placement != q->placement ? p->placement - q->placement
                                        : p->camera - q->camera;
}

static void read_set(const char *set)
{
    char line[LINE], frame[NAME], camera[NAME], last[2 * NAME] = "";
    size_t n = 0;

    memset(&r, 0, sizeof r);
    read_cameras(set);
    FILE *const stream = open_data(set, "observations.csv");
    while (fgets(line, sizeof line, stream) != NULL) {
        double X[3], uv[2];
        char here[2 * NAME];

        TEST_ASSERT_EQUAL_INT(7,
                              sscanf(line, "%31[^,],%31[^,],%*[^,],%lf,%lf,%lf,%lf,%lf",
                                     frame, camera, &X[0], &X[1], &X[2], &uv[0], &uv[1]));
        TEST_ASSERT_TRUE(n < POINTS);
        test_to_real(r.o[n].X_w, X, 3);
        test_to_real(r.o[n].uv, uv, 2);
        snprintf(here, sizeof here, "%s,%s", frame, camera);
        if (strcmp(here, last) != 0) {
            TEST_ASSERT_TRUE(r.rig.n_views < VIEWS);
            rigcal_rig_view *const v = &r.views[r.rig.n_views++];
            v->camera = number_of(r.cameras, &r.rig.n_cameras, CAMERAS, camera);
            v->placement = number_of(r.places, &r.rig.n_placements, PLACES, frame);
            v->view = VIEW(&r.camera[v->camera], &r.o[n], NULL, 0);
            strcpy(last, here);
        }
        r.views[r.rig.n_views - 1].view.n++;
        n++;
    }
    fclose(stream);
    qsort(r.views, r.rig.n_views, sizeof r.views[0], by_placement);
    r.rig.cams_from_rig = r.cams;
    r.rig.rig_from_placements = r.rig_from;
    r.rig.group = r.group;
    r.rig.views = r.views;
    r.rig.view_poses = r.own;
    r.rig.work = r.work;
    r.rig.work_capacity = sizeof r.work / sizeof r.work[0];
    r.choice.takes = r.takes;
    r.choice.second_poses = r.second;
}

/* Finds both poses of a view. */
static void solve(size_t v)
{
    rigcal_pose poses[2];
    size_t n;

    TEST_ASSERT_TRUE(rigcal_pose_solve(poses, 2, &n, NULL, &r.views[v].view, NULL) >= 0);
    r.second[v].n = 0;
    for (size_t i = 0; i < n; i++) {
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_view_pose_make(i ? &r.second[v] : &r.own[v], &r.views[v],
                                            &poses[i].cam_from_world));
    }
}

static rigcal_status judge(void)
{
    int32_t at_fault;

    r.rig.left_out = NULL;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&r.choice, &at_fault, &r.rig));
    return rigcal_rig_judge(&r.judgement, &at_fault, r.judged, r.left_out, &r.choice,
                            &r.rig);
}

static void solve_all(const char *set)
{
    read_set(set);
    for (size_t v = 0; v < r.rig.n_views; v++) {
        solve(v);
    }
}

/* `scale`: the limit as a multiple of that for noise. */
static void assert_no_view_is_named(const char *set, double scale)
{
    solve_all(set);
    ASSERT_STATUS(RIGCAL_OK, judge());
    TEST_ASSERT_EQUAL_INT32((int32_t)r.rig.n_views,
                            r.judgement.n_fit + r.judgement.n_unchecked);
    ASSERT_NEAR(scale, r.judgement.scale, 0.1 * scale);
}

static void test_of_the_sets_as_they_are_no_view_is_named(void)
{
    assert_no_view_is_named("opencv_stereo", 1 + 10 * 3.15); /* M is 4.15 */
    assert_no_view_is_named("myptv_stepped", 1);
    assert_no_view_is_named("openptv_cavity", 1);
}

static void reverse(size_t v)
{
    rigcal_observation *const o = &r.o[r.views[v].view.observations - r.o];
    const size_t n = r.views[v].view.n;

    for (size_t i = 0; i < n / 2; i++) {
        rigcal_real uv[2];

        memcpy(uv, o[i].uv, sizeof uv);
        memcpy(o[i].uv, o[n - 1 - i].uv, sizeof uv);
        memcpy(o[n - 1 - i].uv, uv, sizeof uv);
    }
    solve(v);
}

/* The permutation that turns the board of 54 corners. */
static int32_t turn[54];

static rigcal_symmetries symmetries(void)
{
    for (int32_t i = 0; i < 54; i++) {
        turn[i] = 53 - i;
    }
    return (rigcal_symmetries){turn, 1, 54, r.room};
}

static void test_each_view_of_the_stereo_set_in_reverse_is_told(void)
{
    solve_all("opencv_stereo");
    const rigcal_symmetries known = symmetries();

    TEST_ASSERT_EQUAL_UINT64(14, r.rig.n_views);
    for (size_t v = 0; v < 14; v++) {
        const size_t partner = v ^ 1;
        rigcal_cause cause;

        reverse(v);
        ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, judge());
        TEST_ASSERT_EQUAL_INT32(2, r.judgement.n_one_of_two);
        TEST_ASSERT_EQUAL_INT32(12, r.judgement.n_fit);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_ONE_OF_TWO, r.judged[v].verdict);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_ONE_OF_TWO, r.judged[partner].verdict);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_cause(&cause, &r.rig, &r.judgement, &known, v));
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(0, cause.permutation);
        /* The rig must be that of the other placements. */
        rigcal_rig_fit fit;
        const rigcal_transform judged = r.cams[1];
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, NULL));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
        ASSERT_TRANSFORM(&r.cams[1], &judged, TOL(1e-6, 1e-5), TOL(1e-6, 1e-5));
        reverse(v);
    }
}

static void test_all_views_of_a_camera_in_reverse_are_told(void)
{
    solve_all("opencv_stereo");
    const rigcal_symmetries known = symmetries();
    const rigcal_judgement plain = {.sigma_px = RC(0.3), .scale = 5};

    for (size_t v = 1; v < 14; v += 2) {
        reverse(v);
    }
    ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION, rigcal_rig_choose(&r.choice, NULL, &r.rig));
    for (size_t c = 0; c < 2; c++) {
        rigcal_cause cause;

        memset(r.left_out, 1, sizeof r.left_out);
        r.rig.left_out = r.left_out;
        r.cams[0] = r.cams[1] = test_turned_about((const double[3]){1, 0, 0}, 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_cause(&cause, &r.rig, &plain, &known, c));
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(0, cause.permutation);
        TEST_ASSERT_TRUE(cause.n_agree >= 6);
        TEST_ASSERT_EQUAL_INT32(7, cause.n_views);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_of_the_sets_as_they_are_no_view_is_named);
    RUN_TEST(test_each_view_of_the_stereo_set_in_reverse_is_told);
    RUN_TEST(test_all_views_of_a_camera_in_reverse_are_told);
}
