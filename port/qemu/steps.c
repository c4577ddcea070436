/* steps.c - that no rigcal_pose_step takes longer than its budget allows, counted on an
 * emulated RISC-V under -icount shift=0, where instret counts exactly.
 *
 * One evaluation is the most that a step of budget 1 takes which stays in its phase, over
 * all scenes of as many points and the same lens. A step of budget b may take b + 1 of
 * them, since it may pass from phase to phase; what rigcal_sightings_from_observations
 * takes, since one step turns all pixels into rays. Exit status 1 where one takes more.
 */
#include <stdint.h>
#include <stdio.h>

#define JOBS_ONLY_SCENES
#include "jobs.c"

enum { SCENES = 1000, GROUPS = 5 };

static const struct {
    const char *name;
    size_t n;
    kind what;
} GROUP[GROUPS] = {{"tag", 4, TAG}, {"4 points", 4, PLAIN}, {"4 points, lens", 4, LENS},
                   {"8 points, lens", 8, LENS}, {"50 points, lens", 50, LENS}};

static uint32_t instructions(void)
{
    uint32_t n;
    __asm__ volatile("csrr %0, 0xc02" : "=r"(n) : : "memory");
    return n;
}

static int32_t rays(void)
{
    static rigcal_sighting sightings[POINTS_MAX];
    const uint32_t begin = instructions();
    (void)rigcal_sightings_from_observations(sightings, NULL, &scene.camera[0],
                                             scene.seen, scene.n);
    return (int32_t)(instructions() - begin);
}

/* The most that a step takes: of all, and of those within a phase. Every third scene
 * starts warm, which a bad start would turn into a search. */
static void longest(int32_t *of_all, int32_t *within, int32_t *of_rays, int group,
                    int32_t budget)
{
    *of_all = *within = *of_rays = 0;
    for (uint64_t i = 0; i < SCENES / GROUPS; i++) {
        rigcal_pose_solver solver;
        rigcal_status status;
        make_scene(GROUP[group].n, GROUP[group].what, i);
        *of_rays = (rays() > *of_rays) ? rays() : *of_rays;
        if (i % 6 == 5) { /* a bad start */
            scene.warm.start.t[2] = -scene.warm.start.t[2];
        }
        if (rigcal_pose_begin(&solver, NULL, &scene.camera[0], scene.seen, NULL, scene.n,
                              (i % 3 == 2) ? &scene.warm : NULL) != RIGCAL_OK) {
            printf("%s, scene %d is refused\n", GROUP[group].name, (int)i);
            continue;
        }
        do {
            const int32_t phase = solver.phase;
            const uint32_t begin = instructions();
            status = rigcal_pose_step(&solver, budget);
            const int32_t taken = (int32_t)(instructions() - begin);
            *of_all = (taken > *of_all) ? taken : *of_all;
            if (solver.phase == phase) {
                *within = (taken > *within) ? taken : *within;
            }
        } while (status == RIGCAL_RUNNING);
    }
}

int main(void)
{
    static const int32_t BUDGET[3] = {1, 4, 16};
    int32_t excess = INT32_MIN;
    printf("| scene | one evaluation | rays | step of 1 | step of 4 | step of 16 |\n"
           "| --- | ---: | ---: | ---: | ---: | ---: |\n");
    for (int g = 0; g < GROUPS; g++) {
        int32_t one = 0;
        for (int b = 0; b < 3; b++) {
            int32_t all, within, of_rays;
            longest(&all, &within, &of_rays, g, BUDGET[b]);
            if (b == 0) {
                one = within;
                printf("| %s | %d | %d |", GROUP[g].name, (int)one, (int)of_rays);
            }
            const int32_t more = all - (BUDGET[b] + 1) * one - of_rays;
            excess = (more > excess) ? more : excess;
            printf(" %d |", (int)all);
        }
        printf("\n");
    }
    return excess > 0;
}
