/* The end of a depth range crosses a band from one border to the other. Where one border
 * meets it just at the end of the lens, the other border was joined to that place by a
 * straight line, which passed through the image. Spans lacked up to a hundred pixels.
 *
 * A band behind the camera may pass over the end of the lens, which is a hole there. Its
 * borders or its ends then leap to the other side of the hole. The leap was a straight line
 * through the image, or it went round the image on the wrong side. Spans had a large part
 * of the image that is not in the band, and lacked what is. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_bands.h"

enum { SIDE = 90 };

static rigcal_spans_solver solver;
static rigcal_span spans[4 * SIDE];

#define WANTS_SPANS() TEST_WANTS_RAM(sizeof solver + sizeof spans + 4000)

/* A pixel this close to the border depends on rounding. */
#define CLOSE TOL(1e-7, 2e-3)

/* A fisheye twice. Its image is theta (1 - theta^2 / (3 end^2)): it turns back at `end`, 85
 * pixels or more from the middle of the image, which is outside. */
static void make(test_bands *scene, uint64_t seed)
{
    rigcal_match_pair *const pair = &scene->pair;
    rigcal_camera *const c = &scene->b;
    test_rng rng = test_seed(seed);
    double axis[3], t[3], R[9];
    const double end = test_uniform(&rng, 1.7, 3.1);
    const double f = 127.2 / end * exp(test_uniform(&rng, 0, 0.4));

    memset(scene, 0, sizeof *scene);
    c->lens = RIGCAL_LENS_FISHEYE;
    c->width = c->height = SIDE;
    c->cx = c->cy = SIDE / 2;
    c->fx = c->fy = RC(f);
    c->k1 = RC(-1 / (3 * end * end));
    scene->a = *c;
    pair->camera_a = &scene->a;
    pair->camera_b = c;
    for (int k = 0; k < 3; k++) {
        axis[k] = test_uniform(&rng, -1, 1);
        t[k] = test_uniform(&rng, -1, 1);
    }
    test_rotation_about(R, axis, test_uniform(&rng, 0, 3));
    pair->b_from_a = test_transform(R, t);
    pair->sigma_a = RC(0.1);
    pair->sigma_b = RC(f * exp(test_uniform(&rng, log(0.01), log(0.24))));
    pair->k = 2;
    pair->near_a = RC(test_uniform(&rng, 0.3, 3));
    pair->far_a = (seed % 2 == 1) ? RC(D(pair->near_a) * test_uniform(&rng, 1.1, 4)) : 0;
    const double off = test_uniform(&rng, 0, 0.98 * end);
    const double way = test_uniform(&rng, 0, 6.28);
    const double r = f * off * (1 - off * off / (3 * end * end));
    scene->uv_a[0] = RC(SIDE / 2 + r * cos(way));
    scene->uv_a[1] = RC(SIDE / 2 + r * sin(way));
}

/* Every pixel of the band must be in a span. Returns how many there are. */
static int assert_none_missed(const test_bands *scene, size_t n)
{
    int n_inside = 0;
    test_ray a;

    TEST_ASSERT_TRUE(test_ray_of(&a, &scene->a, scene->uv_a));
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        const rigcal_real uv[2] = {RC(i % SIDE), RC(i / SIDE)};
        int is_found = 0;
        test_band_truth truth;
        test_ray ray;

        if (!test_ray_of(&ray, &scene->b, uv)) {
            continue;
        }
        test_band_look(&truth, scene, &a, &ray);
        for (size_t k = 0; k < n; k++) {
            is_found |= spans[k].row == i / SIDE && spans[k].first <= i % SIDE &&
                        i % SIDE <= spans[k].last;
        }
        TEST_ASSERT_TRUE(is_found || !truth.is_inside || truth.margin < CLOSE);
        n_inside += truth.is_inside;
    }
    return n_inside;
}

static rigcal_status find(test_bands *scene, size_t *n, uint64_t seed)
{
    rigcal_band band;

    make(scene, seed);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene->pair, scene->uv_a));
    return rigcal_spans_find(spans, 4 * SIDE, n, &solver, &band);
}

static void test_no_pixel_is_missed(void)
{
    static const uint64_t SEED[] = {6155,   18016,  40781,  64977, 131846,
                                    142086, 156402, 28714,  60600, 67225,
                                    70758,  182220, 298033, 82560, 427633};

    WANTS_SPANS();
    for (size_t i = 0; i < TEST_TRIALS(sizeof SEED / sizeof SEED[0]); i++) {
        test_bands scene;
        size_t n;

        ASSERT_STATUS(RIGCAL_OK, find(&scene, &n, SEED[i]));
        TEST_ASSERT_GREATER_THAN_INT(40, assert_none_missed(&scene, n));
    }
}

/* All of these bands are outside the image: brute force finds no pixel. */
static void test_a_band_that_leaps_over_the_end_of_the_lens_has_no_pixel(void)
{
    static const uint64_t SEED[] = {1409,   201709, 202165, 202869, 206313,
                                    210112, 214370, 219713, 223775};

    WANTS_SPANS();
    for (size_t i = 0; i < TEST_TRIALS(sizeof SEED / sizeof SEED[0]); i++) {
        test_bands scene;
        size_t n;

        ASSERT_STATUS(RIGCAL_ERR_OUTSIDE, find(&scene, &n, SEED[i]));
        TEST_ASSERT_EQUAL_INT(0, assert_none_missed(&scene, 0));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_no_pixel_is_missed);
    RUN_TEST(test_a_band_that_leaps_over_the_end_of_the_lens_has_no_pixel);
}
