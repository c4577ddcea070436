/* bench_points: whether points keep what their sigmas promise, on simulated rigs that are
 * calibrated first: cameras of three lenses in an arc of 70 degrees, 4 lengths of the board
 * away, 6 placements of 12 points, 0.3 px of noise.
 *
 *   bench_points [RIGS]    two Markdown tables, so many rigs a line (default 500)
 *   bench_points check     50 rigs a line: exit status 1 if a share misses its limits */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test_support.h"

enum { CAMERAS = 8, PLACES = 6, BOARD = 12, VIEWS = CAMERAS * PLACES, POINTS = 40 };

static const double NOISE = 0.3, FAR = 4, ARC = 1.2, WRONG_LEAST = 5, WRONG_MOST = 60;

/* The limits: chi square of 3 degrees at 95 %; a normal variable at 95 %; chi square of 2 n
 * - 3 degrees at 99 %. */
static const double ELLIPSOID = 7.8147, INTERVAL = 1.96;
static const double CHI2[CAMERAS + 1] = {0,      0,      6.635,  11.345, 15.086,
                                         18.475, 21.666, 24.725, 27.688};

typedef enum { PINHOLE, BROWN, FISHEYE, LENSES } lens_kind;

static struct {
    int n;
    rigcal_camera camera;
    rigcal_transform truth[CAMERAS], cams[CAMERAS], places[PLACES];
    double X[BOARD][3];
    rigcal_observation seen[VIEWS][BOARD];
    rigcal_rig_view views[VIEWS];
    int32_t group[CAMERAS];
    rigcal_real work[RIGCAL_RIG_WORK(CAMERAS, CAMERAS, PLACES)];
    rigcal_rig rig;

    rigcal_mounted_camera mounted[CAMERAS];
    int32_t kept_group[CAMERAS];
    uint8_t held[CAMERAS];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(CAMERAS)];
    rigcal_calibrated_rig kept;
} r;

/* ---- rigs ------------------------------------------------------------------ */

static rigcal_camera camera_of(lens_kind lens)
{
    rigcal_camera c = {.lens = RIGCAL_LENS_BROWN,
                       .width = 1280,
                       .height = 960,
                       .fx = 800,
                       .fy = 808,
                       .cx = 640,
                       .cy = 480};

    if (lens == BROWN) {
        c.k1 = RC(-0.25);
        c.k2 = RC(0.08);
        c.p1 = RC(0.001);
        c.p2 = RC(-0.0007);
        c.k3 = RC(-0.01);
    } else if (lens == FISHEYE) {
        c.lens = RIGCAL_LENS_FISHEYE;
        c.fx = c.fy = 480;
        c.k1 = RC(0.02);
        c.k2 = RC(-0.01);
        c.k3 = RC(0.003);
        c.k4 = RC(-0.001);
    }
    return c;
}

/* A camera in the arc, which looks at the middle. A board near the middle, turned to the
 * arc. */
static rigcal_transform camera_at(test_rng *rng, int c, int n)
{
    const double azimuth = (c - (n - 1) / 2.0) * ARC / (n > 1 ? n - 1 : 1);
    double R[9], t[3] = {test_uniform(rng, -0.2, 0.2), test_uniform(rng, -0.2, 0.2), FAR};

    test_rotation(R, test_uniform(rng, -0.3, 0.3), azimuth, test_uniform(rng, -0.25, 0.25));
    return test_transform(R, t);
}

static rigcal_transform board_at(test_rng *rng)
{
    double R[9], t[3];

    test_rotation(R, test_uniform(rng, -3, 3), test_uniform(rng, -0.7, 0.7),
                  test_uniform(rng, -0.7, 0.7));
    for (int k = 0; k < 3; k++) {
        t[k] = test_uniform(rng, -0.6, 0.6);
    }
    return test_transform(R, t);
}

/* The noisy pixel of X, a point of the rig's frame, in the real camera c. */
static void see(rigcal_real uv[2], test_rng *rng, int c, const double X[3])
{
    double X_c[3], pixel[2];

    test_move_point(X_c, &r.truth[c], X);
    test_project_px(pixel, &r.camera, X_c);
    for (int k = 0; k < 2; k++) {
        uv[k] = RC(pixel[k] + NOISE * test_normal(rng));
    }
}

