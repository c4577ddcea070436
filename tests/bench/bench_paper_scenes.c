/* bench_paper_scenes: whether the solver that needs no guess is right in the
 * scenes of examples/paper wherever it can be.
 *
 *   bench_paper_scenes [PLACEMENTS]    of each depth and resolution: 1000
 *
 * Judged by independent fits from the truth, from its mirror image and from
 * the solver's own pose: an image is one to be right in when the least of their
 * minima is a correct pose. Ends with status 1 when the solver is not. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_minima.h"
#include "solve.h"

/* Unity needs these: the scenes of the tests use its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

typedef struct {
    int images, fair, wrong, not_best;
} counts;

static void scene_of(bench_scene *s, const paper_images *images, const paper_scene *scene,
                     int c)
{
    memset(s, 0, sizeof *s);
    s->camera = images->camera;
    s->n = PAPER_POINTS;
    memcpy(s->seen, images->seen[c], sizeof images->seen[c]);
    test_transform_parts(s->R, s->t, &scene->cam_from_target[c]);
}

/* Digital images: counts whether the best minimum is the right pose, and whether it was
 * found. */
static void judge(counts *sum, const paper_attempt *a, const paper_images *images,
                  const paper_scene *scene, int c)
{
    static bench_scene s;
    static bench_minima m;
    double R[9], t[3];
    int best, own = -1;

    scene_of(&s, images, scene, c);
    bench_minima_begin(&m, &s);
    if (a->has_pose) {
        test_transform_parts(R, t, &a->pose);
        own = bench_minima_add(&m, R, t);
    }
    best = bench_minima_ranked(&m, 0);
    sum->not_best += !bench_is_best(&m, own, BENCH_SUM_TOL);
    if (best >= 0 &&
        test_angle_between(m.list[best].R, s.R) <= PAPER_RIGHT_DEGREES * PAPER_DEGREE) {
        sum->fair++;
        sum->wrong += a->outcome != PAPER_CORRECT;
    }
}

static void see(counts *sum, const paper_scene *scene, int width, int digital)
{
    paper_images images;

    paper_look(&images, scene, width, digital);
    for (int c = 0; c < PAPER_CAMERAS; c++) {
        paper_attempt a;

        paper_solve_no_guess(&a, &images, scene, c);
        sum->images++;
        if (digital) {
            judge(sum, &a, &images, scene, c);
        } else { /* the truth fits exactly, so it is the best */
            sum->fair++;
            sum->wrong += a.outcome != PAPER_CORRECT;
        }
    }
}

static void print(const char *what, const counts *sum)
{
    printf("%-28s %6d images, best minimum right in %d, solver wrong in %d of "
           "these; another minimum is better: %d\n",
           what, sum->images, sum->fair, sum->wrong, sum->not_best);
}

int main(int argc, char *argv[])
{
    const int placements = argc > 1 ? atoi(argv[1]) : (int)PAPER_PLACEMENTS;
    counts perfect = {0, 0, 0, 0}, one = perfect, many = perfect;
    paper_scene scene;

    for (int depth = 20; depth <= 320; depth += 20) {
        paper_scene_documented(&scene, depth);
        see(&perfect, &scene, (int)PAPER_WIDTH, PAPER_PERFECT);
    }
    for (int k = 0; k < placements; k++) { /* figure 5 */
        paper_scene_random(&scene, k, PAPER_DOCUMENTED_CM);
        see(&perfect, &scene, (int)PAPER_WIDTH, PAPER_PERFECT);
    }
    for (int d = 0; d < PAPER_DEPTHS; d++) {
        for (int w = 0; w < PAPER_WIDTHS; w++) {
            paper_scene_documented(&scene, paper_depths_cm[d]);
            see(&one, &scene, paper_widths[w], PAPER_DIGITAL);
            for (int k = 0; k < placements; k++) {
                paper_scene_random(&scene, k, paper_depths_cm[d]);
                see(&many, &scene, paper_widths[w], PAPER_DIGITAL);
            }
        }
    }
    print("perfect images", &perfect);
    print("the documented scene, digital", &one);
    print("random placements, digital", &many);
    return perfect.wrong + one.wrong + many.wrong != 0;
}
