/* calibrated: what is kept of an adjusted rig, and the functions for it. The covariance of
 * a pair is compared with that of the rig, and with differences. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rc_calibrated.h"
#include "test_fit.h"
#include "test_rigs.h"

enum { N = 4, FREE = 3 };

static test_rig r;
static rigcal_rig_fit fit;
static rigcal_mounted_camera cameras[N];
static int32_t group[N];
static uint8_t held[N];
static rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(N)];
static rigcal_calibrated_rig kept;

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 24000)

static void clear(void)
{
    memset(cameras, 0, sizeof cameras);
    kept.cameras = cameras;
    kept.group = group;
    kept.held = held;
    kept.capacity = N;
    kept.Sigma = Sigma;
    kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(FREE);
    FILL(group);
    FILL(held);
    FILL(Sigma);
}

static void make_adjusted(void)
{
    test_rng rng = test_seed(361);

    test_rig_random(&r, &rng, N, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    clear();
}

static void take(double sigma_px)
{
    for (size_t c = 0; c < r.rig.n_cameras; c++) {
        cameras[c].camera = r.camera[c];
        FILL(cameras[c].Sigma);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_take(&kept, &r.rig, &fit, RC(sigma_px)));
}

static void assert_same(const rigcal_real expected[], const rigcal_real actual[], size_t n)
{
    for (size_t k = 0; k < n; k++) {
        ASSERT_NEAR(D(expected[k]), actual[k], TOL(1e-12, 1e-5) * fabs(D(expected[k])));
    }
}

/* ---- what is taken -------------------------------------------------------- */

static void test_cameras_are_as_in_the_rig(void)
{
    WANTS_RIG;
    make_adjusted();
    take(0.25);
    TEST_ASSERT_EQUAL_UINT64(N, kept.n_cameras);
    for (size_t c = 0; c < N; c++) {
        rigcal_real expected[36], own[36];

        TEST_ASSERT_EQUAL_MEMORY(&r.cams[c], &cameras[c].cam_from_rig, sizeof r.cams[c]);
        TEST_ASSERT_EQUAL_MEMORY(&r.camera[c], &cameras[c].camera, sizeof r.camera[c]);
        TEST_ASSERT_EQUAL_INT(c == 0, held[c]);
        TEST_ASSERT_EQUAL_INT32(0, group[c]);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(expected, &r.rig, RC(0.25), c));
        ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_covariance(own, &kept, c, c));
        assert_same(expected, own, 36);
        assert_same(expected, cameras[c].Sigma, 36);
        TEST_ASSERT_EQUAL_INT32(1, cameras[c].has_Sigma);
    }
    ASSERT_NEAR(0.25, kept.sigma_px, 0);
    ASSERT_NEAR(D(fit.F), kept.F, 0);
    ASSERT_NEAR(D(fit.freedom_between), kept.freedom_between, 0);
    ASSERT_NEAR(D(fit.freedom_within), kept.freedom_within, 0);
    TEST_ASSERT_TRUE(D(kept.F) > 0);
}

static void test_pairs_are_those_of_the_rig(void)
{
    WANTS_RIG;
    make_adjusted();
    take(0.25);
    for (size_t a = 0; a < N; a++) {
        for (size_t b = 0; b < N; b++) {
            rigcal_transform expected, pair;
            rigcal_real of_rig[36], of_kept[36];

            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_pair(&expected, of_rig, &r.rig, RC(0.25), a, b));
            ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_pair(&pair, of_kept, &kept, a, b));
            TEST_ASSERT_EQUAL_MEMORY(&expected, &pair, sizeof pair);
            for (size_t k = 0; a != b && k < 36; k++) {
                const double scale = sqrt(D(of_rig[k / 6 * 7]) * D(of_rig[k % 6 * 7]));

                ASSERT_NEAR(D(of_rig[k]), of_kept[k], TOL(1e-11, 1e-4) * scale);
            }
        }
    }
}

/* J Sigma J^T. J is the derivative of b_from_a by differences; Sigma belongs to both
 * cameras. */
