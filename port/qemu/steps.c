/* steps.c - that no step of a solver takes longer than its budget allows, counted on an
 * emulated RISC-V under -icount shift=0, where instret counts exactly.
 *
 * What one evaluation costs is measured scene by scene, by itself: the most of a step of
 * two refinements, the ray of a pixel, and the proof that the lens sees a point; of the
 * published search, of its objective over a grid; of a rig, of a view's equations by camera
 * and placement, from its points or, for the join, from its own pose. A step of budget b
 * may take b + 1 of them and EXTRA. Exit status 1 where one takes more. With
 * -DSTEPS_ONE_IN=n only every nth scene is measured.
 */
#include <stdint.h>
#include <stdio.h>

#define JOBS_ONLY_SCENES
#include "jobs.c"

#include "rc_adjust.h"
#include "rc_elimination.h"
#include "rc_pose.h"

#ifndef STEPS_ONE_IN
#define STEPS_ONE_IN 1
#endif

/* Fewer scenes for the published search, which evaluates some eighty times as often, and
 * for a rig, which has 24 views. */
enum { SCENES = 1000, SCENES_PUBLISHED = 100, SCENES_RIG = 20, GROUPS = 15 };

/* Instructions besides evaluations: to find all poses of three points, or the pose where a
 * published search ends. */
enum { EXTRA = 4000 };

/* Distance of one point of a robust scene from where it should be. */
#define WRONG_PX 60

typedef enum { SOLVE_POSE, WEIGHTED, ROBUST, PUBLISHED, RIG, JOIN } task;

typedef struct {
    const char *name;
    size_t n;
    kind what;
    task to_do;
    int has_fisheye;
} group;

static const group GROUP[GROUPS] = {{"3 points", 3, PLAIN, SOLVE_POSE, 0},
                                    {"3 points, fisheye", 3, PLAIN, SOLVE_POSE, 1},
                                    {"tag", 4, TAG, SOLVE_POSE, 0},
                                    {"4 points", 4, PLAIN, SOLVE_POSE, 0},
                                    {"4 points, lens", 4, LENS, SOLVE_POSE, 0},
                                    {"8 points, lens", 8, LENS, SOLVE_POSE, 0},
                                    {"8 points, fisheye", 8, PLAIN, SOLVE_POSE, 1},
                                    {"50 points, weighted", 50, PLAIN, WEIGHTED, 0},
                                    {"50 points, lens", 50, LENS, SOLVE_POSE, 0},
                                    {"robust, 8 points", 8, PLAIN, ROBUST, 0},
                                    {"robust, 20 points, lens", 20, LENS, ROBUST, 0},
                                    {"published, 4 points", 4, PLAIN, PUBLISHED, 0},
                                    {"rig, join", 4, TAG, JOIN, 0},
                                    {"rig, tags", 4, TAG, RIG, 0},
                                    {"rig, 12 points, lens", 12, LENS, RIG, 0}};

static rigcal_bearing bearings[4];
static rigcal_pair pairs[RIGCAL_PAIRS_FOR(4)];
static size_t n_pairs;

static uint32_t instructions(void)
{
    uint32_t n;
    __asm__ volatile("csrr %0, 0xc02" : "=r"(n) : : "memory");
    return n;
}

static int32_t most(int32_t a, int32_t b)
{
    return (a > b) ? a : b;
}

static int32_t refining_from(const rigcal_transform *start)
{
    const rigcal_view view = view_of(NULL);
    rigcal_refinement state;
    rigcal_points points;
    rigcal_real uv_middle[2];
    int32_t longest = 0, at;
    rc_points_of(&points, &view, NULL);
    (void)rc_points_survey(&points, uv_middle, &at);
    state.cam_from_points = *start;
    rc_transform_point(state.cam_from_points.t, start, points.origin);
    rc_refine_begin(&state, 0);
    while (state.search.status == RIGCAL_RUNNING) {
        const uint32_t begin = instructions();
        rc_refine_step(&state, &points, 100);
        longest = most(longest, (int32_t)(instructions() - begin));
    }
    return longest;
}

/* Refines to the end from a pose 2 degrees off, and from one whose axes are exchanged as
 * well. */
static int32_t refining(void)
{
    const rigcal_transform *const warm = &scene.warm.start;
    rigcal_transform other = *warm;
    for (int i = 0; i < 9; i++) {
        other.R[i] = warm->R[i / 3 * 3 + (i + 1) % 3];
    }
    return most(refining_from(warm), refining_from(&other));
}

