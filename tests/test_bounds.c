/* bounds: no loop runs longer than rigcal.h says. Each bound is reached, or approached as
 * closely as any known input does. Units that the API counts are counted one by one. For
 * other loops the library is built here with count_hooks.h, which counts the calls of a
 * math function in a named function of src/. The source of that function shows how many
 * calls one pass makes. */
#include <math.h>
#include <string.h>

#include "count_hooks.h"
#include "rc_direction.h"
#include "rc_outline.h"
#include "test_support.h"

/* ---- counting ------------------------------------------------------------ */

static struct {
    const char *function;
    int hook, is_either, is_second;
    long count;
} watched;

/* In the single file a name may have the name of its layer before it. */
static int is_watched(const char *function)
{
    const size_t have = strlen(function), want = strlen(watched.function);

    return have >= want && strcmp(function + have - want, watched.function) == 0 &&
           (have == want || function[have - want - 1] == '_');
}

void hook_called(int hook, const char *function, double x)
{
    if (watched.function == NULL || hook != watched.hook || !is_watched(function)) {
        return;
    }
    if (watched.is_second) {
        watched.is_second = 0;
        return;
    }
    watched.is_second = watched.is_either && !(fabs(x) > 0);
    watched.count++;
}

/* Counts calls of a hook in a function, until the next watch. */
static void watch(const char *function, int hook)
{
    watched.function = function;
    watched.hook = hook;
    watched.is_either = watched.is_second = 0;
    watched.count = 0;
}

/* Counts decisions |a| > 0 || |b| > 0. The second call is made only if the first one has
 * 0. */
static void watch_either(const char *function)
{
    watch(function, HOOK_FABS);
    watched.is_either = 1;
}

static void keep_largest(long *largest, long count)
{
    *largest = (count > *largest) ? count : *largest;
}

/* A number between 10^low and 10^high, positive or negative. */
static double anything(test_rng *rng, double low, double high)
{
    const double size = pow(10, test_uniform(rng, low, high));

    return (test_next(rng) % 2) ? size : -size;
}

/* ---- rotation ------------------------------------------------------------ */

/* One square root in each iteration. */
static long polar_iterations(const double M[9])
{
    rigcal_real in[9], R[9];

    test_to_real(in, M, 9);
    watch("rc_rotation_nearest", HOOK_SQRT);
    (void)rigcal_rotation_nearest(R, in);
    return watched.count;
}

/* Rotations stretched by up to 1e16, and numbers of any size. With its scaling the
 * iteration removes a stretch in two steps, so nothing comes near 40. */
