#include "test_bands.h"

#include <math.h>
#include <string.h>

/* ---- scenes ---------------------------------------------------------------- */

static rigcal_camera any_lens(test_rng *rng, int kind, double size)
{
    const double width = test_uniform(rng, size / 4, size);
    const double f = width * test_uniform(rng, 0.5, 1.6);
    rigcal_camera c;

    memset(&c, 0, sizeof c);
    c.width = (int32_t)width;
    c.height = (int32_t)(width * test_uniform(rng, 0.5, 1.1));
    c.fx = RC(f);
    c.fy = RC(f * test_uniform(rng, 0.95, 1.05));
    c.cx = RC(c.width * test_uniform(rng, 0.4, 0.6));
    c.cy = RC(c.height * test_uniform(rng, 0.4, 0.6));
    if (kind == TEST_BROWN || kind == TEST_RATIONAL) {
        c.k1 = RC(test_uniform(rng, -0.3, 0.15));
        c.k2 = RC(test_uniform(rng, -0.05, 0.1));
        c.p1 = RC(test_uniform(rng, -2e-3, 2e-3));
        c.p2 = RC(test_uniform(rng, -2e-3, 2e-3));
    }
    if (kind == TEST_RATIONAL) {
        c.k3 = RC(test_uniform(rng, -0.02, 0.02));
        c.k4 = RC(test_uniform(rng, 0, 0.4));
        c.k5 = RC(test_uniform(rng, 0, 0.1));
        c.k6 = RC(test_uniform(rng, 0, 0.02));
    }
    if (kind == TEST_FISHEYE) {
        c.lens = RIGCAL_LENS_FISHEYE;
        c.fx *= RC(0.6);
        c.fy *= RC(0.6);
        c.k1 = RC(test_uniform(rng, -0.05, 0.05));
        c.k2 = RC(test_uniform(rng, -0.01, 0.01));
    }
    return c;
}

/* Also a tenth of the image around it: close to a fold of the lens nothing is linear. */
static int is_all_seen(const rigcal_camera *c)
{
    for (int i = 0; i < 9; i++) {
        const double x = i % 3 * 0.6 - 0.1, y = i / 3 * 0.6 - 0.1;
        const rigcal_real uv[2] = {RC(x * c->width), RC(y * c->height)};
        rigcal_ray ray;

        if (rigcal_ray_make(&ray, c, uv) != RIGCAL_OK) {
            return 0;
        }
    }
    return 1;
}

rigcal_camera test_lens_random(test_rng *rng, int kind, double size)
{
    for (;;) {
        const rigcal_camera c = any_lens(rng, kind, size);

        if (is_all_seen(&c)) {
            return c;
        }
    }
}

static void random_covariance(rigcal_real Sigma[36], test_rng *rng)
{
    const double scale = test_uniform(rng, 2e-4, 4e-3);
    double L[6][6];

    for (int k = 0; k < 36; k++) {
        L[k / 6][k % 6] = k % 6 <= k / 6 ? scale * test_uniform(rng, -1, 1) : 0;
    }
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            double sum = 0;

            for (int k = 0; k < 6; k++) {
                sum += L[i][k] * L[j][k];
            }
            Sigma[6 * i + j] = RC(sum);
        }
    }
}

void test_bands_random(test_bands *scene, test_rng *rng, int kind, double size)
{
    rigcal_match_pair *const pair = &scene->pair;
    double axis[3], t[3], R[9];
    const int range = (int)test_uniform(rng, 0, 3);

    memset(scene, 0, sizeof *scene);
    scene->a = test_lens_random(rng, kind, size);
    scene->b = test_lens_random(rng, kind, size);
    pair->camera_a = &scene->a;
    pair->camera_b = &scene->b;
    for (int k = 0; k < 3; k++) {
        axis[k] = test_uniform(rng, -1, 1);
        t[k] = test_uniform(rng, -1, 1);
    }
    test_rotation_about(R, axis, test_uniform(rng, 0, 0.6));
    pair->b_from_a = test_transform(R, t);
    random_covariance(pair->Sigma, rng);
    pair->sigma_a = RC(test_uniform(rng, 0.1, 1));
    pair->sigma_b = RC(test_uniform(rng, 0.1, 1));
    pair->k = RC(test_uniform(rng, 2, 3.2));
    pair->near_a = RC(range > 0 ? test_uniform(rng, 0.5, 3) : 0);
    pair->far_a = RC(range > 1 ? D(pair->near_a) * test_uniform(rng, 1.5, 6) : 0);
    scene->uv_a[0] = RC(test_uniform(rng, 0, scene->a.width - 1));
    scene->uv_a[1] = RC(test_uniform(rng, 0, scene->a.height - 1));
}

void test_bands_wild(test_bands *scene, test_rng *rng, double size)
{
    test_bands_random(scene, rng, TEST_PINHOLE, size);
    scene->b.k2 = RC(exp(test_uniform(rng, log(2), log(80))));
    scene->b.k1 = RC(-sqrt(20.0 / 9 * D(scene->b.k2) * test_uniform(rng, 0.9, 0.9999)));
    scene->b.fx = RC(D(scene->b.width) * exp(test_uniform(rng, log(0.1), log(1.2))));
    scene->b.fy = RC(D(scene->b.fx) * test_uniform(rng, 0.9, 1.1));
    scene->pair.sigma_b =
        RC(D(scene->b.fx) * exp(test_uniform(rng, log(1e-3), 0)) / D(scene->pair.k));
}

