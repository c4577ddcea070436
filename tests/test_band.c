/* band: where the match of a pixel can be in another image. The truth is made with the
 * derivatives of (M3), one by one, in double (support/test_bands.h). */
#include <math.h>
#include <string.h>

#include "rc_real.h"
#include "test_bands.h"

static test_bands scene;
static rigcal_band band;

/* ---- how wide -------------------------------------------------------------- */

/* SciPy 1.10: norm.isf((1 - P) / 2), sqrt(chi2.isf(1 - P, 2)). */
static const double QUANTILES[][3] = {
    {0.001, 0.00125331446543242, 0.04473254594998},
    {0.1, 0.125661346855074, 0.459043605026421},
    {0.5, 0.674489750196082, 1.17741002251547},
    {0.84, 1.40507156030963, 1.91446152416198},
    {0.86, 1.47579102817917, 1.98298404248387},
    {0.9, 1.64485362695147, 2.14596602628935},
    {0.95, 1.95996398454005, 2.44774683068082},
    {0.99, 2.5758293035489, 3.03485425877029},
    {0.999, 3.29052673149189, 3.71692218884984},
    {0.999999, 4.89163847569293, 5.25652176975146},
};

static void test_k_is_the_quantile(void)
{
    for (size_t i = 0; i < sizeof QUANTILES / sizeof *QUANTILES; i++) {
        const double *const row = QUANTILES[i];
        /* In float 1 - P has an error of up to 3e-8. */
        const double tol = TOL(1e-11, 1e-6 + 3e-8 / (1 - row[0]));
        rigcal_real k;

        ASSERT_STATUS(RIGCAL_OK, rigcal_match_k(&k, RC(row[0]), RIGCAL_MATCH_SEARCH));
        ASSERT_NEAR(row[1], k, tol * row[1]);
        ASSERT_STATUS(RIGCAL_OK, rigcal_match_k(&k, RC(row[0]), RIGCAL_MATCH_DRAW));
        ASSERT_NEAR(row[2], k, tol * row[2] * fmax(1, 1 / row[0] * TOL(0.1, 0.1)));
    }
}

/* ---- rays ------------------------------------------------------------------ */

static void test_rays_turn_as_differences_of_pixels_say(void)
{
    test_rng rng = test_seed(4301);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        const rigcal_camera camera = test_lens_random(&rng, trial % TEST_LENS_KINDS, 800);
        const rigcal_real uv[2] = {RC(test_uniform(&rng, 0, camera.width)),
                                   RC(test_uniform(&rng, 0, camera.height))};
        test_ray truth;
        rigcal_ray ray;

        TEST_ASSERT_TRUE(test_ray_of(&truth, &camera, uv));
        ASSERT_STATUS(RIGCAL_OK, rigcal_ray_make(&ray, &camera, uv));
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(truth.m[k], ray.m[k], TOL(1e-15, 1e-7));
            ASSERT_NEAR(truth.D[0][k], ray.D[2 * k], TOL(1e-7, 1e-4) / D(camera.fx));
            ASSERT_NEAR(truth.D[1][k], ray.D[2 * k + 1], TOL(1e-7, 1e-4) / D(camera.fx));
        }
    }
}

/* ---- a candidate ----------------------------------------------------------- */

static void assert_match(const test_band_truth *truth, const rigcal_match *match)
{
    const double tol = TOL(1e-6, 2e-3), width = sqrt(truth->variance) / truth->slope;

    ASSERT_NEAR(truth->s / truth->slope, match->distance_px,
                tol * (width + TOL(1e-3, 1) * fabs(truth->s / truth->slope)) +
                    TOL(1e-9, 1e-3));
    ASSERT_NEAR(D(scene.pair.k) * width, match->half_width_px, tol * 3 * width);
    ASSERT_NEAR(truth->chi2, match->chi2, tol * (1 + truth->chi2));
    ASSERT_NEAR(truth->chi2 + log(width * width), match->score, tol * (4 + truth->chi2));
    ASSERT_NEAR(truth->depth_a, match->depth_a,
                TOL(1e-7, 1e-3) * truth->depth_a *
                    fmax(1, truth->depth_a)); /* the farther the point, the less parallax */
    if (truth->margin > TOL(1e-6, 1e-2)) {
        TEST_ASSERT_EQUAL_INT32(truth->is_inside, match->is_inside);
    }
}

