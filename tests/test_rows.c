/* rows: what cameras see as rows between bodies. The truth: differences of the
 * measurements, made in double by the formulas of rigcal.h. */
#include <math.h>
#include <string.h>

#include "rc_rows.h"
#include "test_support.h"

typedef struct {
    double R[9], t[3];
} body;

static const double SIGMA = 0.3;

/* ---- the measurements, in double ----------------------------------------------- */

static body body_of(const rigcal_transform *T)
{
    body b;

    test_transform_parts(b.R, b.t, T);
    return b;
}

/* Turns a body by w about its own centre, then shifts it by ds: d = (w, ds). */
static body moved(const body *b, const double d[6])
{
    const double angle = test_norm(d);
    double turn[9];
    body out = *b;

    if (angle > 0) {
        test_rotation_about(turn, d, angle);
        test_product(out.R, turn, b->R);
        test_apply(out.t, turn, b->t, NULL);
    }
    for (int k = 0; k < 3; k++) {
        out.t[k] += d[3 + k];
    }
    return out;
}

/* Turns R by w, and adds dt to t: d = (w, dt). */
static body stepped(const body *b, const double d[6])
{
    body out = moved(b, d);

    for (int k = 0; k < 3; k++) {
        out.t[k] = b->t[k] + d[3 + k];
    }
    return out;
}

/* The ray of a pixel, with z = 1 or of unit length, by Newton's method from a ray
 * nearby. */
static void ray_of(double m[3], const rigcal_camera *camera, const double uv[2],
                   const double near[3])
{
    memcpy(m, near, 3 * sizeof m[0]);
    for (int i = 0; i < 30; i++) {
        double px[2], J[2][2];

        test_project_px(px, camera, m);
        for (int k = 0; k < 2; k++) {
            double step[3] = {m[0], m[1], m[2]}, up[2], down[2];

            step[k] += 1e-6;
            test_project_px(up, camera, step);
            step[k] -= 2e-6;
            test_project_px(down, camera, step);
            J[0][k] = (up[0] - down[0]) / 2e-6;
            J[1][k] = (up[1] - down[1]) / 2e-6;
        }
        const double e[2] = {uv[0] - px[0], uv[1] - px[1]};
        const double det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
        m[0] += (J[1][1] * e[0] - J[0][1] * e[1]) / det;
        m[1] += (J[0][0] * e[1] - J[1][0] * e[0]) / det;
    }
}

static double constraint(const body *a, const body *b, const double m_a[3],
                         const double m_b[3])
{
    double At[9], R[9], t[3], q[3], n[3];

    test_transpose(At, a->R);
    test_product(R, b->R, At);
    test_apply(t, R, a->t, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] = b->t[k] - t[k];
    }
    test_apply(q, R, m_a, NULL);
    test_cross(n, t, q);
    return test_dot(m_b, n);
}

/* A match, the rays of its pixels, and these rays after each pixel moved a little. */
typedef struct {
    double rays[2][5][3];
} matched;

static const double STEP = 1e-2;

static void match(matched *m, const rigcal_camera camera[2], double uv[2][2],
                  double near[2][3])
{
    for (int c = 0; c < 2; c++) {
        for (int k = 0; k < 5; k++) {
            const double at[2] = {uv[c][0] + (k == 1   ? STEP
                                              : k == 2 ? -STEP
                                                       : 0),
                                  uv[c][1] + (k == 3   ? STEP
                                              : k == 4 ? -STEP
                                                       : 0)};
            ray_of(m->rays[c][k], &camera[c], at, near[c]);
        }
    }
}

/* Sampson's distance in pixels over SIGMA. The derivative of e by the pixels is a
 * difference quotient. */