static void test_a_pair_has_the_covariance_that_differences_give(void)
{
    enum { A = 1, B = 3 };
    const double h = 1e-5;
    double J[2][6][6], expected[36] = {0};
    rigcal_transform pair, moved[2];
    rigcal_real of_kept[36];

    WANTS_RIG;
    make_adjusted();
    take(0.25);
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_pair(&pair, of_kept, &kept, A, B));
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < 6; k++) {
            double d[2][6];

            for (int sign = 0; sign < 2; sign++) {
                double step[6] = {0}, aR[9], at[3], bR[9], bt[3], R[9], t[3], aRt[9];
                rigcal_transform found;

                step[k] = sign ? -TOL(h, 1e-2) : TOL(h, 1e-2);
                moved[0] = r.cams[A];
                moved[1] = r.cams[B];
                moved[side] = test_moved(&moved[side], step);
                test_to_double(aR, moved[0].R, 9);
                test_to_double(at, moved[0].t, 3);
                test_to_double(bR, moved[1].R, 9);
                test_to_double(bt, moved[1].t, 3);
                test_transpose(aRt, aR);
                test_product(R, bR, aRt);
                for (int i = 0; i < 3; i++) {
                    t[i] = bt[i] - R[3 * i] * at[0] - R[3 * i + 1] * at[1] -
                           R[3 * i + 2] * at[2];
                }
                found = test_transform(R, t);
                test_step_between(d[sign], &found, &pair);
            }
            for (int i = 0; i < 6; i++) {
                J[side][i][k] = (d[0][i] - d[1][i]) / (2 * TOL(h, 1e-2));
            }
        }
    }
    for (int p = 0; p < 2; p++) {
        for (int q = 0; q < 2; q++) {
            rigcal_real S[36];

            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_calibrated_covariance(S, &kept, p ? B : A, q ? B : A));
            for (int i = 0; i < 36; i++) {
                for (int k = 0; k < 36; k++) {
                    expected[i] += J[p][i / 6][k / 6] * D(S[k]) * J[q][i % 6][k % 6];
                }
            }
        }
    }
    for (int i = 0; i < 36; i++) {
        const double scale = sqrt(expected[i / 6 * 7] * expected[i % 6 * 7]);

        ASSERT_NEAR(expected[i], of_kept[i], TOL(1e-6, 2e-3) * scale);
    }
}

static void test_the_covariance_of_two_cameras_turns_over_with_them(void)
{
    rigcal_real of_ab[36], of_ba[36];
    double largest = 0;

    WANTS_RIG;
    make_adjusted();
    take(1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_covariance(of_ab, &kept, 1, 2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_covariance(of_ba, &kept, 2, 1));
    for (int i = 0; i < 36; i++) {
        ASSERT_NEAR(D(of_ab[i]), of_ba[i % 6 * 6 + i / 6], 0);
        largest = fmax(largest, fabs(D(of_ab[i])));
    }
    TEST_ASSERT_TRUE(largest > 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_covariance(of_ab, &kept, 0, 2));
    for (int i = 0; i < 36; i++) {
        ASSERT_NEAR(0, of_ab[i], 0);
    }
}

static void test_cameras_of_two_groups_have_no_pair(void)
{
    test_rng rng = test_seed(362);
    rigcal_transform pair;
    rigcal_real of_kept[36];

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 2, 8);
    test_rig_see(&r, &rng, 0, 0, 0.3);
    test_rig_see(&r, &rng, 2, 0, 0.3);
    test_rig_see(&r, &rng, 1, 1, 0.3);
    test_rig_see(&r, &rng, 3, 1, 0.3);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, rigcal_rig_adjust(&fit, NULL, &r.rig));
    clear();
    kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(2);
    take(1);
    TEST_ASSERT_EQUAL_INT(1, held[1]);
    TEST_ASSERT_EQUAL_INT32(1, group[3]);
    ASSERT_REFUSED(RIGCAL_DISCONNECTED, pair,
                   rigcal_calibrated_pair(&pair, of_kept, &kept, 0, 3));
    ASSERT_REFUSED(RIGCAL_DISCONNECTED, of_kept,
                   rigcal_calibrated_pair(&pair, of_kept, &kept, 0, 3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_pair(&pair, of_kept, &kept, 3, 1));
}

