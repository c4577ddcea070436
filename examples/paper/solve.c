#include "solve.h"

#include <math.h>
#include <string.h>

enum { PAIRS = RIGCAL_PAIRS_FOR(PAPER_POINTS) };

double paper_length(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

double paper_degrees(const rigcal_transform *a, const rigcal_transform *b)
{
    double angle;

    paper_expect(rigcal_rotation_angle(&angle, a->R, b->R) == RIGCAL_OK,
                 "two rotations have no angle");
    return angle / PAPER_DEGREE;
}

void paper_true_angles(double ypr[3], const paper_scene *scene, int c)
{
    paper_expect(rigcal_yaw_pitch_roll_from_rotation(ypr, scene->cam_from_target[c].R) ==
                     RIGCAL_OK,
                 "a rotation has no angles");
}

/* The rms distance of the first n points from their images, in focal lengths. */
static double miss_of(const rigcal_transform *pose, const paper_images *images, int c,
                      int n)
{
    double sum = 0;

    for (int i = 0; i < n; i++) {
        const rigcal_bearing *const s = &images->bearings[c][i];
        double X_c[3];

        paper_in_camera(X_c, pose, s->X_w);
        if (!(X_c[2] > 0)) {
            return HUGE_VAL;
        }
        for (int k = 0; k < 2; k++) {
            const double off = X_c[k] / X_c[2] - s->ray[k] / s->ray[2];

            sum += off * off / n;
        }
    }
    return sqrt(sum);
}

/* Decides whether the attempt has a solution, and whether it is correct. */
static void judge(paper_attempt *a, const paper_images *images, const paper_scene *scene,
                  int c, int n)
{
    const double most =
        images->digital ? PAPER_MATCH_PX / images->camera.fx : PAPER_MATCH_EXACT;
    const double right = images->digital ? PAPER_RIGHT_DEGREES : PAPER_RIGHT_EXACT;

    a->degrees = paper_degrees(&a->pose, &scene->cam_from_target[c]);
    if (!(miss_of(&a->pose, images, c, n) <= most)) {
        return;
    }
    a->outcome = a->degrees <= right ? PAPER_CORRECT : PAPER_FALSE;
}

paper_procedure paper_published(int n)
{
    const paper_procedure p = {n, 2, RIGCAL_YAW, 2, {0, 1}, 1, {0, 0, 0}};

    return p;
}

void paper_solve(paper_attempt *attempt, const paper_procedure *procedure,
                 const paper_images *images, const paper_scene *scene, int c)
{
    const rigcal_bearing *const seen = images->bearings[c];
    rigcal_pair chosen[PAIRS], pairs[PAIRS];
    rigcal_paper_options options;
    rigcal_paper_solver solver;
    rigcal_paper_pose pose;
    rigcal_status status;
    size_t n_pairs, used = 2;

    memset(attempt, 0, sizeof *attempt);
    attempt->degrees = HUGE_VAL;
    if (rigcal_pairs_choose(chosen, PAIRS, &n_pairs, seen, (size_t)procedure->n) !=
            RIGCAL_OK ||
        procedure->first[0] >= (int)n_pairs || procedure->first[1] >= (int)n_pairs) {
        return; /* two points have one pixel, or all pixels are on a line */
    }
    pairs[0] = chosen[procedure->first[0]];
    pairs[1] = chosen[procedure->first[1]];
    for (int i = 0; i < (int)n_pairs; i++) {
        if (i != procedure->first[0] && i != procedure->first[1]) {
            pairs[used++] = chosen[i];
        }
    }
    (void)rigcal_paper_defaults(&options);
    options.angles = procedure->angles;
    options.eliminated = procedure->eliminated;
    options.pairs_used = procedure->pairs_used;
    options.use_guess = procedure->use_guess;
    memcpy(options.guess_ypr, procedure->guess, sizeof options.guess_ypr);
    paper_expect(rigcal_paper_begin(&solver, seen, (size_t)procedure->n, pairs, n_pairs,
                                    &options) == RIGCAL_OK,
                 "the published procedure refuses a scene");
    while (rigcal_paper_step(&solver, INT32_MAX) == RIGCAL_RUNNING) {
    }
    attempt->evals = solver.evals; /* also if the search fails */
    status = rigcal_paper_result(&pose, &solver);
    if (status < 0) {
        attempt->behind = status == RIGCAL_ERR_BEHIND;
        return;
    }
    attempt->has_pose = 1;
    attempt->pose = pose.cam_from_world;
    attempt->residual = pose.residual;
    attempt->condition = pose.condition;
    judge(attempt, images, scene, c, procedure->n);
}

/* The published objective at a pose that another method found. */
static double residual_at(const rigcal_transform *pose, const rigcal_bearing seen[])
{
    rigcal_pair pairs[PAIRS];
    rigcal_elimination at;
    double ypr[3];
    size_t n_pairs;

    if (rigcal_pairs_choose(pairs, PAIRS, &n_pairs, seen, PAPER_POINTS) < 0 ||
        rigcal_yaw_pitch_roll_from_rotation(ypr, pose->R) < 0 ||
        rigcal_pairs_eliminate(&at, pairs, n_pairs, 2, RIGCAL_YAW, ypr + 1) < 0) {
        return HUGE_VAL;
    }
    return at.residual;
}

/* The view of the first n points by camera c. */
static rigcal_view first_points(const paper_images *images, int c, size_t n)
{
    const rigcal_view view = {&images->camera, images->seen[c], NULL, n};

    return view;
}

void paper_solve_no_guess(paper_attempt *attempt, const paper_images *images,
                          const paper_scene *scene, int c)
{
    const rigcal_view view = first_points(images, c, PAPER_POINTS);
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;

    memset(attempt, 0, sizeof *attempt);
    attempt->degrees = HUGE_VAL;
    if (rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &view, NULL) < 0) {
        return;
    }
    attempt->has_pose = 1;
    attempt->pose = poses[0].cam_from_world;
    attempt->residual = residual_at(&attempt->pose, images->bearings[c]);
    judge(attempt, images, scene, c, PAPER_POINTS);
}