static double distance(const matched *m, const body *a, const body *b)
{
    double square = 0;

    for (int k = 1; k < 5; k += 2) {
        const double by_a = constraint(a, b, m->rays[0][k], m->rays[1][0]) -
                            constraint(a, b, m->rays[0][k + 1], m->rays[1][0]);
        const double by_b = constraint(a, b, m->rays[0][0], m->rays[1][k]) -
                            constraint(a, b, m->rays[0][0], m->rays[1][k + 1]);
        square += (by_a * by_a + by_b * by_b) / (4 * STEP * STEP);
    }
    return -constraint(a, b, m->rays[0][0], m->rays[1][0]) / (SIGMA * sqrt(square));
}

/* ---- scenes ---------------------------------------------------------------------- */

static rigcal_camera lens(int kind)
{
    static const double PINHOLE[15] = {0, 640, 480, 800, 780, 320, 240};
    static const double BROWN[15] = {0,   640,  480,   700,  710,  320, 250, -0.2,
                                     0.1, 1e-3, -5e-4, 0.02, 0.01, 0,   0};
    static const double FISHEYE[15] = {1, 640, 480, 300, 310, 330, 240, 0.02, -0.01};

    return test_camera(kind == 0 ? PINHOLE : kind == 1 ? BROWN : FISHEYE);
}

static void two_cameras(rigcal_transform T[2], test_rng *rng)
{
    for (int c = 0; c < 2; c++) {
        const double axis[3] = {test_normal(rng), test_normal(rng), test_normal(rng)};
        const double t[3] = {test_uniform(rng, -0.5, 0.5) - c, test_uniform(rng, -0.3, 0.3),
                             test_uniform(rng, -0.2, 0.2)};
        double R[9];

        test_rotation_about(R, axis, test_uniform(rng, 0, 0.2));
        T[c] = test_transform(R, t);
    }
}

/* The noisy pixels of a point, and the row that they give. */
static rigcal_status row_of(rc_row *row, matched *m, const rigcal_camera camera[2],
                            const rigcal_transform T[2], test_rng *rng, double noise)
{
    const double X[3] = {test_uniform(rng, -1, 1), test_uniform(rng, -1, 1),
                         test_uniform(rng, 2.5, 4)};
    double uv[2][2], near[2][3];
    rc_seen seen = {.a = 0, .b = 1, .n_rows = 1};

    for (int c = 0; c < 2; c++) {
        const body b = body_of(&T[c]);
        rigcal_real ray[3];
        double in_ray[3];

        test_apply(near[c], b.R, X, b.t);
        test_project_px(uv[c], &camera[c], near[c]);
        uv[c][0] += noise * test_normal(rng);
        uv[c][1] += noise * test_normal(rng);
        ray_of(in_ray, &camera[c], uv[c], near[c]);
        test_to_real(ray, in_ray, 3);
        ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[c], &camera[c], ray, RC(SIGMA)));
    }
    match(m, camera, uv, near);
    return rc_rows_of(row, &seen, &T[0], &T[1]);
}

/* ---- a match ----------------------------------------------------------------------- */

static void test_a_match_agrees_with_differences_through_any_lens(void)
{
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        test_rng rng = test_seed(10 + (uint64_t)trial);
        const rigcal_camera camera[2] = {lens(trial % 3), lens(trial / 3 % 3)};
        rigcal_transform T[2];
        rc_row row;
        matched m;

        two_cameras(T, &rng);
        ASSERT_STATUS(RIGCAL_OK, row_of(&row, &m, camera, T, &rng, 0));
        const body a = body_of(&T[0]), b = body_of(&T[1]);
        ASSERT_NEAR(0, row.r, TOL(1e-9, 0.05));
        double largest = 0;
        for (int k = 0; k < 6; k++) {
            largest = fmax(largest, fmax(fabs(D(row.h_a[k])), fabs(D(row.h_b[k]))));
        }
        for (int k = 0; k < 6; k++) {
            double d[6] = {0, 0, 0, 0, 0, 0}, less[6] = {0, 0, 0, 0, 0, 0};

            d[k] = 1e-5;
            less[k] = -1e-5;
            const body a1 = moved(&a, d), a2 = moved(&a, less), b1 = moved(&b, d),
                       b2 = moved(&b, less);
            ASSERT_NEAR((distance(&m, &a2, &b) - distance(&m, &a1, &b)) / 2e-5 / largest,
                        D(row.h_a[k]) / largest, TOL(1e-6, 1e-3));
            ASSERT_NEAR((distance(&m, &a, &b2) - distance(&m, &a, &b1)) / 2e-5 / largest,
                        D(row.h_b[k]) / largest, TOL(1e-6, 1e-3));
        }
    }
}

