/* evidence: what one view says of faults. The truth: the sums point by point, in double, of
 * derivatives by differences. */
#include <math.h>
#include <string.h>

#include "rc_evidence.h"
#include "test_support.h"

enum { N = 9, BEFORE = 1, ROOM = N + 2 };

static const double SINCE = 1.5, NO_REFERENCE[3] = {0, 0, 0};

/* A view of nine points in three rows. There is one point before and one behind what is
 * handed in. */
static rigcal_camera camera;
static rigcal_observation o[ROOM];
static rigcal_real sigma[ROOM], reference[3], m[6];
static rigcal_rig_view view;
static rigcal_transform camera_pose, place;
static rc_chain chain;
static rc_scan scan;

static void set_up(uint64_t seed, int lens, const double of_reference[3])
{
    static const double V[15] = {0,    640,   480,    700,  720,  310,   250,  -0.1,
                                 0.05, 0.001, -0.002, 0.01, 0.02, -0.01, 0.003};
    test_rng rng = test_seed(seed);
    const double axis[3] = {0.3, 1, -0.2}, at[3] = {0.1, -0.05, 1.1};
    double R[9];

    camera = test_camera(V);
    camera.lens = lens;
    if (lens == RIGCAL_LENS_FISHEYE) {
        camera.p1 = camera.p2 = camera.k5 = camera.k6 = 0;
    }
    test_rotation_about(R, axis, 0.4);
    camera_pose = test_random_transform(&rng);
    const rigcal_transform target = test_transform(R, at),
                           back = test_inverse(&camera_pose);
    place = test_times(&back, &target);
    rc_chain_of(&chain, &camera_pose, &place);
    for (int i = 0; i < ROOM; i++) {
        const int k = i - BEFORE;
        const double X[3] = {0.1 * ((k + 3) % 3) - 0.1, 0.1 * ((k + 3) / 3) - 0.2,
                             0.01 * test_uniform(&rng, -1, 1)};
        double X_c[3], uv[2];

        test_to_real(o[i].X_w, X, 3);
        test_move_point(X_c, &chain.cam_from_target, X);
        test_project_px(uv, &camera, X_c);
        o[i].uv[0] = RC(uv[0] + test_normal(&rng));
        o[i].uv[1] = RC(uv[1] + test_normal(&rng));
        sigma[i] = RC(test_uniform(&rng, 0.5, 2));
    }
    memset(&view, 0, sizeof view);
    view.view = (rigcal_view){&camera, &o[BEFORE], &sigma[BEFORE], N};
    for (int k = 0; k < 6; k++) {
        m[k] = RC(test_uniform(&rng, -1, 1));
    }
    test_to_real(reference, of_reference, 3);
    scan = (rc_scan){{RC(0.02), RC(-0.03)}, {RC(0.13), RC(0.12)}, 0, reference};
}

/* ---- the truth ----------------------------------------------------------------- */

typedef struct {
    double e[2], J[2][6], D[2][RC_COLUMNS];
} plain_rows;

/* d uv / d X_c by differences. */
static void by_place(double B[2][3], const double X_c[3])
{
    const double h = 1e-5;

    for (int k = 0; k < 3; k++) {
        double ends[2][2];

        for (int i = 0; i < 2; i++) {
            double moved[3] = {X_c[0], X_c[1], X_c[2]};

            moved[k] += i ? h : -h;
            test_project_px(ends[i], &camera, moved);
        }
        B[0][k] = (ends[1][0] - ends[0][0]) / (2 * h);
        B[1][k] = (ends[1][1] - ends[0][1]) / (2 * h);
    }
}