static void see_board(test_rng *rng, int v, int c, int f)
{
    rigcal_rig_view *const view = &r.views[v];

    view->view.camera = &r.camera;
    view->view.observations = r.seen[v];
    view->view.n = BOARD;
    view->camera = c;
    view->placement = f;
    for (int i = 0; i < BOARD; i++) {
        double X[3];

        test_move_point(X, &r.places[f], r.X[i]);
        test_to_real(r.seen[v][i].X_w, r.X[i], 3);
        see(r.seen[v][i].uv, rng, c, X);
    }
}

/* Makes and adjusts a rig; camera 0 is the frame. Returns 0 if it could not be adjusted. */
static int make_rig(test_rng *rng, int n, lens_kind lens)
{
    rigcal_transform rig_from_middle;
    rigcal_rig_fit fit;

    memset(&r, 0, sizeof r);
    r.n = n;
    r.camera = camera_of(lens);
    for (int i = 0; i < BOARD; i++) {
        r.X[i][0] = (i % 4 - 1.5) / 3;
        r.X[i][1] = (double)(i / 4 - 1) / 3;
    }
    for (int c = 0; c < n; c++) {
        r.truth[c] = camera_at(rng, c, n);
    }
    rig_from_middle = r.truth[0];
    for (int f = 0; f < PLACES; f++) {
        const rigcal_transform board = board_at(rng);
        r.places[f] = test_times(&rig_from_middle, &board);
    }
    const rigcal_transform middle_from_rig = test_inverse(&rig_from_middle);
    for (int c = 0; c < n; c++) {
        r.truth[c] = test_times(&r.truth[c], &middle_from_rig);
        r.cams[c] = r.truth[c];
    }
    for (int v = 0; v < n * PLACES; v++) {
        see_board(rng, v, v % n, v / n);
    }
    r.rig = (rigcal_rig){.cams_from_rig = r.cams,
                         .n_cameras = (size_t)n,
                         .rig_from_placements = r.places,
                         .n_placements = PLACES,
                         .group = r.group,
                         .n_views = (size_t)(n * PLACES),
                         .views = r.views,
                         .work = r.work,
                         .work_capacity = sizeof r.work / sizeof r.work[0]};
    r.kept = (rigcal_calibrated_rig){.cameras = r.mounted,
                                     .group = r.kept_group,
                                     .held = r.held,
                                     .capacity = CAMERAS,
                                     .Sigma = r.Sigma,
                                     .Sigma_capacity = RIGCAL_CALIBRATED_SIZE(CAMERAS)};
    for (int c = 0; c < n; c++) {
        r.mounted[c].camera = r.camera;
    }
    return rigcal_rig_adjust(&fit, NULL, &r.rig) >= 0 &&
           rigcal_calibrated_take(&r.kept, &r.rig, &fit, RC(NOISE)) == RIGCAL_OK;
}

/* ---- points ---------------------------------------------------------------- */

typedef struct {
    double X[3];
    int n, n_wrong;
    uint8_t used[CAMERAS], is_wrong[CAMERAS];
    rigcal_status status;
    rigcal_point_gain gains[CAMERAS];
    rigcal_measured_point measured;
} measurement;