static int32_t seeing(size_t i)
{
    rigcal_real ray[3], uv[2];
    uint32_t begin = instructions();
    (void)rc_pixel_to_ray(ray, &scene.camera[0], scene.seen[i].uv);
    const int32_t taken = (int32_t)(instructions() - begin);
    begin = instructions();
    (void)rc_project_usable(uv, &scene.camera[0], ray);
    return most(taken, (int32_t)(instructions() - begin));
}

static int32_t one_solving(void)
{
    int32_t longest = refining();
    for (size_t i = 0; i < scene.n; i++) {
        longest = most(longest, seeing(i));
    }
    return longest;
}

static int32_t one_published(void)
{
    enum { NODES = 6 };
    rigcal_elimination at;
    int32_t longest = 0;
    for (int i = 0; i < NODES * NODES; i++) {
        const rigcal_real angles[2] = {(rigcal_real)(i / NODES) - RC(2.5),
                                       (rigcal_real)(i % NODES) - RC(2.5)};
        const uint32_t from = instructions();
        (void)rc_eliminate(&at, pairs, n_pairs, 0, i % 3, angles);
        longest = most(longest, (int32_t)(instructions() - from));
    }
    return longest;
}

/* The cost of the equations of each view, from its points or from its own pose, and of
 * turning them into those of camera and placement. */
static int32_t one_of_rig(int is_join)
{
    int32_t longest = 0;
    for (int v = 0; v < RIG_VIEWS; v++) {
        const rigcal_rig_view *const view = &rig.views[v];
        rigcal_real sum, d[6], g[6], H[21], W[36];
        rigcal_real g_placement[6] = {0}, H_placement[21] = {0};
        rc_chain chain;
        const uint32_t from = instructions();
        rc_chain_of(&chain, &rig.poses[view->camera],
                    &rig.poses[RIG_CAMERAS + view->placement]);
        if (is_join) {
            memcpy(H, rig.own[v].information, sizeof H);
            rc_deviation(d, &rig.own[v].cam_from_target, &chain.cam_from_target);
            rc_sym6_mul(g, H, d);
        } else {
            (void)rc_rig_equations(&sum, g, H, view, &chain.cam_from_target);
        }
        rc_chain_add_placement(g_placement, H_placement, &chain, g, H);
        rc_chain_camera(g, H, W, &chain);
        longest = most(longest, (int32_t)(instructions() - from));
    }
    return longest;
}

enum { BUDGETS = 3 };

static const int32_t BUDGET[BUDGETS] = {1, 4, 16};

/* The most of a group: one evaluation, begin, a step of each budget, result, and what a
 * step took beyond its evaluations. Every third scene starts warm, which a bad start turns
 * into a search. */
typedef struct {
    int32_t one, begin, step[BUDGETS], result, beyond;
} longest;

typedef union {
    rigcal_pose_solver pose;
    rigcal_robust_solver robust;
    rigcal_paper_solver paper;
    rigcal_rig_solver rig;
} solver;

static rigcal_status begin(solver *s, const group *g, uint64_t i)
{
    static rigcal_real sigma[50];
    static uint8_t inliers[50];
    rigcal_pose_options options = scene.warm;
    rigcal_robust_options robust;
    if (g->to_do == JOIN) {
        return rigcal_rig_join_begin(&s->rig, &rig.rig);
    }
    if (g->to_do == RIG) {
        memcpy(rig.poses, rig.joined, sizeof rig.poses);
        return rigcal_rig_begin(&s->rig, &rig.rig);
    }
    if (g->to_do == ROBUST) {
        (void)rigcal_robust_defaults(&robust);
        robust.samples = 20;
        const rigcal_view view = view_of(NULL);
        return rigcal_robust_begin(&s->robust, inliers, NULL, &view, &robust);
    }
    if (g->to_do == PUBLISHED) {
        return rigcal_paper_begin(&s->paper, bearings, scene.n, pairs, n_pairs, NULL);
    }
    for (size_t k = 0; k < g->n; k++) {
        sigma[k] = (rigcal_real)(1 + k % 3);
    }
    options.use_start = i % 3 == 2;
    if (i % 6 == 5) {
        options.start.t[2] = -options.start.t[2];
    }
    const rigcal_view view = view_of((g->to_do == WEIGHTED) ? sigma : NULL);
    return rigcal_pose_begin(&s->pose, NULL, &view, &options);
}

static rigcal_status step(solver *s, const group *g, int32_t budget)
{
    return (g->to_do == ROBUST)      ? rigcal_robust_step(&s->robust, budget)
           : (g->to_do == PUBLISHED) ? rigcal_paper_step(&s->paper, budget)
           : (g->to_do == RIG)       ? rigcal_rig_step(&s->rig, budget)
           : (g->to_do == JOIN)      ? rigcal_rig_join_step(&s->rig, budget)
                                     : rigcal_pose_step(&s->pose, budget);
}