/* d uv / d parameter of the camera. It is linear. */
static void by_camera(double d[2], const double X_c[3], int parameter)
{
    const rigcal_real h = RC(0.125);
    rigcal_camera other = camera;
    double from[2], to[2];

    switch (parameter) {
    case RC_BY_FOCAL:
        other.fx *= 1 + h;
        other.fy *= 1 + h;
        break;
    case RC_BY_ASPECT:
        other.fx *= 1 + h / 2;
        other.fy *= 1 - h / 2;
        break;
    case RC_BY_CENTRE:
        other.cx += h;
        break;
    case RC_BY_CENTRE + 1:
        other.cy += h;
        break;
    case RC_BY_K1:
        other.k1 += h;
        break;
    default:
        other.k2 += h;
        break;
    }
    test_project_px(from, &camera, X_c);
    test_project_px(to, &other, X_c);
    d[0] = (to[0] - from[0]) / D(h);
    d[1] = (to[1] - from[1]) / D(h);
}

static void plain_of(plain_rows *p, int i)
{
    const rigcal_observation *const seen = &o[BEFORE + i];
    const double s = D(sigma[BEFORE + i]);
    double R[9], t[3], X[3], X_c[3], q[3], uv[2], B[2][3];

    test_transform_parts(R, t, &chain.cam_from_target);
    test_to_double(X, seen->X_w, 3);
    test_apply(q, R, X, NULL);
    test_apply(X_c, R, X, t);
    test_project_px(uv, &camera, X_c);
    by_place(B, X_c);
    const double x = (X[0] - 0.02) / 0.13, y = (X[1] + 0.03) / 0.12;
    const double out[2] = {1 - x * x, 1 - y * y};
    const double row_time = (D(seen->uv[1]) - 239.5) / 480;
    memset(p, 0, sizeof *p);
    for (int row = 0; row < 2; row++) {
        double *const D_row = p->D[row], turn[3];

        p->e[row] = (D(seen->uv[row]) - uv[row]) / s;
        test_cross(p->J[row], q, B[row]);
        memcpy(&p->J[row][3], B[row], sizeof B[row]);
        for (int k = 0; k < 6; k++) {
            p->J[row][k] /= s;
            D_row[RC_BY_CLOCK] += p->J[row][k] * D(m[k]);
        }
        D_row[RC_BY_DRIFT] = SINCE * D_row[RC_BY_CLOCK];
        D_row[RC_BY_SHUTTER] = row_time * D_row[RC_BY_CLOCK];
        for (int k = 0; k < RC_INTRINSICS; k++) {
            double d[2];

            by_camera(d, X_c, k);
            D_row[RC_BY_INTRINSICS + k] = d[row] / s;
        }
        /* less a turn about the centre, or a shift */
        test_cross(turn, X_c, B[row]);
        D_row[RC_BY_INTRINSICS + RC_BY_FOCAL] += B[row][2] * D(reference[2]) / s;
        D_row[RC_BY_INTRINSICS + RC_BY_CENTRE] -= turn[1] * D(reference[0]) / s;
        D_row[RC_BY_INTRINSICS + RC_BY_CENTRE + 1] += turn[0] * D(reference[1]) / s;
        for (int k = 0; k < 3; k++) {
            D_row[RC_BY_BENT] += B[row][k] * R[3 * k + 2] * out[0] / s;
            D_row[RC_BY_BENT + 1] += B[row][k] * R[3 * k + 2] * out[1] / s;
            D_row[RC_BY_STRETCHED] +=
                B[row][k] * (R[3 * k] * X[0] - R[3 * k + 1] * X[1]) / 2 / s;
        }
    }
}

static double dot_rows(const double a[], const double b[], size_t step_a, size_t step_b)
{
    return a[0] * b[0] + a[step_a] * b[step_b];
}

/* The sums over these points, which are neighbours if they follow each other in a row. */
typedef struct {
    double sum, g[6], H[36], E[RC_COLUMNS][6], Q[RC_COLUMNS], q[RC_COLUMNS],
        pairs[RC_PAIRS];
    double product, mixed[6], M[36];
} plain_sums;