static void test_what_a_band_says_of_a_pixel_is_true(void)
{
    test_rng rng = test_seed(4302);
    int tested = 0, inside = 0, behind = 0;

    for (int trial = 0; trial < TEST_TRIALS(4000); trial++) {
        test_ray a, b;
        test_band_truth truth;
        rigcal_match match;

        if (trial % 20 == 0) {
            test_bands_random(&scene, &rng, trial / 20 % TEST_LENS_KINDS, 120);
            if (rigcal_band_make(&band, &scene.pair, scene.uv_a) != RIGCAL_OK) {
                trial += 19;
                continue;
            }
        }
        const rigcal_real uv[2] = {RC(test_uniform(&rng, 0, scene.b.width)),
                                   RC(test_uniform(&rng, 0, scene.b.height))};
        TEST_ASSERT_TRUE(test_ray_of(&a, &scene.a, scene.uv_a));
        TEST_ASSERT_TRUE(test_ray_of(&b, &scene.b, uv));
        test_band_look(&truth, &scene, &a, &b);
        const rigcal_status status = rigcal_band_test(&match, &band, uv);

        if (status == RIGCAL_ERR_EPIPOLE) {
            continue;
        }
        if (fabs(truth.ahead) > 1e-4) {
            TEST_ASSERT_EQUAL_INT(truth.ahead > 0 ? RIGCAL_OK : RIGCAL_ERR_BEHIND, status);
        }
        if (status == RIGCAL_OK) {
            assert_match(&truth, &match);
            TEST_ASSERT_EQUAL_INT32(0, match.index);
            tested++;
            inside += match.is_inside;
        }
        behind += status == RIGCAL_ERR_BEHIND;
    }
    TEST_ASSERT_TRUE(tested > TEST_TRIALS(1000) / 2 && behind > TEST_TRIALS(500) / 2);
    TEST_ASSERT_TRUE(inside > 60 || TEST_ONE_IN > 1);
}

static void test_rays_and_pixels_say_the_same(void)
{
    test_rng rng = test_seed(4303);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_ray ray_a, ray_b;
        rigcal_band of_ray;
        rigcal_match by_pixel, by_ray;

        test_bands_random(&scene, &rng, trial % TEST_LENS_KINDS, 640);
        const rigcal_real uv[2] = {RC(scene.b.width / 3), RC(scene.b.height / 4)};
        ASSERT_STATUS(RIGCAL_OK, rigcal_ray_make(&ray_a, &scene.a, scene.uv_a));
        ASSERT_STATUS(RIGCAL_OK, rigcal_ray_make(&ray_b, &scene.b, uv));
        const rigcal_status made = rigcal_band_make(&band, &scene.pair, scene.uv_a);

        memset(&of_ray, 0, sizeof of_ray);
        TEST_ASSERT_EQUAL_INT(made, rigcal_band_make_ray(&of_ray, &scene.pair, &ray_a));
        if (made != RIGCAL_OK) {
            continue;
        }
        TEST_ASSERT_EQUAL_MEMORY(&band, &of_ray, sizeof band);
        memset(&by_pixel, 0, sizeof by_pixel);
        memset(&by_ray, 0, sizeof by_ray);
        TEST_ASSERT_EQUAL_INT(rigcal_band_test(&by_pixel, &band, uv),
                              rigcal_band_test_ray(&by_ray, &band, &ray_b));
        TEST_ASSERT_EQUAL_MEMORY(&by_pixel, &by_ray, sizeof by_ray);
    }
}

/* ---- where there is no answer ---------------------------------------------- */

/* Two pinholes of 500 px. The centre of b is at `centre` of a; both look the same way. */
static rigcal_camera pinhole;