static void test_without_a_fit_the_closure_is_not_known(void)
{
    WANTS_RIG;
    make_adjusted();
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_take(&kept, &r.rig, NULL, 1));
    ASSERT_NEAR(0, kept.F, 0);
    ASSERT_NEAR(0, kept.freedom_between, 0);
    ASSERT_NEAR(0, kept.freedom_within, 0);
}

/* ---- what is refused ------------------------------------------------------ */

static void assert_not_taken(rigcal_status expected, double sigma_px)
{
    const rigcal_calibrated_rig before = kept;

    FILL(cameras);
    ASSERT_STATUS(expected, rigcal_calibrated_take(&kept, &r.rig, &fit, RC(sigma_px)));
    ASSERT_UNTOUCHED(cameras);
    ASSERT_UNTOUCHED(group);
    ASSERT_UNTOUCHED(held);
    ASSERT_UNTOUCHED(Sigma);
    TEST_ASSERT_EQUAL_MEMORY(&before, &kept, sizeof kept);
}

static void test_what_cannot_be_taken_is_refused_and_nothing_written(void)
{
    WANTS_RIG;
    make_adjusted();
    assert_not_taken(RIGCAL_ERR_RANGE, 0);
    assert_not_taken(RIGCAL_ERR_RANGE, -1);
    assert_not_taken(RIGCAL_ERR_NOT_FINITE, test_nan());
    kept.capacity = N - 1;
    assert_not_taken(RIGCAL_ERR_CAPACITY, 1);
    kept.capacity = N;
    kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(FREE) - 1;
    assert_not_taken(RIGCAL_ERR_CAPACITY, 1);
    kept.Sigma_capacity++;
    kept.Sigma = NULL;
    assert_not_taken(RIGCAL_ERR_NULL, 1);
    kept.Sigma = Sigma;
    kept.held = NULL;
    assert_not_taken(RIGCAL_ERR_NULL, 1);
    kept.held = held;
    memset(r.work, 0, sizeof r.work);
    assert_not_taken(RIGCAL_ERR_STATE, 1);
}

/* Whichever camera is held, the others are free, also the first. That the focal length of
 * one is not exact takes no more room. */
static void test_any_camera_may_be_the_one_that_is_held(void)
{
    rigcal_intrinsics_sigma sigmas[N];
    rigcal_real effects[6 * FREE + 6];
    rigcal_considered considered = {.effects = effects, .capacity = 6 * FREE + 6};

    WANTS_RIG;
    memset(sigmas, 0, sizeof sigmas);
    sigmas[1].focal = RC(0.001);
    for (size_t trial = 0; trial < 2 * N; trial++) {
        const size_t which = trial / 2;
        test_rng rng = test_seed(364);

        test_rig_random(&r, &rng, N, 4, 8);
        test_rig_see_all(&r, &rng, 0.3);
        memset(r.roles, RIGCAL_CAMERA_FREE, sizeof r.roles);
        r.roles[which] = RIGCAL_CAMERA_HELD;
        r.rig.roles = r.roles;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
        if (trial % 2) {
            r.rig.intrinsics_sigmas = sigmas;
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
        }
        clear();
        kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(FREE) - 1;
        assert_not_taken(RIGCAL_ERR_CAPACITY, 1);
        kept.Sigma_capacity++;
        take(1);
        for (size_t c = 0; c < N; c++) {
            rigcal_real expected[36];

            TEST_ASSERT_EQUAL_INT(c == which, held[c]);
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(expected, &r.rig, 1, c));
            TEST_ASSERT_EQUAL_INT(c != which, expected[0] > 0);
            for (int k = 0; k < 36; k++) {
                const double scale = sqrt(D(expected[k / 6 * 7]) * D(expected[k % 6 * 7]));

                ASSERT_NEAR(D(expected[k]), cameras[c].Sigma[k], TOL(1e-12, 1e-5) * scale);
            }
        }
    }
}