static void add_plain(plain_sums *s, const plain_rows *p)
{
    static const int FIRST[RC_PAIRS] = {RC_BY_INTRINSICS + 2, RC_BY_INTRINSICS + 4,
                                        RC_BY_BENT};

    s->sum += dot_rows(p->e, p->e, 1, 1);
    for (int i = 0; i < 36; i++) {
        s->H[i] += dot_rows(&p->J[0][i / 6], &p->J[0][i % 6], 6, 6);
    }
    for (int i = 0; i < 6; i++) {
        s->g[i] += dot_rows(&p->J[0][i], p->e, 6, 1);
    }
    for (int c = 0; c < RC_COLUMNS; c++) {
        for (int i = 0; i < 6; i++) {
            s->E[c][i] += dot_rows(&p->D[0][c], &p->J[0][i], RC_COLUMNS, 6);
        }
        s->Q[c] += dot_rows(&p->D[0][c], &p->D[0][c], RC_COLUMNS, RC_COLUMNS);
        s->q[c] += dot_rows(&p->D[0][c], p->e, RC_COLUMNS, 1);
    }
    for (int k = 0; k < RC_PAIRS; k++) {
        s->pairs[k] +=
            dot_rows(&p->D[0][FIRST[k]], &p->D[0][FIRST[k] + 1], RC_COLUMNS, RC_COLUMNS);
    }
}

static void add_plain_neighbours(plain_sums *s, const plain_rows *a, const plain_rows *b)
{
    s->product += dot_rows(a->e, b->e, 1, 1);
    for (int i = 0; i < 6; i++) {
        s->mixed[i] +=
            dot_rows(&a->J[0][i], b->e, 6, 1) + dot_rows(&b->J[0][i], a->e, 6, 1);
    }
    for (int i = 0; i < 36; i++) {
        s->M[i] += dot_rows(&a->J[0][i / 6], &b->J[0][i % 6], 6, 6);
    }
}

static void plain_of_view(plain_sums *s, int left_out)
{
    plain_rows rows[N];

    memset(s, 0, sizeof *s);
    for (int i = 0; i < N; i++) {
        plain_of(&rows[i], i);
        if (i == left_out) {
            continue;
        }
        add_plain(s, &rows[i]);
        if (i % 3 > 0 && i - 1 != left_out) {
            add_plain_neighbours(s, &rows[i - 1], &rows[i]);
        }
    }
}

/* Relative to the size of two columns. */
static void near(double expected, rigcal_real seen, double a2, double b2)
{
    const double scale = sqrt(a2 * b2) + 1e-30;

    ASSERT_NEAR(expected / scale, D(seen) / scale, TOL(1e-7, 1e-3));
}

static void compare(const rc_evidence *v, const plain_sums *s)
{
    rigcal_real H[36];

    rc_sym6_unpack(H, v->H);
    near(s->sum, v->sum, s->sum, s->sum);
    near(s->product, v->product, s->sum, s->sum);
    for (int i = 0; i < 6; i++) {
        const double h = s->H[7 * i];

        near(s->g[i], v->g[i], h, s->sum);
        near(s->mixed[i], v->mixed[i], h, s->sum);
        for (int j = 0; j < 6; j++) {
            near(s->H[6 * i + j], H[6 * i + j], h, s->H[7 * j]);
            near(s->M[6 * i + j], v->M[6 * i + j], h, s->H[7 * j]);
        }
        for (int c = 0; c < RC_COLUMNS; c++) {
            near(s->E[c][i], v->E[c][i], h, s->Q[c]);
        }
        ASSERT_NEAR(D(m[i]), v->m[i], 0);
    }
    for (int c = 0; c < RC_COLUMNS; c++) {
        near(s->Q[c], v->Q[c], s->Q[c], s->Q[c]);
        near(s->q[c], v->q[c], s->Q[c], s->sum);
    }
    near(s->pairs[0], v->pairs[0], s->Q[RC_BY_INTRINSICS + 2], s->Q[RC_BY_INTRINSICS + 3]);
    near(s->pairs[1], v->pairs[1], s->Q[RC_BY_INTRINSICS + 4], s->Q[RC_BY_INTRINSICS + 5]);
    near(s->pairs[2], v->pairs[2], s->Q[RC_BY_BENT], s->Q[RC_BY_BENT + 1]);
}