void test_bands_beside(rigcal_match_pair *pair, rigcal_camera *camera, double sigma_b,
                       double k)
{
    static const double t[3] = {-1, 0, 0};

    memset(camera, 0, sizeof *camera);
    camera->width = 80;
    camera->height = 60;
    camera->fx = camera->fy = 50;
    camera->cx = 40;
    camera->cy = 30;
    memset(pair, 0, sizeof *pair);
    pair->camera_a = pair->camera_b = camera;
    pair->b_from_a = test_transform(NULL, t);
    pair->sigma_b = RC(sigma_b);
    pair->k = RC(k);
}

/* ---- the truth ------------------------------------------------------------- */

int test_ray_of(test_ray *ray, const rigcal_camera *camera, const rigcal_real uv[2])
{
    static const double UP[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double h = 1e-6;
    double e[2][3], J[2][2];
    rigcal_real m[3];

    if (rigcal_camera_ray(m, camera, uv) != RIGCAL_OK) {
        return 0;
    }
    test_to_double(ray->m, m, 3);
    test_cross(e[0], ray->m, UP[fabs(ray->m[0]) < 0.6 ? 0 : 1]);
    const double length = test_norm(e[0]);

    for (int k = 0; k < 3; k++) {
        e[0][k] /= length;
    }
    test_cross(e[1], ray->m, e[0]);
    for (int i = 0; i < 2; i++) {
        double ahead[3], back[3], to[2], from[2];

        for (int k = 0; k < 3; k++) {
            ahead[k] = ray->m[k] + h * e[i][k];
            back[k] = ray->m[k] - h * e[i][k];
        }
        test_project_px(to, camera, ahead);
        test_project_px(from, camera, back);
        J[0][i] = (to[0] - from[0]) / (2 * h);
        J[1][i] = (to[1] - from[1]) / (2 * h);
    }
    for (int k = 0; k < 3; k++) {
        const double det = J[0][0] * J[1][1] - J[0][1] * J[1][0];

        ray->D[0][k] = (e[0][k] * J[1][1] - e[1][k] * J[1][0]) / det;
        ray->D[1][k] = (e[1][k] * J[0][0] - e[0][k] * J[0][1]) / det;
    }
    return 1;
}

static void look_at_depth(test_band_truth *truth, const test_bands *scene,
                          const double q[3], const double t[3], const double m[3])
{
    const double along = test_dot(q, t), k = D(scene->pair.k);
    double towards[3], nearest, farthest, across;

    for (int i = 0; i < 3; i++) {
        towards[i] = t[i] - along * q[i];
    }
    across = test_norm(towards);
    const double x = test_dot(m, q) * across, y = test_dot(m, towards) / across;
    /* On the line the point depth q + t has the direction x q + y towards. */
    truth->depth_a = x / y - along;
    truth->ahead = fmin(y, x - along * y);
    nearest = x - (D(scene->pair.near_a) + along) * y;
    farthest = D(scene->pair.far_a) > 0 ? (D(scene->pair.far_a) + along) * y - x : across;
    truth->is_inside = truth->chi2 <= k * k && y > 0 && nearest >= 0 && farthest >= 0;
    truth->margin = fmin(fabs(truth->chi2 / (k * k) - 1),
                         fmin(fabs(y), fmin(fabs(nearest), fabs(farthest)) / across));
}

void test_band_look(test_band_truth *truth, const test_bands *scene, const test_ray *a,
                    const test_ray *b)
{
    const rigcal_match_pair *const pair = &scene->pair;
    const double sigma_a = D(pair->sigma_a), sigma_b = D(pair->sigma_b);
    double R[9], t[3], q[3], line[3], back[3], c[6], by_b = 0;

    test_transform_parts(R, t, &pair->b_from_a);
    test_apply(q, R, a->m, NULL);
    test_cross(line, t, q);
    test_cross(back, b->m, t);
    test_cross(&c[0], q, back);
    test_cross(&c[3], q, b->m);
    truth->s = test_dot(b->m, line);
    truth->variance = 0;
    for (int i = 0; i < 2; i++) {
        double turned[3];
        const double of_b = test_dot(line, b->D[i]);

        test_apply(turned, R, a->D[i], NULL);
        const double of_a = test_dot(back, turned);

        by_b += of_b * of_b;
        truth->variance += sigma_a * sigma_a * of_a * of_a;
    }
    truth->variance += sigma_b * sigma_b * by_b;
    for (int k = 0; k < 36; k++) {
        truth->variance += c[k / 6] * D(pair->Sigma[k]) * c[k % 6];
    }
    truth->slope = sqrt(by_b);
    truth->chi2 = truth->s * truth->s / truth->variance;
    look_at_depth(truth, scene, q, t, b->m);
}