static void look_the_same_way(const double centre[3], double sigma_px)
{
    double t[3];

    memset(&pinhole, 0, sizeof pinhole);
    pinhole.width = 640;
    pinhole.height = 480;
    pinhole.fx = pinhole.fy = 500;
    pinhole.cx = 320;
    pinhole.cy = 240;
    memset(&scene.pair, 0, sizeof scene.pair);
    for (int k = 0; k < 3; k++) {
        t[k] = -centre[k];
    }
    scene.pair.camera_a = scene.pair.camera_b = &pinhole;
    scene.pair.b_from_a = test_transform(NULL, t);
    scene.pair.sigma_a = scene.pair.sigma_b = RC(sigma_px);
    scene.pair.k = 2;
}

/* Camera b is in front of a: each sees the other's centre at (320, 240). With 0.5 px, 3
 * standard deviations are 1.5 px. */
static void test_near_the_epipole_of_a_there_is_no_band(void)
{
    static const double before[3] = {0, 0, 1};

    look_the_same_way(before, 0.5);
    for (int i = 0; i < 8; i++) {
        const double c = cos(i * TEST_PI / 4), s = sin(i * TEST_PI / 4);
        const rigcal_real close[2] = {RC(320 + 1.48 * c), RC(240 + 1.48 * s)};
        const rigcal_real off[2] = {RC(320 + 1.52 * c), RC(240 + 1.52 * s)};

        ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, band,
                       rigcal_band_make(&band, &scene.pair, close));
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, off));
    }
    scene.pair.k = 6; /* a wider band needs a more certain line */
    const rigcal_real off[2] = {RC(322), 240};
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, band, rigcal_band_make(&band, &scene.pair, off));
}

/* The direction of t is uncertain by 0.01 rad = 5 px sideways, and so is the band. */
static void test_a_calibration_that_is_unsure_widens_the_epipole(void)
{
    static const double before[3] = {0, 0, 1};
    const rigcal_real off[2] = {RC(330), 240};

    look_the_same_way(before, 0.5);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, off));
    scene.pair.Sigma[21] = RC(1e-4);
    scene.pair.Sigma[28] = RC(1e-4);
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, band, rigcal_band_make(&band, &scene.pair, off));
}

static void test_near_the_epipole_of_b_a_candidate_has_no_depth(void)
{
    static const double before[3] = {0, 0, 1};
    const rigcal_real uv_a[2] = {330, 240}, close[2] = {RC(321.4), 240},
                      behind[2] = {300, 240};
    const rigcal_real off[2] = {RC(321.6), 240}, beyond[2] = {400, 240};
    rigcal_match match;

    look_the_same_way(before, 0.5);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv_a));
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, match, rigcal_band_test(&match, &band, close));
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, match, rigcal_band_test(&match, &band, off));
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, match, rigcal_band_test(&match, &band, behind));
    /* X = 1/50 Z in a, 8/50 (Z - 1) in b */
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_test(&match, &band, beyond));
    ASSERT_NEAR(8.0 / 7 * hypot(1, 0.02), match.depth_a, TOL(1e-12, 1e-5));
}

/* A ray near the direction of t, from which it is `sines` standard deviations away. A pixel
 * turns it by columns of D across it, in any way. The largest variance of a direction
 * across is looked for among all. */