static rigcal_status evidence_of(rc_evidence *v)
{
    return rc_evidence_of(v, &scan, &view, &chain, m, RC(SINCE));
}

/* ---- the sums ------------------------------------------------------------------ */

static void test_all_sums_are_those_of_differences(void)
{
    static const double TURNS[3] = {0.001, -0.002, 0.3};

    for (int k = 0; k < 8; k++) {
        rc_evidence v;
        plain_sums s;

        set_up(100 + (uint64_t)k, k % 2 ? RIGCAL_LENS_FISHEYE : RIGCAL_LENS_BROWN,
               k % 4 < 2 ? NO_REFERENCE : TURNS);
        plain_of_view(&s, -1);
        FILL(v);
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        TEST_ASSERT_EQUAL_size_t(N, v.n);
        TEST_ASSERT_EQUAL_size_t(6, v.n_neighbours);
        ASSERT_NEAR(0, v.stamp, 0);
        ASSERT_NEAR(1, v.left, 0);
        compare(&v, &s);
    }
}

/* Points beyond the limit do not count, and are nobody's neighbours. Neither are points
 * that the camera cannot see, if there is a limit. */
static void test_points_beyond_the_limit_do_not_count(void)
{
    for (int i = 0; i < N; i++) {
        for (int what = 0; what < 2; what++) {
            rc_evidence v;
            plain_sums s;

            set_up(200 + (uint64_t)i, RIGCAL_LENS_BROWN, NO_REFERENCE);
            if (what == 0) {
                o[BEFORE + i].uv[0] += 100;
            } else {
                o[BEFORE + i].X_w[2] += 30; /* behind the camera, or far beside */
                o[BEFORE + i].X_w[2] *= -1;
            }
            scan.limit2 = 900;
            plain_of_view(&s, i);
            ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
            TEST_ASSERT_EQUAL_size_t(N - 1, v.n);
            TEST_ASSERT_EQUAL_size_t(i % 3 == 1 ? 4 : 5, v.n_neighbours);
            compare(&v, &s);
            scan.limit2 = 0;
            ASSERT_STATUS(what ? RIGCAL_ERR_BEHIND : RIGCAL_OK, evidence_of(&v));
        }
    }
}

/* A point at the limit counts, and one beyond it does not, whatever the limit. */
static void test_the_limit_itself_is_within(void)
{
    for (int k = 0; k < 6; k++) {
        rc_evidence v;

        set_up(300 + (uint64_t)k, RIGCAL_LENS_BROWN, NO_REFERENCE);
        view.view.n = 1;
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        scan.limit2 = v.sum;
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        TEST_ASSERT_EQUAL_size_t(1, v.n);
        scan.limit2 *= RC(0.999);
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        TEST_ASSERT_EQUAL_size_t(0, v.n);
        scan.limit2 = RC(1e-6);
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        TEST_ASSERT_EQUAL_size_t(0, v.n);
        o[BEFORE].X_w[2] = -30;
        scan.limit2 = RC(0.5);
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        TEST_ASSERT_EQUAL_size_t(0, v.n);
    }
}

/* Points of a line in steps of these lengths. Those up to 1.2 times the shortest are
 * between neighbours, whichever is the shortest. Points before and after the view are no
 * part of it. */
static void test_neighbours_are_nearly_the_shortest_step_apart(void)
{
    static const double STEPS[4][5] = {{0.01, 0.1, 0.13, 0.13, 0.01},
                                       {0.01, 0.13, 0.13, 0.1, 0.01},
                                       {0.01, 0.13, 0.1, 0.13, 0.01},
                                       {0.11, 0.1, 0.119, 0.121, 0.11}};
    static const size_t NEIGHBOURS[4] = {1, 1, 1, 2};

    for (int k = 0; k < 4; k++) {
        rc_evidence v;
        double at = -0.2;

        set_up(400, RIGCAL_LENS_BROWN, NO_REFERENCE);
        for (int i = 0; i < 6; i++) {
            o[i].X_w[0] = RC(at);
            o[i].X_w[1] = o[i].X_w[2] = 0;
            at += i < 5 ? STEPS[k][i] : 0;
        }
        view.view.n = 4;
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        TEST_ASSERT_EQUAL_size_t(NEIGHBOURS[k], v.n_neighbours);
    }
}