/* Two cameras see the target; all others of the rig are held as well. */
static void test_the_most_cameras_are_taken(void)
{
    enum { MOST = 65535 };
    rigcal_calibrated_rig most = {0};
    test_rng rng = test_seed(362);

    TEST_ON_HOST_ONLY("it takes 70 MB");
    test_rig_random(&r, &rng, 2, 1, 8);
    test_rig_see_all(&r, &rng, 0.3);
    r.rig.work_capacity = rigcal_rig_work(0, MOST + 1, 1);
    r.rig.work = malloc(r.rig.work_capacity * sizeof *r.rig.work);
    r.rig.cams_from_rig = malloc((MOST + 1) * sizeof *r.rig.cams_from_rig);
    r.rig.group = malloc((MOST + 1) * sizeof *r.rig.group);
    uint8_t *const roles = malloc(MOST + 1);
    most.cameras = calloc(MOST + 1, sizeof *most.cameras);
    most.group = malloc((MOST + 1) * sizeof *most.group);
    most.held = malloc(MOST + 1);
    most.capacity = MOST + 1;
    most.Sigma = Sigma;
    TEST_ASSERT_TRUE(r.rig.work && r.rig.cams_from_rig && r.rig.group && roles &&
                     most.cameras && most.group && most.held);
    for (size_t c = 0; c <= MOST; c++) {
        r.rig.cams_from_rig[c] = r.true_cams[c % 2];
        roles[c] = RIGCAL_CAMERA_HELD;
    }
    r.rig.roles = roles;
    for (int more = 1; more >= 0; more--) {
        r.rig.n_cameras = (size_t)(MOST + more);
        TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, NULL, &r.rig) >= 0);
        ASSERT_STATUS(more ? RIGCAL_ERR_RANGE : RIGCAL_OK,
                      rigcal_calibrated_take(&most, &r.rig, &fit, 1));
        TEST_ASSERT_EQUAL_size_t(more ? 0 : MOST, most.n_cameras);
    }
    TEST_ASSERT_EQUAL_UINT8(1, most.held[MOST - 1]);
    free(most.held);
    free(most.group);
    free(most.cameras);
    free(roles);
    free(r.rig.group);
    free(r.rig.cams_from_rig);
    free(r.rig.work);
}

/* A line for each thing that a caller may have filled in wrongly. */
static void test_a_rig_that_is_not_valid_is_not_asked(void)
{
    rigcal_real block[36];
    size_t n_free;

    WANTS_RIG;
#define REFUSES(status, change) \
    make_adjusted(); \
    take(1); \
    ASSERT_STATUS(RIGCAL_OK, rc_calibrated_check(&n_free, &kept)); \
    change; \
    ASSERT_REFUSED(status, block, rigcal_calibrated_covariance(block, &kept, 1, 2))
    REFUSES(RIGCAL_ERR_NULL, kept.cameras = NULL);
    REFUSES(RIGCAL_ERR_NULL, kept.group = NULL);
    REFUSES(RIGCAL_ERR_NULL, kept.held = NULL);
    REFUSES(RIGCAL_ERR_NULL, kept.Sigma = NULL);
    REFUSES(RIGCAL_ERR_TOO_FEW, kept.n_cameras = 0);
    REFUSES(RIGCAL_ERR_RANGE, kept.n_cameras = 65536);
    REFUSES(RIGCAL_ERR_CAPACITY, kept.n_cameras = 65535);
    REFUSES(RIGCAL_ERR_CAPACITY, kept.n_cameras = N + 1);
    REFUSES(RIGCAL_ERR_RANGE, kept.n_cameras = 2);
    REFUSES(RIGCAL_ERR_RANGE, held[3] = 2);
    REFUSES(RIGCAL_ERR_CAPACITY, held[0] = 0);
    REFUSES(RIGCAL_ERR_RANGE, group[0] = 1);
    REFUSES(RIGCAL_ERR_RANGE, group[2] = 2);
    REFUSES(RIGCAL_ERR_RANGE, group[2] = -1);
    REFUSES(RIGCAL_ERR_STATE, kept.sigma_px = 0);
    REFUSES(RIGCAL_ERR_RANGE, kept.sigma_px = -1);
    REFUSES(RIGCAL_ERR_RANGE, kept.F = -1);
    REFUSES(RIGCAL_ERR_NOT_FINITE, kept.freedom_between = TEST_NAN);
    REFUSES(RIGCAL_ERR_RANGE, kept.freedom_within = -1);
    REFUSES(RIGCAL_ERR_NOT_FINITE, Sigma[rc_packed_at(7, 2)] = TEST_INF);
#undef REFUSES
    make_adjusted();
    take(1);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, block,
                   rigcal_calibrated_covariance(block, &kept, N, 0));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, block,
                   rigcal_calibrated_covariance(block, &kept, 0, N));
}