static rigcal_status test_beside_t(double sines, test_rng *rng)
{
    double t[3], across[2][3], D_0[3], D_1[3], largest = 0;
    rigcal_match match;
    rigcal_ray ray;

    for (int k = 0; k < 3; k++) {
        t[k] = D(band.along) * D(band.ray[k]) + D(band.across) * D(band.towards[k]);
        across[1][k] = test_normal(rng);
    }
    test_cross(across[0], t, across[1]);
    test_cross(across[1], t, across[0]);
    const double by_t = 1 / test_norm(t),
                 by[2] = {1 / test_norm(across[0]), 1 / test_norm(across[1])};
    const double a = 2e-3 * test_normal(rng), b = 2e-3 * test_normal(rng);
    const double c = 2e-3 * test_normal(rng), d = 2e-3 * test_normal(rng);

    for (int k = 0; k < 3; k++) {
        D_0[k] = a * by[0] * across[0][k] + b * by[1] * across[1][k];
        D_1[k] = c * by[0] * across[0][k] + d * by[1] * across[1][k];
        ray.D[2 * k] = RC(D_0[k]);
        ray.D[2 * k + 1] = RC(D_1[k]);
    }
    for (int i = 0; i < 2000; i++) {
        double way[3], pixel = i * TEST_PI / 2000;

        for (int k = 0; k < 3; k++) {
            way[k] = cos(pixel) * D_0[k] + sin(pixel) * D_1[k];
        }
        largest = fmax(largest, test_dot(way, way));
    }
    const double sigma_b = D(band.sigma_b), turn = test_uniform(rng, 0, 6);
    const double sine = sines * sqrt(D(band.epipole2) + sigma_b * sigma_b * largest);

    for (int k = 0; k < 3; k++) {
        ray.m[k] = RC(
            sqrt(1 - sine * sine) * by_t * t[k] +
            sine * (cos(turn) * by[0] * across[0][k] + sin(turn) * by[1] * across[1][k]));
    }
    return rigcal_band_test_ray(&match, &band, &ray);
}

static void test_within_three_deviations_of_the_epipole_there_is_no_depth(void)
{
    static const double before[3] = {0.2, 0.1, 1};
    const rigcal_real uv_a[2] = {400, 240};
    test_rng rng = test_seed(5201);

    look_the_same_way(before, 0.5);
    scene.pair.Sigma[21] = scene.pair.Sigma[28] = scene.pair.Sigma[35] = RC(1e-7);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv_a));
    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        const rigcal_status far = test_beside_t(3.05, &rng);

        ASSERT_STATUS(RIGCAL_ERR_EPIPOLE, test_beside_t(2.95, &rng));
        TEST_ASSERT_TRUE(far == RIGCAL_OK || far == RIGCAL_ERR_BEHIND);
    }
}

/* The ray is exactly that of the centre of a. Nothing is uncertain but the line: the square
 * of the noise is below all numbers. */
static void test_the_epipole_of_b_itself_has_no_depth(void)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {330, 240};
    const rigcal_ray ray = {{0, 1, 0}, {RC(0.001), 0, 0, 0, 0, RC(0.001)}};
    rigcal_match match;

    look_the_same_way(beside, 0.5);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    memset(band.ray, 0, sizeof band.ray);
    memset(band.towards, 0, sizeof band.towards);
    memset(band.line, 0, sizeof band.line);
    band.ray[0] = band.towards[1] = band.line[2] = band.across = 1;
    band.along = band.epipole2 = 0;
    band.sigma_b = RC(TOL(1e-200, 1e-30));
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, match, rigcal_band_test_ray(&match, &band, &ray));
}

/* The covariance of a line may be larger than any coordinate. Then its width is beyond all
 * images. */
static void test_a_line_may_be_as_unsure_as_it_wants(void)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {330, 240}, left[2] = {300, 240};
    rigcal_match match;

    for (int k = 0; k < 6; k++) {
        look_the_same_way(beside, 0.5);
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_test(&match, &band, left));
        band.Sigma_line[0] = band.Sigma_line[3] = band.Sigma_line[5] = RC(1e30);
        ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, match, rigcal_band_test(&match, &band, left));
        band.Sigma_line[k] = RC(4e30);
        ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, match, rigcal_band_test(&match, &band, left));
    }
}

static void test_parallel_rays_have_no_depth(void)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {330, 240}, left[2] = {320, 240}, right[2] = {340, 240};
    rigcal_match match;

    look_the_same_way(beside, 0.5);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, match, rigcal_band_test(&match, &band, uv));
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, match, rigcal_band_test(&match, &band, right));
    for (int k = 0; k < 2; k++) { /* sines of 12 and 24 roundings; 16 are parallel */
        const rigcal_real nearly[2] = {RC(320 - (k ? 24 : 12) * 500 * D(RC_EPS)), 240};
        const rigcal_real ahead[2] = {320, 240};

        ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, ahead));
        FILL(match);
        ASSERT_STATUS(k ? RIGCAL_OK : RIGCAL_ERR_PARALLEL,
                      rigcal_band_test(&match, &band, nearly));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_test(&match, &band, left));
    ASSERT_NEAR(50 * hypot(1, 0.02), match.depth_a, TOL(1e-9, 1e-2));
    ASSERT_NEAR(0, match.distance_px, TOL(1e-12, 1e-4));
    /* s^2 / var: both pixels' noise, 2 (0.5)^2 */
    ASSERT_NEAR(2 * sqrt(0.5), match.half_width_px, TOL(1e-6, 1e-4));
}