/* ---- what is subtracted --------------------------------------------------------- */

static void test_what_a_reference_subtracts(void)
{
    static const double TURNS[3] = {0.001, -0.002, 0.3};
    rigcal_real of[3];

    test_to_real(of, TURNS, 3);
    for (size_t c = 0; c < RC_COLUMNS; c++) {
        const size_t k = c - RC_BY_INTRINSICS;
        const int has = k == RC_BY_FOCAL || k == RC_BY_CENTRE || k == RC_BY_CENTRE + 1;
        rigcal_real w[4], v[4];

        FILL(w);
        FILL(v);
        w[3] = v[3] = 77;
        TEST_ASSERT_EQUAL_INT(has, rc_evidence_reference(w, v, of, c) != 0);
        ASSERT_NEAR(k == RC_BY_CENTRE + 1 ? 0.002 : 0, w[0], 1e-9);
        ASSERT_NEAR(k == RC_BY_CENTRE ? 0.001 : 0, w[1], 1e-9);
        ASSERT_NEAR(0, w[2], 0);
        ASSERT_NEAR(0, v[0], 0);
        ASSERT_NEAR(0, v[1], 0);
        ASSERT_NEAR(k == RC_BY_FOCAL ? -0.3 : 0, v[2], 1e-7);
        ASSERT_NEAR(77, w[3], 0);
        ASSERT_NEAR(77, v[3], 0);
    }
}

/* ---- the stamp, and the view by itself ---------------------------------------------- */

/* (H11), term by term. */
static void test_noise_of_the_stamp_is_eliminated(void)
{
    for (int k = 0; k < 3; k++) {
        const double ratio2 = k == 0 ? 0 : k == 1 ? 0.5 : 1e5;
        rc_evidence v;

        set_up(500, RIGCAL_LENS_BROWN, NO_REFERENCE);
        ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
        rc_evidence_stamp(&v, RC(ratio2));
        const double s = D(v.Q[RC_BY_CLOCK]) + ratio2, part = k == 0 ? 0 : 1 / s;
        ASSERT_NEAR(part * s, D(v.stamp) * s, TOL(1e-14, 1e-6));
        ASSERT_NEAR(k == 0 ? 1 : ratio2 / s, v.left, TOL(1e-14, 1e-6));
        for (size_t c = 0; c < RC_COLUMNS; c++) {
            rigcal_real E[6], Q, q, along;
            double sum = 0;

            rc_evidence_weighed(E, &Q, &q, &along, &v, c);
            for (int i = 0; i < 6; i++) {
                sum += D(m[i]) * D(v.E[c][i]);
            }
            near(sum, along, D(v.Q[c]), D(v.Q[RC_BY_CLOCK]));
            near(D(v.Q[c]) - part * sum * sum, Q, D(v.Q[c]), D(v.Q[c]));
            near(D(v.q[c]) - part * sum * D(v.q[RC_BY_CLOCK]), q, D(v.Q[c]), D(v.sum));
            for (int i = 0; i < 6; i++) {
                const double e = D(v.E[c][i]) - part * sum * D(v.E[RC_BY_CLOCK][i]);
                ASSERT_NEAR(e, E[i], TOL(1e-9, 1e-3) * (1 + fabs(D(v.E[c][i]))));
            }
        }
    }
}

/* x = A^-1 b by elimination, for n right sides. */
static void solve(double x[][6], const double A[36], const double b[][6], int n)
{
    double left[6][6];

    for (int i = 0; i < 36; i++) {
        left[i / 6][i % 6] = A[i];
    }
    memcpy(x, b, (size_t)n * 6 * sizeof(double));
    for (int k = 0; k < 6; k++) {
        for (int i = 0; i < 6; i++) {
            const double by = i == k ? 0 : left[i][k] / left[k][k];

            for (int j = 0; j < 6; j++) {
                left[i][j] -= by * left[k][j];
            }
            for (int c = 0; c < n; c++) {
                x[c][i] -= by * x[c][k];
            }
        }
    }
    for (int i = 0; i < 6; i++) {
        for (int c = 0; c < n; c++) {
            x[c][i] /= left[i][i];
        }
    }
}