static void test_the_residual_is_sampsons_distance_in_standard_deviations(void)
{
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        test_rng rng = test_seed(90 + (uint64_t)trial);
        const rigcal_camera camera[2] = {lens(trial % 3), lens(trial / 3 % 3)};
        rigcal_transform T[2];
        rc_row row;
        matched m;

        two_cameras(T, &rng);
        ASSERT_STATUS(RIGCAL_OK, row_of(&row, &m, camera, T, &rng, SIGMA));
        const body a = body_of(&T[0]), b = body_of(&T[1]);
        const double seen = distance(&m, &a, &b);
        ASSERT_NEAR(seen, row.r, 2e-3 * fabs(seen) + TOL(1e-9, 0.02));
    }
}

/* At the noisy match, h along the base would be r / |base|. */
static void test_a_noisy_match_knows_nothing_of_the_length_of_the_base(void)
{
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        test_rng rng = test_seed(200 + (uint64_t)trial);
        const rigcal_camera camera[2] = {lens(0), lens(0)};
        rigcal_transform T[2];
        rc_row row;
        matched m;
        double At[9], R[9], base[3];

        two_cameras(T, &rng);
        ASSERT_STATUS(RIGCAL_OK, row_of(&row, &m, camera, T, &rng, 4 * SIGMA));
        const body a = body_of(&T[0]), b = body_of(&T[1]);
        test_transpose(At, a.R);
        test_product(R, b.R, At);
        test_apply(base, R, a.t, NULL);
        double along = 0;
        for (int k = 0; k < 3; k++) {
            base[k] = b.t[k] - base[k];
        }
        for (int k = 0; k < 3; k++) {
            along += base[k] * D(row.h_b[3 + k]);
        }
        ASSERT_NEAR(0, along, 5e-3 * fabs(D(row.r)) + TOL(1e-9, 5e-3));
        ASSERT_NEAR(test_norm(base), row.reach, 1e-5);
    }
}

static void test_a_move_of_all_bodies_together_is_not_seen(void)
{
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        test_rng rng = test_seed(300 + (uint64_t)trial);
        const rigcal_camera camera[2] = {lens(trial % 3), lens(1)};
        rigcal_transform T[2];
        rc_row row;
        matched m;
        double rig[6], sum = 0, largest = 0;

        two_cameras(T, &rng);
        ASSERT_STATUS(RIGCAL_OK, row_of(&row, &m, camera, T, &rng, 0));
        for (int k = 0; k < 6; k++) {
            rig[k] = test_normal(&rng);
        }
        for (int c = 0; c < 2; c++) {
            const body b = body_of(&T[c]);
            const rigcal_real *const h = c == 0 ? row.h_a : row.h_b;
            double d[6], turned[3];

            /* The rig turns by w and shifts by ds: p becomes p + R (w x X + ds). */
            test_apply(d, b.R, rig, NULL);
            test_apply(d + 3, b.R, rig + 3, NULL);
            test_cross(turned, b.t, d);
            for (int k = 0; k < 3; k++) {
                d[3 + k] += turned[k];
            }
            for (int k = 0; k < 6; k++) {
                sum += D(h[k]) * d[k];
                largest = fmax(largest, fabs(D(h[k])));
            }
        }
        ASSERT_NEAR(0, sum / largest, TOL(1e-9, 1e-4));
    }
}