static rigcal_status result(const solver *s, const group *g)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_paper_pose pose;
    rigcal_rig_fit fit;
    size_t n_found, n_inliers;
    return (g->to_do == ROBUST) ? rigcal_robust_result(poses, RIGCAL_POSES_MAX, &n_found,
                                                       &n_inliers, &s->robust)
           : (g->to_do == PUBLISHED) ? rigcal_paper_result(&pose, &s->paper)
           : (g->to_do == RIG || g->to_do == JOIN)
               ? rigcal_rig_result(&fit, NULL, &s->rig)
               : rigcal_pose_result(poses, RIGCAL_POSES_MAX, &n_found, NULL, &s->pose);
}

/* The same rays as with the pinhole. */
static void see_by_fisheye(void)
{
    const rigcal_camera pinhole = scene.camera[0];
    rigcal_camera *const fisheye = &scene.camera[0];
    fisheye->lens = RIGCAL_LENS_FISHEYE;
    fisheye->k1 = RC(-0.03);
    fisheye->k2 = RC(0.02);
    fisheye->k3 = RC(-0.01);
    fisheye->k4 = RC(0.001);
    for (size_t i = 0; i < scene.n; i++) {
        rigcal_real ray[3];
        (void)rigcal_camera_ray(ray, &pinhole, scene.seen[i].uv);
        (void)rigcal_camera_project(scene.seen[i].uv, fisheye, ray);
    }
}

/* Makes the scene, and measures what one evaluation costs there. */
static int32_t make(const group *g, uint64_t i)
{
    if (g->to_do == RIG || g->to_do == JOIN) {
        make_rig(g->n, g->what, i);
        return one_of_rig(g->to_do == JOIN);
    }
    make_scene(g->n, g->what, i);
    if (g->has_fisheye) {
        see_by_fisheye();
    }
    if (g->to_do == ROBUST) {
        scene.seen[i % g->n].uv[0] += WRONG_PX;
    }
    if (g->to_do != PUBLISHED) {
        return one_solving();
    }
    const rigcal_view view = view_of(NULL);
    (void)rigcal_bearings_of_view(bearings, NULL, &view);
    (void)rigcal_pairs_choose(pairs, RIGCAL_PAIRS_FOR(4), &n_pairs, bearings, g->n);
    return one_published();
}

/* Runs from begin to result in steps of BUDGET[b]. */
static void measure(longest *of, const group *g, uint64_t i, int b, int32_t one)
{
    static solver s;
    uint32_t from = instructions();
    rigcal_status status = begin(&s, g, i);
    of->begin = most(of->begin, (int32_t)(instructions() - from));
    status = (status == RIGCAL_OK) ? RIGCAL_RUNNING : status;
    while (status == RIGCAL_RUNNING) {
        from = instructions();
        status = step(&s, g, BUDGET[b]);
        const int32_t taken = (int32_t)(instructions() - from);
        of->step[b] = most(of->step[b], taken);
        of->beyond = most(of->beyond, taken - (BUDGET[b] + 1) * one);
    }
    from = instructions();
    status = (status == RIGCAL_OK) ? result(&s, g) : status;
    of->result = most(of->result, (int32_t)(instructions() - from));
    if (status < 0) {
        printf("scene %d of %s: %s\n", (int)i, g->name, rigcal_status_name(status));
    }
}

int main(void)
{
    int32_t beyond = 0;
    printf(
        "| scene | one evaluation | begin | step of 1 | step of 4 | step of 16 | result |"
        " beyond b + 1 |\n"
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (const group *g = GROUP; g < GROUP + GROUPS; g++) {
        const int is_rig = g->to_do == RIG || g->to_do == JOIN;
        const uint64_t scenes = (g->to_do == PUBLISHED) ? SCENES_PUBLISHED
                                : is_rig                ? SCENES_RIG
                                                        : SCENES;
        longest of = {0};
        for (uint64_t i = 0; i < scenes; i += STEPS_ONE_IN) {
            const int32_t one = make(g, i);
            of.one = most(of.one, one);
            for (int b = 0; b < BUDGETS; b++) {
                measure(&of, g, i, b, one);
            }
        }
        printf("| %s | %d | %d | %d | %d | %d | %d | %d |\n", g->name, (int)of.one,
               (int)of.begin, (int)of.step[0], (int)of.step[1], (int)of.step[2],
               (int)of.result, (int)of.beyond);
        beyond = most(beyond, of.beyond);
    }
    return beyond > EXTRA;
}