static double dot6(const double a[6], const double b[6])
{
    return test_dot(a, b) + test_dot(&a[3], &b[3]);
}

/* (H8), (H12): with the inverse of H. */
static void test_a_view_by_itself_fits_its_own_pose(void)
{
    enum { ALL = RC_COLUMNS + 7 };
    static const int FIRST[RC_PAIRS] = {RC_BY_INTRINSICS + 2, RC_BY_INTRINSICS + 4,
                                        RC_BY_BENT};
    double sides[ALL][6] = {{0}}, x[ALL][6];
    rc_evidence v;
    plain_sums s;
    rigcal_real d[6], expected;

    set_up(600, RIGCAL_LENS_BROWN, NO_REFERENCE);
    plain_of_view(&s, -1);
    ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
    memcpy(sides, s.E, sizeof s.E);
    memcpy(sides[RC_COLUMNS], s.g, sizeof s.g);
    for (int i = 0; i < 6; i++) {
        sides[RC_COLUMNS + 1 + i][i] = 1;
    }
    solve(x, s.H, (const double(*)[6])sides, ALL);
    const double *const step = x[RC_COLUMNS];
    TEST_ASSERT_EQUAL_INT(1, rc_evidence_alone(&v, d));
    near(s.sum - dot6(s.g, step), v.sum, s.sum, s.sum);
    double trace = 0, product = s.product - dot6(step, s.mixed);
    for (int i = 0; i < 6; i++) {
        ASSERT_NEAR(1, 1 + (D(d[i]) - step[i]) * sqrt(s.H[7 * i] / s.sum), TOL(1e-6, 2e-2));
        trace += dot6(x[RC_COLUMNS + 1 + i], &s.M[6 * i]);
        product += step[i] * dot6(&s.M[6 * i], step);
    }
    for (int c = 0; c < RC_COLUMNS; c++) {
        near(s.Q[c] - dot6(s.E[c], x[c]), v.Q[c], s.Q[c], s.Q[c]);
        near(s.q[c] - dot6(s.E[c], step), v.q[c], s.Q[c], s.sum);
    }
    for (int k = 0; k < RC_PAIRS; k++) {
        const int c = FIRST[k];
        near(s.pairs[k] - dot6(s.E[c], x[c + 1]), v.pairs[k], s.Q[c], s.Q[c + 1]);
    }
    ASSERT_NEAR(product, rc_evidence_pattern(&expected, &v, d), TOL(1e-5, 0.05) * s.sum);
    ASSERT_NEAR(-trace, expected, TOL(1e-5, 0.05));
}

static void test_a_view_of_one_point_has_no_pose_of_its_own(void)
{
    rigcal_real d[6];
    rc_evidence v;

    set_up(700, RIGCAL_LENS_BROWN, NO_REFERENCE);
    view.view.n = 1;
    ASSERT_STATUS(RIGCAL_OK, evidence_of(&v));
    TEST_ASSERT_EQUAL_INT(0, rc_evidence_alone(&v, d));
}

TEST_MAIN()
{
    RUN_TEST(test_all_sums_are_those_of_differences);
    RUN_TEST(test_points_beyond_the_limit_do_not_count);
    RUN_TEST(test_the_limit_itself_is_within);
    RUN_TEST(test_neighbours_are_nearly_the_shortest_step_apart);
    RUN_TEST(test_what_a_reference_subtracts);
    RUN_TEST(test_noise_of_the_stamp_is_eliminated);
    RUN_TEST(test_a_view_by_itself_fits_its_own_pose);
    RUN_TEST(test_a_view_of_one_point_has_no_pose_of_its_own);
}