/* The joint covariance of 3801 free cameras cannot be stored. */
static void test_too_many_free_cameras_are_refused(void)
{
    enum { MANY = TEST_HOST ? RIGCAL_STORE_FREE_MAX + 1 : 1 };
    static int32_t no_group[MANY];
    static uint8_t none_held[MANY];
    rigcal_real block[36];

    TEST_ON_HOST_ONLY("28 KB of cameras");
    make_adjusted();
    take(1);
    kept.n_cameras = kept.capacity = MANY;
    kept.group = no_group;
    kept.held = none_held;
    kept.Sigma_capacity = SIZE_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, block,
                   rigcal_calibrated_covariance(block, &kept, 1, 2));
    size_t n_free; /* one fewer can, and so can one that is held */
    kept.n_cameras = MANY - 1;
    ASSERT_STATUS(RIGCAL_OK, rc_calibrated_check(&n_free, &kept));
    TEST_ASSERT_EQUAL(RIGCAL_STORE_FREE_MAX, n_free);
    kept.n_cameras = MANY;
    none_held[5] = 1;
    ASSERT_STATUS(RIGCAL_OK, rc_calibrated_check(&n_free, &kept));
    TEST_ASSERT_EQUAL(RIGCAL_STORE_FREE_MAX, n_free);
    kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE((size_t)RIGCAL_STORE_FREE_MAX) - 1;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rc_calibrated_check(&n_free, &kept));
    none_held[5] = 0;
}