static void measure(measurement *m, test_rng *rng, int n, int n_wrong, int keep_all)
{
    static rigcal_real work[RIGCAL_POINT_WORK(CAMERAS)];
    rigcal_sighting seen[CAMERAS];
    const rigcal_sightings s = {.rig = &r.kept,
                                .seen = seen,
                                .n = (size_t)n,
                                .keep_all = keep_all,
                                .work = work,
                                .work_capacity = RIGCAL_POINT_WORK(CAMERAS)};
    const int first = (int)test_uniform(rng, 0, r.n);
    double middle[3];

    memset(m, 0, sizeof *m);
    m->n = n;
    m->n_wrong = n_wrong;
    test_to_double(middle, r.places[(int)test_uniform(rng, 0, PLACES)].t, 3);
    for (int k = 0; k < 3; k++) {
        m->X[k] = middle[k] + 0.3 * test_normal(rng);
    }
    for (int i = 0; i < n; i++) {
        const int c = (first + i) % r.n;

        seen[i].camera = c;
        see(seen[i].uv, rng, c, m->X);
        if (i < n_wrong) {
            const double way = test_uniform(rng, -TEST_PI, TEST_PI);
            const double off = test_uniform(rng, WRONG_LEAST, WRONG_MOST);

            seen[i].uv[0] += RC(off * cos(way));
            seen[i].uv[1] += RC(off * sin(way));
            m->is_wrong[i] = 1;
        }
    }
    m->measured.gains = m->gains;
    m->measured.gains_capacity = CAMERAS;
    m->status = rigcal_point_measure(&m->measured, m->used, &s);
}

/* d^T Sigma^-1 d, by Gaussian elimination. */
static double over(const rigcal_real Sigma[9], const double d[3])
{
    double A[3][4], sum = 0;

    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            A[i][j] = D(Sigma[3 * i + j]);
        }
        A[i][3] = d[i];
    }
    for (int k = 0; k < 3; k++) {
        sum += A[k][3] * A[k][3] / A[k][k];
        for (int i = k + 1; i < 3; i++) {
            const double part = A[i][k] / A[k][k];
            for (int j = k; j < 4; j++) {
                A[i][j] -= part * A[k][j];
            }
        }
    }
    return sum;
}

static void error_of(double d[3], const measurement *m)
{
    for (int k = 0; k < 3; k++) {
        d[k] = D(m->measured.X[k]) - m->X[k];
    }
}

/* ---- sigmas ---------------------------------------------------------------- */

typedef struct {
    int points, whole, noise, chi2, lengths, length, refused;
} shares;

static void count(shares *t, const measurement *m, const measurement *last)
{
    double d[3];

    if (m->status < 0) {
        t->refused++;
        return;
    }
    error_of(d, m);
    t->points++;
    t->whole += over(m->measured.Sigma, d) <= ELLIPSOID;
    t->noise += over(m->measured.Sigma_noise, d) <= ELLIPSOID;
    t->chi2 += D(m->measured.chi2) <= CHI2[m->n];
    if (last != NULL && last->status >= 0) {
        rigcal_real length, sigma;
        double between[3];

        for (int k = 0; k < 3; k++) {
            between[k] = m->X[k] - last->X[k];
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_point_distance(&length, &sigma, &r.kept,
                                                       &m->measured, &last->measured));
        t->lengths++;
        t->length += fabs(D(length) - test_norm(between)) <= INTERVAL * D(sigma);
    }
}

static double percent(int part, int of)
{
    return of > 0 ? 100.0 * part / of : 0;
}

static int is_within(double share, double low, double high)
{
    return share >= low && share <= high;
}

/* Returns 0 if a share misses its limits. */
static int sigmas(int n, lens_kind lens, int rigs)
{
    static const char *const NAMES[LENSES] = {"pinhole", "Brown", "fisheye"};
    static measurement m[2];
    shares t = {0, 0, 0, 0, 0, 0, 0};

    for (int trial = 0; trial < rigs; trial++) {
        test_rng rng = test_seed(400000 + 100000 * (uint64_t)n + 10000 * (uint64_t)lens +
                                 (uint64_t)trial);

        if (!make_rig(&rng, n < 3 ? 3 : n, lens)) {
            continue;
        }
        for (int i = 0; i < POINTS; i++) {
            measure(&m[i % 2], &rng, n, 0, 1);
            count(&t, &m[i % 2], i % 2 == 1 ? &m[0] : NULL);
        }
    }
    const double whole = percent(t.whole, t.points), chi2 = percent(t.chi2, t.points),
                 length = percent(t.length, t.lengths);
    printf("| %d | %s | %.1f %% | %.1f %% | %.2f %% | %.1f %% | %d of %d |\n", n,
           NAMES[lens], whole, percent(t.noise, t.points), chi2, length, t.refused,
           t.points + t.refused);
    /* Points of one rig share its error, so the shares scatter: three standard errors of 50
     * rigs are 2 %. */
    const double spare = rigs < 500 ? 2 : 0;
    return is_within(whole, 94 - spare, 96 + spare) &&
           is_within(length, 94 - spare, 96 + spare) &&
           is_within(chi2, 98.4 - spare / 5, 99.6 + spare / 5);
}