static void test_one_centre_has_no_band(void)
{
    static const double none[3] = {0, 0, 0};
    const rigcal_real uv[2] = {330, 240};

    look_the_same_way(none, 0.5);
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, band, rigcal_band_make(&band, &scene.pair, uv));
}

static void test_beyond_the_lens_there_is_no_ray(void)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {330, 240}, corner[2] = {0, 0};
    rigcal_match match;
    rigcal_ray ray;

    look_the_same_way(beside, 0.5);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    pinhole.k1 = RC(-1); /* folds at 0.577, 192 px */
    band.camera_b = pinhole;
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, match, rigcal_band_test(&match, &band, corner));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, band, rigcal_band_make(&band, &scene.pair, corner));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, ray, rigcal_ray_make(&ray, &pinhole, corner));
}

/* The centre of b is on the ray of the pixel itself. */
static void test_the_epipole_of_a_itself_has_no_band(void)
{
    static const double before[3] = {0, 0, 1};
    const rigcal_real uv[2] = {320, 240};

    look_the_same_way(before, 0.5);
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, band, rigcal_band_make(&band, &scene.pair, uv));
}

/* Tests a ray this far off the line. Its pixel moves it by `turn` rad a pixel. The
 * direction of the baseline is uncertain by `unsure`, the pixels by `sigma_px`. */
static rigcal_status test_off_the_line(rigcal_match *match, double off, double turn,
                                       double unsure, double sigma_px)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {320, 240};
    rigcal_ray ray;

    look_the_same_way(beside, 0.5);
    scene.pair.sigma_a = 0;
    scene.pair.sigma_b = RC(sigma_px);
    scene.pair.Sigma[21] = scene.pair.Sigma[28] = scene.pair.Sigma[35] = RC(unsure);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    memset(&ray, 0, sizeof ray);
    ray.m[0] = RC(-0.1);
    ray.m[1] = RC(off);
    ray.m[2] = RC(sqrt(0.99 - off * off));
    ray.D[0] = ray.D[3] = RC(turn);
    FILL(*match);
    return rigcal_band_test_ray(match, &band, &ray);
}

/* The distance is off / turn, the half width k sqrt(variance) / turn. */
static void test_a_ray_whose_pixel_says_nothing_of_the_line_is_degenerate(void)
{
    const double least = TOL(1e-318, 1e-40), little = TOL(1e-170, 1e-30);
    rigcal_match match;

    ASSERT_STATUS(RIGCAL_OK, test_off_the_line(&match, 0.1, 1e-3, 1e-6, 0.5));
    ASSERT_NEAR(100, fabs(D(match.distance_px)), TOL(1e-9, 1e-3));
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, test_off_the_line(&match, 0.1, 0, 1e-6, 0.5));
    ASSERT_UNTOUCHED(match); /* the pixel does not move it */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, test_off_the_line(&match, 0.1, 1e-14, 1e-6, 0.5));
    ASSERT_UNTOUCHED(match); /* 1e13 px off */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, test_off_the_line(&match, 0.1, 1e-3, 0, 1e-12));
    ASSERT_UNTOUCHED(match); /* 1e14 standard deviations off */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  test_off_the_line(&match, 0.1, 1e6, least, little));
    ASSERT_UNTOUCHED(match); /* a variance that no pixel can show */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, test_off_the_line(&match, 0, 1e6, least, little));
    ASSERT_UNTOUCHED(match);
}