/* An adjusted rig of 65536 cameras, all but the first two held and unseen. */
static void test_a_rig_of_too_many_cameras_is_not_taken(void)
{
    const size_t n = RIGCAL_STORE_CAMERAS_MAX + (size_t)1;
    const size_t work = rigcal_rig_work(1, n, 4);
    test_rng rng = test_seed(362);

    TEST_ON_HOST_ONLY("20 MB of cameras");
    test_rig_random(&r, &rng, 2, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    r.rig.n_cameras = n;
    r.rig.cams_from_rig = calloc(n, sizeof *r.rig.cams_from_rig);
    r.rig.group = calloc(n, sizeof *r.rig.group);
    r.rig.work = calloc(work, sizeof *r.rig.work);
    r.rig.work_capacity = work;
    uint8_t *const roles = malloc(n);
    for (size_t c = 0; c < n; c++) {
        r.rig.cams_from_rig[c] = r.true_cams[c == 1];
        roles[c] = c == 1 ? RIGCAL_CAMERA_FREE : RIGCAL_CAMERA_HELD;
    }
    r.rig.roles = roles;
    ASSERT_STATUS(RIGCAL_DISCONNECTED, rigcal_rig_adjust(&fit, NULL, &r.rig));
    clear();
    assert_not_taken(RIGCAL_ERR_RANGE, 1);
    free(r.rig.cams_from_rig);
    free(r.rig.group);
    free(r.rig.work);
    free(roles);
}

/* The unknowns of a camera begin after those of the cameras before it that are not held,
 * whichever are. */
static void test_unknowns_begin_after_those_of_free_cameras(void)
{
    for (int roles = 0; roles < 1 << N; roles++) {
        int before = 0;

        clear();
        kept.n_cameras = N;
        for (int c = 0; c < N; c++) {
            held[c] = (uint8_t)(roles >> c & 1);
        }
        for (int c = 0; c < N; c++) {
            const rigcal_real first = rc_calibrated_first(&kept, (size_t)c);
            if (held[c]) {
                TEST_ASSERT_TRUE(first < 0);
            } else {
                ASSERT_NEAR(before, first, 0);
                before += 6;
            }
        }
    }
}

static void test_a_rig_of_one_camera_can_be_taken(void)
{
    test_rng rng = test_seed(363);

    WANTS_RIG;
    test_rig_random(&r, &rng, 1, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    clear();
    take(0.5);
    TEST_ASSERT_EQUAL(1, kept.n_cameras);
    TEST_ASSERT_EQUAL(1, held[0]);
    TEST_ASSERT_EQUAL(0, group[0]);
    ASSERT_NEAR(0.5, kept.sigma_px, 0);
    ASSERT_NEAR(D(fit.F), kept.F, 0);
    for (size_t k = 0; k < 36; k++) {
        ASSERT_NEAR(0, cameras[0].Sigma[k], 0);
    }
}

/* One camera is a rig, held or free. */
static void test_one_camera_is_enough(void)
{
    rigcal_real block[36];
    size_t n_free;

    WANTS_RIG;
    make_adjusted();
    take(1);
    kept.n_cameras = 1;
    ASSERT_STATUS(RIGCAL_OK, rc_calibrated_check(&n_free, &kept));
    TEST_ASSERT_EQUAL(0, n_free);
    held[0] = 0;
    ASSERT_STATUS(RIGCAL_OK, rc_calibrated_check(&n_free, &kept));
    TEST_ASSERT_EQUAL(1, n_free);
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_covariance(block, &kept, 0, 0));
    for (size_t k = 0; k < 36; k++) {
        const size_t row = k / 6, column = k % 6;
        ASSERT_NEAR(
            D(Sigma[row > column ? rc_packed_at(row, column) : rc_packed_at(column, row)]),
            block[k], 0);
    }
}

static void test_a_pair_of_poses_that_are_none_is_refused(void)
{
    rigcal_transform pair;
    rigcal_real of_kept[36];

    WANTS_RIG;
    make_adjusted();
    take(1);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_calibrated_pair(NULL, of_kept, &kept, 1, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_calibrated_pair(&pair, NULL, &kept, 1, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_calibrated_pair(&pair, of_kept, NULL, 1, 2));
    cameras[2].cam_from_rig.R[0] = 3;
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, pair,
                   rigcal_calibrated_pair(&pair, of_kept, &kept, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, of_kept,
                   rigcal_calibrated_pair(&pair, of_kept, &kept, 2, 1));
}

static void test_the_size_is_that_of_a_triangle(void)
{
    for (size_t n = 0; n < 20; n++) {
        size_t count = 0;

        for (size_t i = 0; i < 6 * n; i++) {
            count += i + 1;
        }
        TEST_ASSERT_EQUAL_size_t(count, rigcal_calibrated_size(n));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_cameras_are_as_in_the_rig);
    RUN_TEST(test_pairs_are_those_of_the_rig);
    RUN_TEST(test_a_pair_has_the_covariance_that_differences_give);
    RUN_TEST(test_the_covariance_of_two_cameras_turns_over_with_them);
    RUN_TEST(test_cameras_of_two_groups_have_no_pair);
    RUN_TEST(test_without_a_fit_the_closure_is_not_known);
    RUN_TEST(test_what_cannot_be_taken_is_refused_and_nothing_written);
    RUN_TEST(test_any_camera_may_be_the_one_that_is_held);
    RUN_TEST(test_the_most_cameras_are_taken);
    RUN_TEST(test_a_rig_that_is_not_valid_is_not_asked);
    RUN_TEST(test_too_many_free_cameras_are_refused);
    RUN_TEST(test_a_rig_of_too_many_cameras_is_not_taken);
    RUN_TEST(test_unknowns_begin_after_those_of_free_cameras);
    RUN_TEST(test_a_rig_of_one_camera_can_be_taken);
    RUN_TEST(test_one_camera_is_enough);
    RUN_TEST(test_a_pair_of_poses_that_are_none_is_refused);
    RUN_TEST(test_the_size_is_that_of_a_triangle);
}