static void test_a_match_on_the_line_through_both_centres_is_refused(void)
{
    const rigcal_camera camera = lens(0);
    const rigcal_real ahead[3] = {0, 0, 1}, aside[3] = {RC(0.3), 0, 1};
    rigcal_transform T[2];
    rc_seen seen = {.a = 0, .b = 1, .n_rows = 1};
    rc_row row;
    const double I[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, o[3] = {0, 0, 0}, z[3] = {0, 0, -0.5};

    ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[0], &camera, ahead, RC(SIGMA)));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[1], &camera, ahead, RC(SIGMA)));
    T[0] = test_transform(I, o);
    T[1] = test_transform(I, z);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_rows_of(&row, &seen, &T[0], &T[1]));
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_rows_of(&row, &seen, &T[0], &T[0]));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[0], &camera, aside, RC(SIGMA)));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[1], &camera, aside, RC(SIGMA)));
    ASSERT_STATUS(RIGCAL_OK, rc_rows_of(&row, &seen, &T[0], &T[1]));
    /* If one ray is this noisy, the match is within noise of the line. */
    for (int c = 0; c < 2; c++) {
        rc_seen noisy = seen;

        ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&noisy.sight[c], &camera, aside, 30));
        ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_rows_of(&row, &noisy, &T[0], &T[1]));
    }
}

/* A match is refused up to ten standard deviations from that line, of either ray: of a ray
 * along the axis the squares of (sigma / fx) and (sigma / fy) add up. */
static void test_a_match_is_refused_up_to_ten_deviations_from_the_line(void)
{
    static const double FACTORS[2] = {0.97, 1.03}, o[3] = {0, 0, 0}, z[3] = {0, 0, -0.5};
    const rigcal_camera camera = test_pinhole();
    const rigcal_transform T[2] = {test_transform(NULL, o), test_transform(NULL, z)};

    for (int k = 0; k < 16; k++) {
        const int noisy = k % 2, is_far = k / 2 % 2;
        const double way = k / 4 * 0.7;
        const double off =
            10 * hypot(SIGMA / D(camera.fx), SIGMA / D(camera.fy)) * FACTORS[is_far];
        const rigcal_real ray[3] = {RC(off * cos(way)), RC(off * sin(way)), 1};
        rc_seen seen = {.a = 0, .b = 1, .n_rows = 1};
        rc_row row;

        for (int c = 0; c < 2; c++) {
            const double sigma = c == noisy ? SIGMA : SIGMA / 4;

            ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[c], &camera, ray, RC(sigma)));
        }
        ASSERT_STATUS(is_far ? RIGCAL_OK : RIGCAL_ERR_DEGENERATE,
                      rc_rows_of(&row, &seen, &T[0], &T[1]));
    }
}

static void test_a_match_without_noise_is_refused(void)
{
    const rigcal_camera camera = lens(0);
    const rigcal_real aside[3] = {RC(0.3), 0, 1};
    const double o[3] = {0, 0, 0}, x[3] = {1, 0, 0};
    const rigcal_transform T[2] = {test_transform(NULL, o), test_transform(NULL, x)};
    rc_seen seen = {.a = 0, .b = 1, .n_rows = 1};
    rc_row row;

    for (int k = 0; k < 2; k++) {
        ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[k], &camera, aside, RC(SIGMA)));
    }
    ASSERT_STATUS(RIGCAL_OK, rc_rows_of(&row, &seen, &T[0], &T[1]));
    memset(seen.sight[0].T, 0, sizeof seen.sight[0].T);
    memset(seen.sight[1].T, 0, sizeof seen.sight[1].T);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_rows_of(&row, &seen, &T[0], &T[1]));
}

/* A camera in units of its focal length, and half of that. */
static void test_a_sight_has_any_unit_of_pixels(void)
{
    static const rigcal_real ray[3] = {RC(0.3), RC(0.1), 1};
    rigcal_camera camera = test_pinhole();
    rc_sight large, small;

    camera.k1 = RC(0.05);
    ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&large, &camera, ray, RC(1024)));
    camera.fx /= 1024;
    camera.fy /= 1024;
    ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&small, &camera, ray, 1));
    for (int k = 0; k < 6; k++) {
        ASSERT_NEAR(large.T[k / 3][k % 3], small.T[k / 3][k % 3], TOL(1e-9, 1e-2));
    }
}