static void test_the_range_of_depths_ends_at_the_largest_coordinate(void)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {330, 240};

    look_the_same_way(beside, 0.5);
    scene.pair.far_a = RC_COORDINATE_MAX;
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.near_a = RC_COORDINATE_MAX;
    scene.pair.far_a = 0;
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.far_a = RC_COORDINATE_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.near_a = 0;
    scene.pair.far_a = RC_COORDINATE_MAX * RC(1.01);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
}

/* Seen from b, 3 beside, an error of t across it turns its direction by a third of that. */
static void test_the_epipole_is_as_unsure_as_the_direction_of_t(void)
{
    static const double beside[3] = {3, 0, 0};
    const rigcal_real uv[2] = {320, 240};

    for (int along = 0; along < 2; along++) {
        look_the_same_way(beside, 0.5);
        scene.pair.Sigma[21] = RC(0.5);                  /* x: along t */
        scene.pair.Sigma[28] = RC(along ? 1e-6 : 9e-6);  /* y */
        scene.pair.Sigma[35] = RC(along ? 36e-6 : 4e-6); /* z */
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
        ASSERT_NEAR(along ? 4e-6 : 1e-6, band.epipole2, TOL(1e-18, 1e-11));
    }
}

static void test_widths_end_where_the_header_says(void)
{
    static const double beside[3] = {1, 0, 0};
    const rigcal_real uv[2] = {330, 240};

    look_the_same_way(beside, 0.5);
    scene.pair.k = 100;
    scene.pair.sigma_b = RC(1e6);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.k = RC(100.01);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.k = 100;
    scene.pair.sigma_b = RC(1.0001e6);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.sigma_b = scene.pair.sigma_a = RC(1e6); /* far more than the line is away */
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, band, rigcal_band_make(&band, &scene.pair, uv));
    scene.pair.sigma_a = RC(1.0001e6);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
}

/* The variance of the direction of t is that of t across it, over |t|^2. The variance of
 * the line by a turn is that of the turn times |t|^2. Each alone is beyond all numbers
 * here. */
static void test_a_covariance_that_overflows_is_out_of_range(void)
{
    static const double beside[3] = {1e-10, 0, 0}, far[3] = {1e8, 0, 0};
    const rigcal_real uv[2] = {330, 240};

    look_the_same_way(beside, 0.5);
    scene.pair.Sigma[28] = scene.pair.Sigma[35] = RC(0.9) * RC_MAX; /* as is their sum */
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
    look_the_same_way(far, 0.5);
    for (int k = 0; k < 3; k++) {
        scene.pair.Sigma[7 * k] = RC(TOL(1e295, 1e25));
    }
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, band, rigcal_band_make(&band, &scene.pair, uv));
}

TEST_MAIN()
{
    RUN_TEST(test_the_range_of_depths_ends_at_the_largest_coordinate);
    RUN_TEST(test_the_epipole_is_as_unsure_as_the_direction_of_t);
    RUN_TEST(test_widths_end_where_the_header_says);
    RUN_TEST(test_a_covariance_that_overflows_is_out_of_range);
    RUN_TEST(test_k_is_the_quantile);
    RUN_TEST(test_rays_turn_as_differences_of_pixels_say);
    RUN_TEST(test_what_a_band_says_of_a_pixel_is_true);
    RUN_TEST(test_rays_and_pixels_say_the_same);
    RUN_TEST(test_near_the_epipole_of_a_there_is_no_band);
    RUN_TEST(test_a_calibration_that_is_unsure_widens_the_epipole);
    RUN_TEST(test_near_the_epipole_of_b_a_candidate_has_no_depth);
    RUN_TEST(test_within_three_deviations_of_the_epipole_there_is_no_depth);
    RUN_TEST(test_the_epipole_of_b_itself_has_no_depth);
    RUN_TEST(test_a_line_may_be_as_unsure_as_it_wants);
    RUN_TEST(test_parallel_rays_have_no_depth);
    RUN_TEST(test_one_centre_has_no_band);
    RUN_TEST(test_beyond_the_lens_there_is_no_ray);
    RUN_TEST(test_the_epipole_of_a_itself_has_no_band);
    RUN_TEST(test_a_ray_whose_pixel_says_nothing_of_the_line_is_degenerate);
}