static void test_the_nearest_rotation_takes_at_most_40_iterations(void)
{
    test_rng rng = test_seed(400);
    long largest = 0;

    for (int trial = 0; trial < 40000; trial++) {
        double A[9], B[9], M[9];

        test_random_rotation(A, &rng);
        test_random_rotation(B, &rng);
        for (int i = 0; i < 9; i++) {
            A[i] *= (i % 3) ? pow(10, test_uniform(&rng, trial % 2 ? -16 : -3, 0)) : 1;
        }
        test_product(M, A, B);
        for (int i = 0; trial % 4 == 0 && i < 9; i++) {
            M[i] = anything(&rng, -12, 0);
        }
        keep_largest(&largest, polar_iterations(M));
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(40, largest);
    TEST_ASSERT_GREATER_OR_EQUAL_INT(TOL(6, 5), largest);
    TEST_ASSERT_LESS_OR_EQUAL_INT(6, largest); /* "usually" */
}

/* ---- direction ----------------------------------------------------------- */

/* Moments whose gain is p cos psi + q sin psi + cos 2 psi along the z axis, with a positive
 * depth for every psi. best_yaw takes a square root of its own, and one a step. */
static long yaw_steps(double p, double q)
{
    const rigcal_real z[3] = {0, 0, 1};
    rigcal_moments sums = {0};

    sums.weight = 1;
    sums.S = RC(0.5);
    sums.V_mean[0][0] = 1;
    sums.h[2] = -1;
    sums.G[0][2] = RC(p / 2 - 2);
    sums.G[0][4] = RC(q / 2);
    watch("best_yaw", HOOK_SQRT);
    (void)rc_direction_cost(&sums, z);
    return watched.count - 1;
}

/* Where the gain has a flat maximum, each step comes nearer by a third. */
static void test_a_yaw_takes_at_most_6_steps(void)
{
    test_rng rng = test_seed(416);
    long largest = 0, many = 0;

    for (int trial = 0; trial < 20000; trial++) {
        const long steps = yaw_steps(anything(&rng, -3, 1.5), anything(&rng, -3, 1.5));

        keep_largest(&largest, steps);
        many += steps > 3;
    }
    TEST_ASSERT_EQUAL_INT(6, largest);
    TEST_ASSERT_LESS_THAN_INT(20000 / 4, many); /* "usually 2 or 3" */
}

/* ---- camera -------------------------------------------------------------- */

/* A lens with focal length 1 at the corner of its image: coefficients k1, k2, k3, p1, p2,
 * and a pixel. */
typedef struct {
    double k[5], uv[2];
} lens_case;

/* A step of Newton's method and a step of the proof each make one decision |a| > 0 || |b| >
 * 0. The proof makes it only if the denominator of the lens is positive; here it is 1. */
static const char NEWTON[] = "solve_from", PROOF[] = "is_usable_between";

static long ray_steps(const char *function, int32_t lens, const lens_case *l)
{
    const double v[15] = {lens, 640,     480,     1,       1,       0,
                          0,    l->k[0], l->k[1], l->k[3], l->k[4], l->k[2]};
    const rigcal_camera camera = test_camera(v);
    rigcal_real uv[2], ray[3];

    test_to_real(uv, l->uv, 2);
    watch_either(function);
    (void)rigcal_camera_ray(ray, &camera, uv);
    return watched.count;
}

static lens_case random_lens(test_rng *rng, int32_t lens)
{
    lens_case l = {{0}, {0}};

    for (int i = 0; i < 5; i++) {
        l.k[i] = (i < 3)                       ? test_uniform(rng, -0.5, 0.5)
                 : (lens == RIGCAL_LENS_BROWN) ? test_uniform(rng, -0.01, 0.01)
                                               : 0;
    }
    l.uv[0] = test_uniform(rng, 0, 1.5);
    l.uv[1] = (test_next(rng) % 2) ? test_uniform(rng, -1, 1) : anything(rng, -30, 0);
    return l;
}

/* Found by climbing from random lenses: pixels just outside the image of the lens. Every
 * number of stages is tried, and all stages but the last arrive. Only a few solves take 60
 * steps: the most that was found is 1400 of the 7620 possible. */
static void test_a_pixel_takes_at_most_127_solves_of_60_steps(void)
{
    static const lens_case FAR[2] = {
        {{1.9965498877722425, 0.43797817820765372, 0.056183670570792085,
          -2.9917275658777771, 0.86910655323148167},
         {0.74949144752514596, -0.3450369298378147}},
        {{0.093027513534867087, 0.25375167661347514, 0.048564363345047629,
          -1.3721907558706632, 0.96048205877820925},
         {1.1855380086713696, -0.12715891898217882}}};
    test_rng rng = test_seed(401);
    long largest = 0;

    for (int trial = 0; trial < 20000; trial++) {
        const lens_case l = random_lens(&rng, trial % 2);
        const long steps = ray_steps(NEWTON, trial % 2, &l);

        TEST_ASSERT_LESS_OR_EQUAL_INT(127 * 60, steps);
    }
    for (int i = 0; i < 2; i++) {
        keep_largest(&largest, ray_steps(NEWTON, RIGCAL_LENS_BROWN, &FAR[i]));
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(127 * 60, largest);
    TEST_ASSERT_GREATER_OR_EQUAL_INT(1400, largest);
}

/* So close to the axis that the square of the distance is 0. The first step gains nothing,
 * and is halved until the end. */
static void test_a_solve_takes_its_60_steps_and_no_more(void)
{
    const lens_case l = {{-0.2, 0, 0, 0, 0}, {TOL(1e-200, 1e-24), 0}};

    TEST_ASSERT_EQUAL_INT(60, ray_steps(NEWTON, RIGCAL_LENS_BROWN, &l));
}

/* Tangential distortion leaves little margin for the bounds of the proof, so its steps are
 * short. With every number of stages the proof fails at its last step. */
static void test_a_pixel_takes_at_most_7_proofs_of_1024_steps(void)
{
    static const lens_case CREEP[2] = {
        {{-0.099135258408067889, -0.0015905493688930916, 0.29029752414465138,
          0.41883746224055568, 0.0066049469206982316},
         {0.99340077413790751, 0.050172580071716946}},
        {{-0.10751162159771539, -0.024999371421746075, 0.10053978564838315,
          0.41855188560410028, 0.0072442136107535946},
         {0.92749444490766186, 0.32993433095928909}}};
    test_rng rng = test_seed(402);
    long largest = 0;

    for (int trial = 0; trial < 20000; trial++) {
        const lens_case l = random_lens(&rng, trial % 2);
        const long steps = ray_steps(PROOF, trial % 2, &l);

        TEST_ASSERT_LESS_OR_EQUAL_INT(7 * 1024, steps);
    }
    for (int i = 0; i < 2; i++) {
        keep_largest(&largest, ray_steps(PROOF, RIGCAL_LENS_BROWN, &CREEP[i]));
    }
    TEST_ASSERT_EQUAL_INT(7 * 1024, largest);
}

/* Strong tangential distortion, and a ray beyond the place where the lens folds: p1, k3,
 * azimuth and slope of the ray. */
static void test_a_projection_takes_at_most_one_such_proof(void)
{
    static const double CREEP[2][4] = {
        {2.7738321057003175, 0, 0.48327839051926169, 2.6068236704425982},
        {2.5882822884732257, 0.091947163839681934, 2.7528422509227464, 1.8089854563414371}};
    long largest = 0;

    for (int i = 0; i < 2; i++) {
        const double *const c = CREEP[i];
        const double v[15] = {RIGCAL_LENS_BROWN, 640, 480, 1, 1, 0, 0, 0, 0, c[0], 0, c[1]};
        const rigcal_camera camera = test_camera(v);
        const rigcal_real X_c[3] = {RC(c[3] * cos(c[2])), RC(c[3] * sin(c[2])), 1};
        rigcal_real uv[2];

        watch_either(PROOF);
        ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rigcal_camera_project(uv, &camera, X_c));
        keep_largest(&largest, watched.count);
    }
    TEST_ASSERT_EQUAL_INT(1024, largest);
}

/* For realistic lenses. */
static void test_a_pixel_usually_takes_one_solve_of_3_to_6_and_a_proof_of_1_to_3(void)
{
    test_rng rng = test_seed(403);
    int many = 0, long_proofs = 0;

    for (int trial = 0; trial < 10000; trial++) {
        const lens_case l = {
            {test_uniform(&rng, -0.3, 0.1), test_uniform(&rng, 0, 0.1), 0,
             test_uniform(&rng, -1e-3, 1e-3), test_uniform(&rng, -1e-3, 1e-3)},
            {test_uniform(&rng, -0.4, 0.4), test_uniform(&rng, -0.3, 0.3)}};
        const long steps = ray_steps(NEWTON, RIGCAL_LENS_BROWN, &l);
        const long proof = ray_steps(PROOF, RIGCAL_LENS_BROWN, &l);

        many += steps < 3 || steps > 6;
        long_proofs += proof < 1 || proof > 3;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(500, many);
    TEST_ASSERT_LESS_OR_EQUAL_INT(500, long_proofs);
}

/* ---- triangulate --------------------------------------------------------- */

enum { VIEWS_MAX = 5 };

typedef struct {
    rigcal_camera cameras[VIEWS_MAX];
    rigcal_transform poses[VIEWS_MAX];
    rigcal_real uv[2 * VIEWS_MAX];
    size_t n;
} views;

/* One point seen by n cameras side by side, with this noise [px]. */
static void random_views(views *v, size_t n, double noise_px, double nearest, test_rng *rng)
{
    double X[3];

    v->n = n;
    for (int k = 0; k < 3; k++) {
        X[k] = test_uniform(rng, -1, 1);
    }
    for (size_t i = 0; i < n; i++) {
        double R[9], t[3], X_c[3], uv[2];

        test_rotation(R, test_uniform(rng, -3, 3), 0.5 * (double)i - 0.5,
                      test_uniform(rng, -0.2, 0.2));
        test_apply(X_c, R, X, NULL);
        t[0] = test_uniform(rng, -0.8, 0.8) - X_c[0];
        t[1] = test_uniform(rng, -0.8, 0.8) - X_c[1];
        t[2] = test_uniform(rng, nearest, 2 * nearest) - X_c[2];
        v->poses[i] = test_transform(R, t);
        v->cameras[i] = test_pinhole();
        v->cameras[i].k1 = RC(1e-6); /* otherwise the library takes a shorter path */
        test_transform_parts(R, t, &v->poses[i]);
        test_apply(X_c, R, X, t);
        test_project_px(uv, &v->cameras[i], X_c);
        v->uv[2 * i] = RC(uv[0] + noise_px * test_normal(rng));
        v->uv[2 * i + 1] = RC(uv[1] + noise_px * test_normal(rng));
    }
}

/* Each view calls the absolute value three times: twice for its ray, and at each evaluation
 * of the equations. */
static long triangulation_evals(const views *v)
{
    rigcal_point point;

    watch("rc_vec3_max_abs", HOOK_FABS);
    (void)rigcal_point_triangulate(&point, v->cameras, v->poses, v->uv, v->n, 1);
    return watched.count / (3 * (long)v->n) - 2;
}

/* Pixels that are hundreds off leave large residuals, for which the Gauss-Newton method is
 * slow. */
static void test_a_point_takes_at_most_50_evaluations(void)
{
    test_rng rng = test_seed(406);
    long evals = 0;

    for (int trial = 0; trial < 4000; trial++) {
        views v;

        random_views(&v, (size_t)(2 + trial % 4), (trial % 2) ? 2000 : 300,
                     (trial % 3) ? 3 : 0.3, &rng);
        keep_largest(&evals, triangulation_evals(&v));
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(50, evals);
    TEST_ASSERT_GREATER_OR_EQUAL_INT(TOL(50, 30), evals);
}

/* For exact pixels the first evaluation shows that nothing is left to gain. Their noise is
 * the rounding of a pixel, which is larger in float. */
static void test_a_point_usually_takes_2_or_3_evaluations_and_of_exact_pixels_1(void)
{
    static const double NOISE_PX[4] = {0, 1e-6, 1e-3, 0.5};
    test_rng rng = test_seed(407);
    int many = 0;

    for (int trial = 0; trial < 12000; trial++) {
        const double noise_px = NOISE_PX[trial / 4 % 4];
        const int is_exact = noise_px <= TOL(0, 1e-3);
        views v;
        long count;

        random_views(&v, (size_t)(2 + trial % 4), noise_px, 3, &rng);
        count = triangulation_evals(&v);
        many += is_exact ? count > (RIGCAL_USE_FLOAT ? 2 : 1) : count < 2 || count > 3;
        TEST_ASSERT_GREATER_OR_EQUAL_INT(1, count);
        TEST_ASSERT_LESS_OR_EQUAL_INT(20, count);
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(60, many);
}

/* ---- outline ------------------------------------------------------------- */

/* v = 100 t^4 - 1e-18 is so flat where it crosses row 0 that Newton's method, u = 2000 t
 * along the row, does not end before its last step. Each step takes two absolute
 * values, and the first one more. */
static void test_a_crossing_takes_at_most_24_steps(void)
{
    static const rigcal_real u[RIGCAL_SPANS_NODES] = {0, 2000, 4000, 6000, 8000};
    static const rigcal_real v[RIGCAL_SPANS_NODES] = {RC(-1e-18), 100, 1600, 8100, 25600};
    static rigcal_outline outline;
    rigcal_span spans[RIGCAL_SPANS_ROW];

    rc_outline_begin(&outline, 60);
    rc_outline_add(&outline, u, v);
    rc_outline_close(&outline);
    watch("crossing_of_t", HOOK_FABS);
    for (int32_t row = 0; row < 60; row++) {
        watched.count = 0;
        (void)rc_outline_row(spans, &outline, row, 9000);
        TEST_ASSERT_LESS_OR_EQUAL_INT(1 + 2 * (row > 0 ? 8 : 24), watched.count);
        TEST_ASSERT_TRUE(row > 0 || watched.count == 1 + 2 * 24);
    }
}

/* ---- transform ----------------------------------------------------------- */

/* Each iteration makes a quaternion of every deviation, with one square root. For random
 * rotations the iteration converges slowly. */
static void test_a_mean_takes_at_most_20_iterations(void)
{
    test_rng rng = test_seed(408);
    long largest = 0;

    for (int trial = 0; trial < 10000; trial++) {
        const int n = 2 + trial % 3;
        rigcal_transform mean, transforms[4];
        rigcal_real weight[4];

        for (int i = 0; i < n; i++) {
            double R[9];

            test_random_rotation(R, &rng);
            transforms[i] = test_transform(R, NULL);
            weight[i] = RC(test_uniform(&rng, 0, 1));
        }
        watch("rc_quaternion_from_rotation", HOOK_SQRT);
        (void)rigcal_transform_mean(&mean, NULL, NULL, transforms, weight, (size_t)n);
        keep_largest(&largest, watched.count / n);
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(20, largest);
    TEST_ASSERT_GREATER_OR_EQUAL_INT(TOL(20, 12), largest);
}

/* ---- neldermead ---------------------------------------------------------- */

typedef struct {
    test_rng rng;
    int kind;
    int32_t calls;
} strange_cost;

/* Noise, a slope, a plateau, NaN and infinity among numbers. */
static rigcal_real cost_of(void *context, const rigcal_real x[])
{
    strange_cost *const c = context;
    const double noise = test_uniform(&c->rng, -1, 1);

    c->calls++;
    switch (c->kind) {
    case 0:
        return RC(noise);
    case 1:
        return -x[0];
    case 2:
        return (noise > 0) ? TEST_NAN : RC(noise);
    case 3:
        return (noise > 0) ? TEST_INF : x[0];
    default:
        return 1;
    }
}

/* A slope has no end before max_evals. The other functions may have one. */
static void test_neldermead_spends_max_evals_and_no_more(void)
{
    static const int32_t MOST[5] = {1, 2, 7, 100, 3000};
    const rigcal_real x0[3] = {1, 0, -2};

    for (int kind = 0; kind < 5; kind++) {
        for (int32_t k = 1; k <= 3; k++) {
            for (int m = 0; m < 5; m++) {
                strange_cost context = {test_seed(404), kind, 0};
                rigcal_neldermead nm;
                rigcal_status status;

                ASSERT_STATUS(RIGCAL_OK,
                              rigcal_neldermead_begin(&nm, x0, k, 0, 0, MOST[m]));
                do {
                    const int32_t before = context.calls;

                    status = rigcal_neldermead_step(&nm, cost_of, &context, 3);
                    TEST_ASSERT_LESS_OR_EQUAL_INT(3, context.calls - before);
                } while (status == RIGCAL_RUNNING);
                TEST_ASSERT_LESS_OR_EQUAL_INT(MOST[m], context.calls);
                ASSERT_STATUS(RIGCAL_OK, status); /* "ask for the result" */
                if (kind == 1 && m < 4) {
                    rigcal_real x[3];

                    ASSERT_STATUS(RIGCAL_BUDGET_SPENT,
                                  rigcal_neldermead_result(x, NULL, NULL, &nm));
                }
                if (m == 0 || (kind == 1 && m < 4)) {
                    TEST_ASSERT_EQUAL_INT(MOST[m], context.calls);
                }
            }
        }
    }
}

/* ---- hostile scenes ------------------------------------------------------ */

enum {
    NOISE,     /* 0.3 px */
    NONSENSE,  /* 30 px */
    MIRRORED,  /* the target with Z replaced by -Z */
    NEEDLE,    /* nearly on a line, noise of 1 px */
    ANY_PIXEL, /* random pixels of the image */
    GARBAGE,   /* random numbers of all sizes */
    BENT,      /* noise of 10 px, through a lens that folds */
    KINDS
};
enum { POINTS_MAX = 40 };

typedef struct {
    rigcal_observation o[POINTS_MAX];
    rigcal_camera camera;
    size_t n;
} scene;

static void make_hostile(rigcal_observation *o, int kind, test_rng *rng)
{
    static const double NOISE_PX[KINDS] = {0.3, 30, 0, 1, 0, 0, 10};

    for (int k = 0; k < 2; k++) {
        o->uv[k] += RC(NOISE_PX[kind] * test_normal(rng));
        if (kind == ANY_PIXEL) {
            o->uv[k] = RC(test_uniform(rng, 0, k ? 480 : 640));
        } else if (kind == GARBAGE) {
            o->uv[k] = RC(300 + test_normal(rng) * anything(rng, -3, 3));
        } else if (kind == NEEDLE) {
            o->X_w[1 + k] *= RC(1e-3);
        }
    }
    if (kind == MIRRORED) {
        o->X_w[2] = -o->X_w[2];
    }
    for (int k = 0; kind == GARBAGE && k < 3; k++) {
        o->X_w[k] = RC(anything(rng, -3, 0));
    }
}

static void hostile_scene(scene *s, int kind, int n, test_rng *rng)
{
    test_scene made;

    test_scene_random(&made, rng, n, (test_shape)(test_next(rng) % 3));
    s->camera = test_pinhole();
    if (kind == BENT) {
        s->camera.k1 = RC(-0.3);
        s->camera.k2 = RC(0.05);
    }
    s->n = (size_t)n;
    test_observations(s->o, &made, &s->camera);
    for (int i = 0; i < n; i++) {
        make_hostile(&s->o[i], kind, rng);
    }
}

/* ---- paper --------------------------------------------------------------- */

/* Evaluations of a search whose tolerances are never met. */
static long paper_evals(const scene *s, const rigcal_paper_options *options)
{
    rigcal_bearing bearings[POINTS_MAX];
    rigcal_pair pairs[RIGCAL_PAIRS_FOR(POINTS_MAX)];
    rigcal_paper_solver solver;
    rigcal_paper_pose pose;
    size_t n_pairs;
    long units = 1;

    if (rigcal_bearings_of_view(bearings, NULL, &VIEW(&s->camera, s->o, NULL, s->n)) !=
            RIGCAL_OK ||
        rigcal_pairs_choose(pairs, RIGCAL_PAIRS_FOR(POINTS_MAX), &n_pairs, bearings,
                            s->n) != RIGCAL_OK) {
        return 0;
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_paper_begin(&solver, bearings, s->n, pairs, n_pairs, options));
    while (rigcal_paper_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    if (rigcal_paper_result(&pose, &solver) >= 0) {
        TEST_ASSERT_EQUAL_INT(solver.evals, pose.evals);
    }
    TEST_ASSERT_GREATER_THAN_INT(solver.evals, units); /* the end of a search is judged */
    TEST_ASSERT_LESS_OR_EQUAL_INT(solver.evals + 25 + 3, units);
    return solver.evals;
}

/* The largest number over scenes of all kinds. */
static long most_paper_evals(int use_guess, int32_t angles, int32_t max_evals)
{
    test_rng rng = test_seed(405);
    long largest = 0;

    for (int trial = 0; trial < 20 * KINDS; trial++) {
        rigcal_paper_options options;
        scene s;

        ASSERT_STATUS(RIGCAL_OK, rigcal_paper_defaults(&options));
        options.use_guess = use_guess;
        options.angles = angles;
        options.max_evals = max_evals;
        options.xtol = options.ftol = RC(1e-30);
        hostile_scene(&s, trial % KINDS, 4 + trial % 5, &rng);
        keep_largest(&largest, paper_evals(&s, &options));
    }
    return largest;
}

static void test_the_published_search_spends_max_evals_and_no_more(void)
{
    TEST_ASSERT_EQUAL_INT(3952, most_paper_evals(0, 2, 0));
    TEST_ASSERT_EQUAL_INT(192, most_paper_evals(0, 2, 192));
    TEST_ASSERT_EQUAL_INT(1000, most_paper_evals(1, 2, 0));
    TEST_ASSERT_EQUAL_INT(1000, most_paper_evals(1, 3, 0));
    TEST_ASSERT_EQUAL_INT(1, most_paper_evals(1, 2, 1));
}

/* ---- pose and robust ----------------------------------------------------- */

/* Units of a search until its end; 0: it cannot begin. */
static int pose_units(const scene *s, const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;
    int units = 1;

    if (rigcal_pose_begin(&solver, NULL, &VIEW(&s->camera, s->o, NULL, s->n), options) <
        0) {
        return 0;
    }
    while (rigcal_pose_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    return units;
}

static int points_of(uint64_t seed)
{
    return 3 + (int)(seed % 8);
}

/* Whether a ray is more than 60 degrees off the axis, or more than 80 degrees off the
 * middle of the image, as a pinhole measures it. */
static int is_wide(const scene *s)
{
    double middle[3] = {0, 0, 1};

    for (size_t i = 0; i < s->n; i++) {
        for (int k = 0; k < 2; k++) {
            const double c = D(k == 0 ? s->camera.cx : s->camera.cy);

            middle[k] += (D(s->o[i].uv[k]) - c) / D(s->camera.fx) / (double)s->n;
        }
    }
    for (size_t i = 0; i < s->n; i++) {
        const double ray[3] = {(D(s->o[i].uv[0]) - D(s->camera.cx)) / D(s->camera.fx),
                               (D(s->o[i].uv[1]) - D(s->camera.cy)) / D(s->camera.fy), 1};

        if (test_norm(ray) > 2 || test_dot(ray, middle) < cos(80 * TEST_PI / 180) *
                                                              test_norm(ray) *
                                                              test_norm(middle)) {
            return 1;
        }
    }
    return 0;
}

/* The limit by the formulas of rigcal.h. */
static int most_units(const scene *s)
{
    const int n = (int)s->n, bent = s->camera.k1 < 0;
    const int rays = bent ? 2 * n : (n + 15) / 16, proofs = bent ? 7 * n : 0;

    return rays + proofs + (is_wide(s) ? 2000 : 900);
}

/* Units of scene `seed` of a kind; with use_start from a random rotation. */
static int units_of(uint64_t seed, int kind, int use_start)
{
    static const double t[3] = {0, 0, 5};
    test_rng rng = test_seed(seed);
    rigcal_pose_options options;
    double R[9];
    scene s;
    int units;

    hostile_scene(&s, kind, points_of(seed), &rng);
    test_random_rotation(R, &rng);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
    options.use_start = use_start;
    options.start = test_transform(R, t);
    units = pose_units(&s, &options);
    TEST_ASSERT_LESS_OR_EQUAL_INT(most_units(&s), units);
    return units;
}

static void test_a_pose_takes_at_most_900_units_and_a_wide_one_2000(void)
{
    for (int kind = 0; kind < KINDS; kind++) {
        for (uint64_t seed = 0; seed < 300; seed++) {
            for (int use_start = 0; use_start < 2; use_start++) {
                (void)units_of(seed, kind, use_start);
            }
        }
    }
}

/* Needles use up one refinement after the other. Of 200 000 scenes, for each precision,
 * these took the most units. It is nearly the limit: 100 of a start, gathering, 24
 * directions, 3 descents of 9 and 6 refinements of 100. */
static void test_needles_take_760_units(void)
{
    static const uint64_t WORST[2] = {21793, 186080};
    long largest = 0;

    for (int i = 0; i < 2; i++) {
        keep_largest(&largest, units_of(WORST[i], NEEDLE, 1));
    }
    TEST_ASSERT_INT_WITHIN(10, 760, largest);
}

/* With up to 8 points the search starts from the poses of three of them. Three points take
 * about 12 units. */
static void test_usual_poses_take_7_to_55_or_40_to_70_units(void)
{
    int scenes = 0, others = 0;

    for (uint64_t seed = 0; seed < 2000; seed++) {
        if (points_of(seed) > 3) {
            const int units = units_of(seed, NOISE, 0);

            const int is_few = points_of(seed) <= 8;

            others += units < (is_few ? 7 : 40) || units > (is_few ? 55 : 70);
            scenes++;
        }
    }
    TEST_ASSERT_LESS_THAN_INT(scenes / 10, others);
}

/* All points are 60 to 80 degrees off the axis of a pinhole, within an angle `spread` of
 * each other. */
static void wide_scene(scene *s, double spread, test_rng *rng)
{
    double R[9];

    test_random_rotation(R, rng);
    s->camera = test_pinhole();
    s->n = 4 + (size_t)(test_next(rng) % 5);
    for (size_t i = 0; i < s->n; i++) {
        const double off = test_uniform(rng, 60, 80) * TEST_PI / 180;
        const double way = test_uniform(rng, 0, spread);
        const double range = test_uniform(rng, 1, 3);
        const double X_c[3] = {range * sin(off) * cos(way), range * sin(off) * sin(way),
                               range * cos(off)};
        double X[3], uv[2];

        test_apply(X, R, X_c, NULL);
        test_to_real(s->o[i].X_w, X, 3);
        test_project_px(uv, &s->camera, X_c);
        for (int k = 0; k < 2; k++) {
            s->o[i].uv[k] = RC(uv[k] + 0.5 * test_normal(rng));
        }
    }
}

static void test_usual_wide_poses_take_10_to_120_units(void)
{
    static const double SPREAD[3] = {0.3, 3, 2 * TEST_PI};
    test_rng rng = test_seed(412);

    for (int k = 0; k < 3; k++) {
        int others = 0;

        for (int trial = 0; trial < 500; trial++) {
            scene s;
            int units;

            wide_scene(&s, SPREAD[k], &rng);
            TEST_ASSERT_TRUE(is_wide(&s));
            units = pose_units(&s, NULL);
            TEST_ASSERT_LESS_OR_EQUAL_INT(most_units(&s), units);
            others += units < 10 || units > 120;
        }
        TEST_ASSERT_LESS_THAN_INT(500 / 10, others);
    }
}

enum { SAMPLES = 20 };

static long robust_units(uint64_t seed, int kind)
{
    test_rng rng = test_seed(seed);
    rigcal_robust_options options;
    rigcal_robust_solver solver;
    uint8_t inliers[POINTS_MAX];
    long units = 1;
    scene s;

    hostile_scene(&s, kind, 5 + (int)(seed % 30), &rng);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = SAMPLES;
    options.max_units = 1 + (int32_t)(seed % 150);
    options.threshold_px = RC(test_uniform(&rng, 1, 100));
    if (rigcal_robust_begin(&solver, inliers, NULL, &VIEW(&s.camera, s.o, NULL, s.n),
                            &options) < 0) {
        return 0;
    }
    while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(SAMPLES, solver.tried);
    TEST_ASSERT_LESS_OR_EQUAL_INT(
        options.max_units + 17 + (int)s.n + 9 + 9 * most_units(&s), units);
    return units;
}

/* Two needles that take more than two searches. Few of them use other points than the last
 * one. */
static void test_a_robust_pose_takes_at_most_those_of_9_searches_and_of_its_own(void)
{
    static const uint64_t WORST[2] = {311805, 1296296};
    long largest = 0;

    for (int kind = 0; kind < KINDS; kind++) {
        for (uint64_t seed = 0; seed < 500; seed++) {
            (void)robust_units(seed, kind);
        }
    }
    for (int i = 0; i < 2; i++) {
        keep_largest(&largest, robust_units(WORST[i], NEEDLE));
    }
    TEST_ASSERT_GREATER_OR_EQUAL_INT(2000, largest);
}

/* ---- diagnose ------------------------------------------------------------ */

/* Absolute values that a search needs to check one point that counts. */
enum { CHECKS = 5 };

/* A search checks each point once. */
static void test_a_diagnosis_solves_n_plus_1_to_n_plus_3_poses(void)
{
    test_rng rng = test_seed(409);

    for (int trial = 0; trial < 10 * KINDS; trial++) {
        rigcal_real rms_without[POINTS_MAX];
        rigcal_diagnosis diagnosis;
        rigcal_blame blame;
        scene s;

        hostile_scene(&s, trial % KINDS, 5 + trial % 9, &rng);
        const int n = (int)s.n;
        watch("is_within", HOOK_FABS);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_blame(&blame, rms_without,
                                                   &VIEW(&s.camera, s.o, NULL, s.n), NULL));
        TEST_ASSERT_EQUAL_INT(CHECKS * (n + n * (n - 1)), watched.count);
        watch("is_within", HOOK_FABS);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pose_diagnose(&diagnosis, rms_without,
                                           &VIEW(&s.camera, s.o, NULL, s.n), NULL));
        TEST_ASSERT_EQUAL_INT(CHECKS * (3 * n + n * (n - 1)), watched.count);
    }
}

/* Of more than 64 points only 64 are left out in turn. All points are surveyed to choose
 * them. */
static void test_a_diagnosis_of_many_points_solves_65_to_67_poses(void)
{
    enum { MANY = RIGCAL_BLAME_TRIES + 20 };
    static rigcal_real rms_without[MANY];
    static rigcal_observation o[MANY];
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(410);
    rigcal_diagnosis diagnosis;
    rigcal_blame blame;

    for (int i = 0; i < MANY; i++) {
        const double X_c[3] = {test_uniform(&rng, -1, 1), test_uniform(&rng, -1, 1),
                               test_uniform(&rng, 4, 6)};
        double uv[2];

        test_project_px(uv, &camera, X_c);
        test_to_real(o[i].X_w, X_c, 3);
        o[i].uv[0] = RC(uv[0] + test_normal(&rng));
        o[i].uv[1] = RC(uv[1] + test_normal(&rng));
    }
    watch("is_within", HOOK_FABS);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_blame(&blame, rms_without,
                                               &VIEW(&camera, o, NULL, MANY), NULL));
    TEST_ASSERT_EQUAL_INT(CHECKS * (2 * MANY + RIGCAL_BLAME_TRIES * (MANY - 1)),
                          watched.count);
    watch("is_within", HOOK_FABS);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_diagnose(&diagnosis, rms_without,
                                                  &VIEW(&camera, o, NULL, MANY), NULL));
    TEST_ASSERT_EQUAL_INT(CHECKS * (4 * MANY + RIGCAL_BLAME_TRIES * (MANY - 1)),
                          watched.count);
}

TEST_MAIN()
{
    RUN_TEST(test_the_nearest_rotation_takes_at_most_40_iterations);
    RUN_TEST(test_a_yaw_takes_at_most_6_steps);
    RUN_TEST(test_a_pixel_takes_at_most_127_solves_of_60_steps);
    RUN_TEST(test_a_solve_takes_its_60_steps_and_no_more);
    RUN_TEST(test_a_pixel_takes_at_most_7_proofs_of_1024_steps);
    RUN_TEST(test_a_projection_takes_at_most_one_such_proof);
    RUN_TEST(test_a_pixel_usually_takes_one_solve_of_3_to_6_and_a_proof_of_1_to_3);
    RUN_TEST(test_a_point_takes_at_most_50_evaluations);
    RUN_TEST(test_a_point_usually_takes_2_or_3_evaluations_and_of_exact_pixels_1);
    RUN_TEST(test_a_crossing_takes_at_most_24_steps);
    RUN_TEST(test_a_mean_takes_at_most_20_iterations);
    RUN_TEST(test_neldermead_spends_max_evals_and_no_more);
    RUN_TEST(test_the_published_search_spends_max_evals_and_no_more);
    RUN_TEST(test_a_pose_takes_at_most_900_units_and_a_wide_one_2000);
    RUN_TEST(test_needles_take_760_units);
    RUN_TEST(test_usual_poses_take_7_to_55_or_40_to_70_units);
    RUN_TEST(test_usual_wide_poses_take_10_to_120_units);
    RUN_TEST(test_a_robust_pose_takes_at_most_those_of_9_searches_and_of_its_own);
    RUN_TEST(test_a_diagnosis_solves_n_plus_1_to_n_plus_3_poses);
    RUN_TEST(test_a_diagnosis_of_many_points_solves_65_to_67_poses);
}