/* ---- a view of a target -------------------------------------------------------------- */

static double coordinate(const rigcal_camera *camera, const body *a, const body *b,
                         const double X[3], int k)
{
    double Bt[9], u[3], Y[3], p[3], uv[2];

    test_transpose(Bt, b->R);
    for (int i = 0; i < 3; i++) {
        u[i] = X[i] - b->t[i];
    }
    test_apply(Y, Bt, u, NULL);
    test_apply(p, a->R, Y, a->t);
    test_project_px(uv, camera, p);
    return uv[k];
}

static void test_a_view_agrees_with_differences_through_any_lens(void)
{
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        test_rng rng = test_seed(400 + (uint64_t)trial);
        const rigcal_camera camera = lens(trial % 3);
        const double axis[3] = {test_normal(&rng), test_normal(&rng), test_normal(&rng)};
        double R[9], t[3] = {0.2, -0.1, -3}, X[3], largest = 0;
        rigcal_transform T[2];
        rc_seen seen = {.a = 0, .b = 1, .n_rows = 2};
        rc_row rows[2];

        two_cameras(T, &rng);
        test_rotation_about(R, axis, 0.5);
        T[1] = test_transform(R, t);
        for (int k = 0; k < 3; k++) {
            seen.X[k] = RC(test_uniform(&rng, -0.3, 0.3));
            X[k] = D(seen.X[k]);
        }
        const body a = body_of(&T[0]), b = body_of(&T[1]);
        seen.camera = &camera;
        seen.sigma_px = RC(SIGMA);
        seen.uv[0] = seen.uv[1] = RC(300);
        ASSERT_STATUS(RIGCAL_OK, rc_rows_of(rows, &seen, &T[0], &T[1]));
        for (int k = 0; k < 12; k++) {
            largest = fmax(largest, fabs(D(rows[k / 6].h_a[k % 6])));
        }
        for (int k = 0; k < 12; k++) {
            double d[6] = {0, 0, 0, 0, 0, 0}, less[6] = {0, 0, 0, 0, 0, 0};

            d[k % 6] = 1e-5;
            less[k % 6] = -1e-5;
            const body a1 = moved(&a, d), a2 = moved(&a, less), b1 = moved(&b, d),
                       b2 = moved(&b, less);
            const double scale = 2e-5 * SIGMA * largest;
            ASSERT_NEAR((300 - coordinate(&camera, &a, &b, X, k / 6)) / SIGMA,
                        rows[k / 6].r, TOL(1e-8, 2e-3));
            ASSERT_NEAR((coordinate(&camera, &a1, &b, X, k / 6) -
                         coordinate(&camera, &a2, &b, X, k / 6)) /
                            scale,
                        D(rows[k / 6].h_a[k % 6]) / largest, TOL(1e-6, 1e-3));
            ASSERT_NEAR((coordinate(&camera, &a, &b1, X, k / 6) -
                         coordinate(&camera, &a, &b2, X, k / 6)) /
                            scale,
                        D(rows[k / 6].h_b[k % 6]) / largest, TOL(1e-6, 1e-3));
        }
    }
}

static void test_a_point_behind_the_camera_has_no_row(void)
{
    const rigcal_camera camera = lens(0), pinhole = test_pinhole();
    const double I[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, o[3] = {0, 0, 0};
    const rigcal_transform T = test_transform(I, o);
    rc_seen seen = {.a = 0, .b = 1, .n_rows = 2, .sigma_px = 1};
    rc_row rows[2];
    rc_sight sight;

    seen.camera = &camera;
    seen.X[2] = -2;
    ASSERT_STATUS(RIGCAL_ERR_BEHIND, rc_rows_of(rows, &seen, &T, &T));
    for (int z = -1; z <= 0; z++) { /* behind, then in the plane */
        const rigcal_real ray[3] = {RC(0.5), 0, RC(z)};
        ASSERT_STATUS(RIGCAL_ERR_BEHIND, rc_sight_of(&sight, &camera, ray, 1));
        ASSERT_STATUS(RIGCAL_ERR_BEHIND, rc_sight_of(&sight, &pinhole, ray, 1));
    }
    seen.X[2] = 2;
    ASSERT_STATUS(RIGCAL_OK, rc_rows_of(rows, &seen, &T, &T));
    seen.uv[1] = RC(1e6); /* so far off that the number of deviations overflows */
    seen.sigma_px = RC(TOL(1e-305, 1e-36));
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_rows_of(rows, &seen, &T, &T));
}

