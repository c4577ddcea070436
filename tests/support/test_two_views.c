#include "test_two_views.h"

#include <math.h>

rigcal_transform test_beside(test_rng *rng)
{
    double ypr[3], t[3];

    for (int k = 0; k < 3; k++) {
        ypr[k] = test_uniform(rng, -0.2, 0.2);
        t[k] = test_uniform(rng, -0.3, 0.3);
    }
    t[test_next(rng) % 2] += test_next(rng) % 2 ? 1.0 : -1.0;
    return test_from_ypr(ypr, t);
}

void test_ray_to(rigcal_real ray[3], const double X[3])
{
    ray[0] = RC(X[0] / X[2]);
    ray[1] = RC(X[1] / X[2]);
    ray[2] = 1;
}

void test_point_ahead(double X[3], test_rng *rng)
{
    X[2] = test_uniform(rng, 3, 6);
    X[0] = test_uniform(rng, -0.3, 0.3) * X[2];
    X[1] = test_uniform(rng, -0.3, 0.3) * X[2];
}

void test_wild_views(test_views *v, test_rng *rng)
{
    const double t[3] = {0, 0, 5};

    v->n = 2 + (int)(test_next(rng) % 2);
    for (int i = 0; i < v->n; i++) {
        /* One after the other: a compiler may evaluate arguments in any order. */
        const double c = test_uniform(rng, -0.3, 0.3);
        const double b = test_uniform(rng, -0.6, 0.6);
        double R[9];

        test_rotation(R, test_uniform(rng, -3, 3), b, c);
        v->cams_from_world[i] = test_transform(R, t);
        v->cameras[i] = test_pinhole();
        v->uv[2 * i] = RC(320 + 1000 * test_normal(rng));
        v->uv[2 * i + 1] = RC(240 + 1000 * test_normal(rng));
    }
}

void test_grazing_views(test_views *v, double aside)
{
    static const double R[3][9] = {{0, 1, 0, 0, 0, 1, 1, 0, 0},
                                   {-1, 0, 0, 0, 0, 1, 0, 1, 0},
                                   {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const double tiny = TOL(1e-160, 1e-25);

    v->n = 3;
    for (int i = 0; i < 3; i++) {
        const double t[3] = {i == 2 ? aside : 0, i == 2 ? aside : 0, i == 2 ? 0 : 1};

        v->cams_from_world[i] = test_transform(R[i], t);
        v->cameras[i] = test_pinhole();
        v->cameras[i].cx = v->cameras[i].cy = 0;
        v->uv[2 * i] = 0;
        v->uv[2 * i + 1] = i == 2 ? 0 : v->cameras[i].fy * RC(tiny);
    }
}

double test_views_sum(const test_views *v, const double X[3])
{
    double sum = 0;

    for (int i = 0; i < v->n; i++) {
        double X_c[3], uv[2];

        test_move_point(X_c, &v->cams_from_world[i], X);
        if (!(X_c[2] > 0)) {
            return test_infinity();
        }
        test_project_px(uv, &v->cameras[i], X_c);
        sum += pow(uv[0] - D(v->uv[2 * i]), 2) + pow(uv[1] - D(v->uv[2 * i + 1]), 2);
    }
    return sum;
}