int paper_solve_three(rigcal_transform poses[RIGCAL_POSES_MAX], int *right,
                      const paper_images *images, const paper_scene *scene, int c)
{
    const rigcal_view view = first_points(images, c, 3);
    rigcal_pose found[RIGCAL_POSES_MAX];
    rigcal_pose_options options;
    size_t n_found;

    *right = -1;
    (void)rigcal_pose_defaults(&options);
    if (images->digital) { /* two exact poses may have merged into one that is not exact */
        options.sigma_px = PAPER_SIGMA_PX;
    }
    if (rigcal_pose_solve(found, RIGCAL_POSES_MAX, &n_found, NULL, &view, &options) < 0) {
        return 0;
    }
    for (int i = 0; i < (int)n_found; i++) {
        paper_attempt a = {0};

        poses[i] = a.pose = found[i].cam_from_world;
        judge(&a, images, scene, c, 3);
        *right = a.outcome == PAPER_CORRECT ? i : *right;
    }
    return (int)n_found;
}

int paper_covariance(double Sigma[36], const rigcal_transform *pose,
                     const paper_images *images, int c)
{
    const rigcal_view view = first_points(images, c, PAPER_POINTS);
    rigcal_pose_uncertainty u;

    if (rigcal_pose_covariance(&u, &view, pose, PAPER_SIGMA_PX) != RIGCAL_OK) {
        return 0;
    }
    memcpy(Sigma, u.Sigma, sizeof u.Sigma);
    return 1;
}

int paper_draw(double d[6], const double Sigma[36], paper_rng *rng)
{
    double L[6][6] = {{0}}, z[6];

    for (int i = 0; i < 6; i++) {
        z[i] = paper_normal(rng);
        d[i] = 0;
        for (int j = 0; j <= i; j++) {
            double sum = Sigma[6 * i + j];

            for (int k = 0; k < j; k++) {
                sum -= L[i][k] * L[j][k];
            }
            if (i == j && !(sum > 0)) {
                return 0;
            }
            L[i][j] = i == j ? sqrt(sum) : sum / L[j][j];
        }
        for (int j = 0; j <= i; j++) {
            d[i] += L[i][j] * z[j];
        }
    }
    return 1;
}

void paper_move(rigcal_transform *moved, const rigcal_transform *pose, const double d[6])
{
    rigcal_transform by = {{0}, {0, 0, 0}};

    paper_expect(rigcal_rotation_from_vector(by.R, d) == RIGCAL_OK &&
                     rigcal_transform_compose(moved, &by, pose) == RIGCAL_OK,
                 "a pose cannot be moved");
    for (int k = 0; k < 3; k++) {
        moved->t[k] = pose->t[k] + d[3 + k];
    }
}