/* ---- a target gets its place -----------------------------------------------------------
 * */

static void test_the_place_of_a_target_moves_as_its_camera_and_its_view_do(void)
{
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        test_rng rng = test_seed(500 + (uint64_t)trial);
        rigcal_transform camera = test_random_transform(&rng),
                         view = test_random_transform(&rng), target, other;
        rigcal_real by_camera[36], by_view[36], ignored[36];

        rc_rows_place(&target, by_camera, by_view, &camera, &view);
        const rigcal_transform inverse = test_inverse(&view),
                               expected = test_times(&inverse, &camera);
        ASSERT_TRANSFORM(&expected, &target, TOL(1e-12, 1e-5), TOL(1e-12, 1e-5));
        for (int k = 0; k < 12; k++) {
            double d[6] = {0, 0, 0, 0, 0, 0}, Rt[9], turn[9], e[6];
            const double step = TOL(1e-5, 1e-2);
            const rigcal_real *const by = k < 6 ? by_camera : by_view;
            const body from = body_of(k < 6 ? &camera : &view), at = body_of(&target);

            d[k % 6] = step;
            const body off = k < 6 ? moved(&from, d) : stepped(&from, d);
            const rigcal_transform T = test_transform(off.R, off.t);
            rc_rows_place(&other, ignored, ignored, k < 6 ? &T : &camera,
                          k < 6 ? &view : &T);
            const body to = body_of(&other);
            test_transpose(Rt, at.R);
            test_product(turn, to.R, Rt);
            const double w[3] = {turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]};
            double turned[3];
            test_apply(turned, turn, at.t, NULL);
            for (int i = 0; i < 3; i++) {
                e[i] = w[i] / 2;
                e[3 + i] = to.t[i] - turned[i];
            }
            for (int i = 0; i < 6; i++) {
                ASSERT_NEAR(e[i] / step, by[6 * i + k % 6], TOL(1e-4, 0.1));
            }
        }
    }
}

/* Each coefficient alone is enough for a lens. The noise of the ray is that of the pixel,
 * by differences. */
static void test_each_coefficient_of_a_lens_counts(void)
{
    for (int k = 0; k < 10; k++) {
        rigcal_camera camera = test_pinhole();
        rigcal_real *const numbers[] = {&camera.k1, &camera.k2, &camera.p1, &camera.p2,
                                        &camera.k3, &camera.k4, &camera.k5, &camera.k6};
        const rigcal_real ray[3] = {RC(0.5), RC(-0.25), RC(1.25)};
        double m[3], T[2][3], px[2];
        rc_sight sight;

        if (k < 8) {
            *numbers[k] = RC(0.05);
        } else if (k == 8) {
            camera.lens = RIGCAL_LENS_FISHEYE;
        }
        ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&sight, &camera, ray, RC(SIGMA)));
        test_to_double(m, sight.m, 3);
        test_project_px(px, &camera, m);
        for (int i = 0; i < 2; i++) { /* a noise of SIGMA along u, or v, and of 0 across */
            double moved_px[2], turned[3];

            test_to_double(T[i], sight.T[i], 3);
            for (int j = 0; j < 3; j++) {
                turned[j] = m[j] + 1e-3 * T[i][j];
            }
            test_project_px(moved_px, &camera, turned);
            ASSERT_NEAR(i == 0 ? 1e-3 * SIGMA : 0, moved_px[0] - px[0], 2e-6 * SIGMA);
            ASSERT_NEAR(i == 1 ? 1e-3 * SIGMA : 0, moved_px[1] - px[1], 2e-6 * SIGMA);
        }
    }
}