/* ---- wrong views ------------------------------------------------------------ */

typedef struct {
    int views, wrong;
    double least; /* least percentages: exactly the right views kept; all right views
                     kept */
} fault;

static const fault FAULTS[] = {{3, 1, 95}, {4, 1, 99}, {6, 1, 99}, {6, 2, 99},
                               {8, 2, 99}, {8, 3, 99}, {4, 0, 98}, {8, 0, 98}};
enum { N_FAULTS = sizeof FAULTS / sizeof FAULTS[0] };

static int faults(const fault *f, int rigs)
{
    int points = 0, exact = 0, kept_wrong = 0, refused = 0, told = 0, held = 0;
    static measurement m;

    for (int trial = 0; trial < rigs; trial++) {
        test_rng rng = test_seed(900000 + 10000 * (uint64_t)f->views +
                                 100000 * (uint64_t)f->wrong + (uint64_t)trial);

        if (!make_rig(&rng, f->views, (lens_kind)(trial % LENSES))) {
            continue;
        }
        for (int i = 0; i < POINTS; i++) {
            double d[3];
            int is_exact = 1, has_wrong = 0;

            measure(&m, &rng, f->views, f->wrong, 0);
            points++;
            if (m.status < 0) {
                refused++;
                continue;
            }
            for (int k = 0; k < f->views; k++) {
                is_exact = is_exact && m.used[k] == !m.is_wrong[k];
                has_wrong = has_wrong || (m.used[k] && m.is_wrong[k]);
            }
            error_of(d, &m);
            exact += is_exact;
            kept_wrong += has_wrong;
            told += m.status == RIGCAL_FEW_AGREE;
            held += is_exact && over(m.measured.Sigma, d) <= ELLIPSOID;
        }
    }
    const double share = percent(exact, points);
    printf("| %d | %d | %.2f %% | %.2f %% | %.2f %% | %.1f %% | %.1f %% |\n", f->views,
           f->wrong, share, percent(kept_wrong, points), percent(refused, points),
           percent(told, points), percent(held, exact));
    return share >= f->least;
}

/* Returns 0 if a share misses its limits. */
static int tables(int rigs)
{
    int good = 1;

    printf("%s; %s, %d rigs a line of %d points\n\n", BENCH_BUILD,
           sizeof(rigcal_real) == sizeof(double) ? "double" : "float", rigs, POINTS);
    puts("| views | lens | 95 % ellipsoid holds | without the calibration | chi square at "
         "99 % | 95 % interval of a length | refused |\n"
         "| ---: | --- | ---: | ---: | ---: | ---: | ---: |");
    for (int lens = 0; lens < LENSES; lens++) {
        good = sigmas(2, (lens_kind)lens, rigs) && good;
        good = sigmas(4, (lens_kind)lens, rigs) && good;
    }
    puts(
        "\n| views | wrong, by 5 to 60 px | exactly the right ones kept | a wrong one kept "
        "| refused | told that only two agree | 95 % ellipsoid then holds |\n"
        "| ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    for (int i = 0; i < N_FAULTS; i++) {
        good = faults(&FAULTS[i], rigs) && good;
    }
    return good;
}

int main(int argc, char *argv[])
{
    const int is_check = argc == 2 && strcmp(argv[1], "check") == 0;
    const int rigs = is_check ? 50 : argc > 1 ? atoi(argv[1]) : 500;

    if (argc > 2 || rigs < 1) {
        fputs("usage: bench_points [RIGS | check]\n", stderr);
        return 2;
    }
    UNITY_BEGIN();
    if (!TEST_PROTECT()) {
        return 1;
    }
    return !tables(rigs) && is_check;
}

void setUp(void)
{
}

void tearDown(void)
{
}
