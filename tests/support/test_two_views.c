#include "test_two_views.h"

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