/* A ray more than 89.999 degrees off the axis of a pinhole has no image. */
static void test_a_ray_that_grazes_has_no_sight(void)
{
    const rigcal_camera camera = test_pinhole();
    rc_sight sight;

    for (int k = 0; k < 2; k++) {
        rigcal_real grazing[3] = {0, 0, RC(TOL(1e-9, 1e-5))}, ahead[3] = {0, 0, RC(0.01)};

        grazing[k] = ahead[k] = 1;
        ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, sight, rc_sight_of(&sight, &camera, grazing, 1));
        ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&sight, &camera, ahead, 1));
    }
}

static void test_a_ray_of_no_length_is_none(void)
{
    const rigcal_real nothing[3] = {0, 0, 0};
    rigcal_camera camera = test_pinhole();
    rc_sight sight;

    camera.k1 = RC(0.05);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_sight_of(&sight, &camera, nothing, 1));
}

/* If Brown's lens has k6 alone, the pixel hardly moves far off the axis. If it has k3
 * alone, the pixel moves so much that the square overflows. The noise of such a ray is no
 * finite number. */
static void test_a_ray_whose_noise_is_no_number_has_no_sight(void)
{
    const rigcal_real ray[3] = {1, 0, RC(TOL(1e-20, 1e-3))};
    rigcal_camera still = test_pinhole(), wild = test_pinhole();
    rc_sight sight;

    still.k6 = RC(1e9);
    wild.k3 = RC(TOL(1e9, 1e7));
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_sight_of(&sight, &still, ray, 1));
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_sight_of(&sight, &wild, ray, 1));
}

/* The point is so near to the plane of the camera that its pixel, or the pixel's
 * derivative, overflows. */
static void test_a_point_that_grazes_has_no_row(void)
{
    const double depths[2] = {TOL(1e-200, 1e-20), TOL(1e-306, 1e-37)};
    const double I[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const rigcal_camera camera = lens(0);
    rc_seen seen = {.a = 0, .b = 1, .n_rows = 2, .sigma_px = 1};
    rc_row rows[2];

    seen.camera = &camera;
    seen.X[0] = seen.X[1] = 1;
    for (int i = 0; i < 2; i++) {
        const double t[3] = {0, 0, depths[i]}, o[3] = {0, 0, 0};
        const rigcal_transform T[2] = {test_transform(I, t), test_transform(I, o)};

        ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_rows_of(rows, &seen, &T[0], &T[1]));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_match_agrees_with_differences_through_any_lens);
    RUN_TEST(test_the_residual_is_sampsons_distance_in_standard_deviations);
    RUN_TEST(test_a_noisy_match_knows_nothing_of_the_length_of_the_base);
    RUN_TEST(test_a_move_of_all_bodies_together_is_not_seen);
    RUN_TEST(test_a_match_on_the_line_through_both_centres_is_refused);
    RUN_TEST(test_a_view_agrees_with_differences_through_any_lens);
    RUN_TEST(test_a_point_behind_the_camera_has_no_row);
    RUN_TEST(test_the_place_of_a_target_moves_as_its_camera_and_its_view_do);
    RUN_TEST(test_each_coefficient_of_a_lens_counts);
    RUN_TEST(test_a_ray_that_grazes_has_no_sight);
    RUN_TEST(test_a_ray_of_no_length_is_none);
    RUN_TEST(test_a_match_is_refused_up_to_ten_deviations_from_the_line);
    RUN_TEST(test_a_match_without_noise_is_refused);
    RUN_TEST(test_a_sight_has_any_unit_of_pixels);
    RUN_TEST(test_a_ray_whose_noise_is_no_number_has_no_sight);
    RUN_TEST(test_a_point_that_grazes_has_no_row);
}
