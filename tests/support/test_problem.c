#include "test_problem.h"

#include <math.h>

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

void test_surrounded_problem(test_problem *p, test_rng *rng, int n)
{
    p->camera = test_pinhole();
    p->camera.lens = RIGCAL_LENS_FISHEYE;
    p->camera.fx = p->camera.fy = 120;
    p->scene.n = n;
    p->use_sigma = 0;
    test_random_rotation(p->scene.R, rng);
    for (int k = 0; k < 3; k++) {
        p->scene.t[k] = test_uniform(rng, -0.2, 0.2);
    }
    for (int i = 0; i < n; i++) {
        const double way = 2.4 * i, off = 0.5 + 1.4 * (i + 0.5) / n;
        const double range = test_uniform(rng, 1, 2);
        const double X_c[3] = {range * sin(off) * cos(way), range * sin(off) * sin(way),
                               range * cos(off)};
        double uv[2], from[3], back[9], X[3];
        test_project_px(uv, &p->camera, X_c);
        test_to_real(p->o[i].uv, uv, 2);
        for (int k = 0; k < 3; k++) {
            from[k] = X_c[k] - p->scene.t[k];
        }
        test_transpose(back, p->scene.R);
        test_apply(X, back, from, NULL);
        test_to_real(p->o[i].X_w, X, 3);
    }
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
