/* steps.c - that no rigcal_pose_step takes longer than its budget allows, counted on an
 * emulated RISC-V under -icount shift=0, where instret counts exactly.
 *
 * What one evaluation costs is measured scene by scene, by itself: the most of a step of
 * two refinements, the ray of a pixel, and the proof that the lens sees a point. A step of
 * budget b may take b + 1 of them and EXTRA. Exit status 1 where one takes more.
 */
#include <stdint.h>
#include <stdio.h>

#define JOBS_ONLY_SCENES
#include "jobs.c"

#include "rc_pose.h"

enum { SCENES = 1000, GROUPS = 8 };

/* Instructions besides evaluations: what chooses the next start. */
enum { EXTRA = 4000 };

typedef struct {
    const char *name;
    size_t n;
    kind what;
    int is_weighted, is_thorough;
} group;

static const group GROUP[GROUPS] = {
    {"3 points", 3, PLAIN, 0, 0},       {"tag", 4, TAG, 0, 0},
    {"tag, thorough", 4, TAG, 0, 1},    {"4 points", 4, PLAIN, 0, 0},
    {"4 points, lens", 4, LENS, 0, 0},  {"8 points, lens", 8, LENS, 0, 0},
    {"50 points, weighted", 50, PLAIN, 1, 0}, {"50 points, lens", 50, LENS, 0, 0}};

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
    const rigcal_real origin[3] = {0, 0, 0};
    rigcal_refinement state;
    rigcal_fit fit;
    int32_t longest = 0;
    rc_fit_begin(&fit, &scene.camera[0], scene.seen, NULL, NULL, scene.n, origin);
    state.cam_from_points = *start;
    rc_refine_begin(&state);
    while (state.status == RIGCAL_RUNNING) {
        const uint32_t begin = instructions();
        rc_refine_step(&state, &fit, 100);
        longest = most(longest, (int32_t)(instructions() - begin));
    }
    return longest;
}

/* To the end from a pose 2 degrees off, and from one whose axes are exchanged besides. */
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

static int32_t one_evaluation(void)
{
    int32_t longest = refining();
    for (size_t i = 0; i < scene.n; i++) {
        longest = most(longest, seeing(i));
    }
    return longest;
}

/* The most of a group: one evaluation, begin, a step, result, and what a step took beyond
 * its evaluations. Every third scene starts warm, which a bad start turns into a search. */
typedef struct {
    int32_t one, begin, step, result, beyond;
} longest;

static void measure(longest *of, const group *g, uint64_t i, int32_t budget)
{
    static rigcal_real sigma[50];
    rigcal_pose_options options;
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_pose_solver solver;
    rigcal_status status;
    size_t n_found;
    make_scene(g->n, g->what, i);
    const int32_t one = one_evaluation();
    of->one = most(of->one, one);
    for (size_t k = 0; k < g->n; k++) {
        sigma[k] = (rigcal_real)(1 + k % 3);
    }
    options = scene.warm;
    options.thorough = g->is_thorough;
    options.use_start = i % 3 == 2;
    if (i % 6 == 5) {
        options.start.t[2] = -options.start.t[2];
    }
    uint32_t begin = instructions();
    status = rigcal_pose_begin(&solver, NULL, &scene.camera[0], scene.seen,
                               g->is_weighted ? sigma : NULL, scene.n, &options);
    of->begin = most(of->begin, (int32_t)(instructions() - begin));
    for (status = RIGCAL_RUNNING; status == RIGCAL_RUNNING;) {
        begin = instructions();
        status = rigcal_pose_step(&solver, budget);
        const int32_t taken = (int32_t)(instructions() - begin);
        of->step = most(of->step, taken);
        of->beyond = most(of->beyond, taken - (budget + 1) * one);
    }
    begin = instructions();
    status = rigcal_pose_result(poses, &n_found, RIGCAL_POSES_MAX, NULL, &solver);
    of->result = most(of->result, (int32_t)(instructions() - begin));
    if (status < 0) {
        printf("scene %d of %s: %s\n", (int)i, g->name, rigcal_status_name(status));
    }
}

int main(void)
{
    static const int32_t BUDGET[3] = {1, 4, 16};
    int32_t beyond = 0;
    printf("| scene | one evaluation | begin | step of 1 | step of 4 | step of 16 | result |"
           " beyond b + 1 |\n"
           "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (int g = 0; g < GROUPS; g++) {
        longest of = {0, 0, 0, 0, 0};
        int32_t step[3];
        for (int b = 0; b < 3; b++) {
            of.step = 0;
            for (uint64_t i = 0; i < SCENES; i++) {
                measure(&of, &GROUP[g], i, BUDGET[b]);
            }
            step[b] = of.step;
        }
        printf("| %s | %d | %d | %d | %d | %d | %d | %d |\n", GROUP[g].name, (int)of.one,
               (int)of.begin, (int)step[0], (int)step[1], (int)step[2], (int)of.result,
               (int)of.beyond);
        beyond = most(beyond, of.beyond);
    }
    return beyond > EXTRA;
}
