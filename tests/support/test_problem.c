#include "test_problem.h"

const rigcal_real *test_sigma_of(const test_problem *p)
{
    return p->use_sigma ? p->sigma : NULL;
}

test_data test_data_of(const test_problem *p)
{
    const test_data data = {&p->camera, p->o, test_sigma_of(p), p->scene.n};

    return data;
}

void test_observe(test_problem *p)
{
    p->use_sigma = 0;
    test_observations(p->o, &p->scene, &p->camera);
}

void test_random_problem(test_problem *p, test_rng *rng, int n, test_shape shape)
{
    p->camera = test_pinhole();
    test_scene_random(&p->scene, rng, n, shape);
    test_observe(p);
}

void test_add_noise(test_problem *p, test_rng *rng, double sigma_px)
{
    for (int i = 0; i < p->scene.n; i++) {
        const double s = p->use_sigma ? D(p->sigma[i]) : 1;

        for (int k = 0; k < 2; k++) {
            p->o[i].uv[k] = RC(D(p->o[i].uv[k]) + s * sigma_px * test_normal(rng));
        }
    }
}

rigcal_pose_options test_options(double sigma_px)
{
    rigcal_pose_options options;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
    options.sigma_px = RC(sigma_px);
    return options;
}

rigcal_status test_solve_pose(test_problem *p, const rigcal_pose_options *options)
{
    int32_t at_fault = -2;

    p->n_found = 0;
    p->status = rigcal_pose_solve(p->poses, RIGCAL_POSES_MAX, &p->n_found, &at_fault,
                                  &VIEW_OF(p), options);
    TEST_ASSERT_TRUE(at_fault >= -1 && at_fault < p->scene.n); /* it is always written */
    return p->status;
}
