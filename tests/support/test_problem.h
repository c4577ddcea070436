/* test_problem.h - a scene, its observations, and what the pose solver made of them. */
#ifndef TEST_PROBLEM_H
#define TEST_PROBLEM_H

#include "test_fit.h"

typedef struct {
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation o[TEST_SCENE_MAX];
    rigcal_real sigma[TEST_SCENE_MAX];
    int use_sigma;
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;
    rigcal_status status;
} test_problem;

/* The view of a problem, as an argument: &VIEW_OF(&p). */
#define VIEW_OF(p) VIEW(&(p)->camera, (p)->o, test_sigma_of(p), (p)->scene.n)

/* NULL if the problem has none. */
const rigcal_real *test_sigma_of(const test_problem *p);
test_data test_data_of(const test_problem *p);

/* The exact image of the scene in the camera; without sigma. */
void test_observe(test_problem *p);

/* A random scene and its exact image in a pinhole. */
void test_random_problem(test_problem *p, test_rng *rng, int n, test_shape shape);

/* A fisheye in the middle of its points, which are in all directions up to 110 degrees off
 * the axis, and their exact image. Of the scene, R, t and n are set. */
void test_surrounded_problem(test_problem *p, test_rng *rng, int n);

/* Adds normal noise of sigma_px, times the sigma of each point. */
void test_add_noise(test_problem *p, test_rng *rng, double sigma_px);

/* The default options with this noise; 0: it is not stated. */
rigcal_pose_options test_options(double sigma_px);

rigcal_status test_solve_pose(test_problem *p, const rigcal_pose_options *options);

#endif /* TEST_PROBLEM_H */
