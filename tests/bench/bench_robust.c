/* The pose from observations some of which are wrong, on random scenes: how often it
 * is right, and how often all wrong is believed. Markdown tables of DESIGN.md.
 *
 *   bench_robust wrong [COUNT]    three in ten wrong (default 10000 scenes a line)
 *   bench_robust one [COUNT]      one wrong of 5, 6, 8
 *   bench_robust all [COUNT]      all wrong */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_scenes.h"
#include "bench_tally.h"

void setUp(void)
{
}

void tearDown(void)
{
}

enum { N_MOST = TEST_SCENE_MAX };
enum { NEAR_THE_TARGET, IN_THE_IMAGE, SWAPPED, WAYS };
static const char *const WAY[WAYS] = {"near the target", "in the image", "swapped"};

/* Targets 3 to 10 sizes away, noise of half a pixel. */
static const bench_view NEAR = {3, 10, 0.5};

typedef struct {
    bench_scene scene;
    uint8_t right[N_MOST];
    rigcal_observation rest[N_MOST]; /* only the right observations */
    size_t n_rest;
} spoilt;

static void region(double low[2], double high[2], const bench_scene *s, int way)
{
    for (int k = 0; k < 2; k++) {
        low[k] = way == IN_THE_IMAGE ? 0 : 1e9;
        high[k] = way != IN_THE_IMAGE ? -1e9 : k == 0 ? s->camera.width : s->camera.height;
        for (int i = 0; i < s->n && way != IN_THE_IMAGE; i++) {
            low[k] = fmin(low[k], D(s->seen[i].uv[k]));
            high[k] = fmax(high[k], D(s->seen[i].uv[k]));
        }
    }
}

static void spoil(spoilt *p, int n_wrong, int way)
{
    bench_scene *const s = &p->scene;
    double low[2], high[2];
    int order[N_MOST];

    region(low, high, s, way);
    for (int i = 0; i < s->n; i++) {
        order[i] = i;
        p->right[i] = 1;
    }
    for (int i = 0; i < n_wrong; i++) {
        const int j = i + (int)(test_next(&s->rng) % (uint64_t)(s->n - i));
        const int swap = order[i];

        order[i] = order[j];
        order[j] = swap;
        p->right[order[i]] = 0;
    }
    const rigcal_observation first = s->seen[order[0]];
    for (int i = 0; i < n_wrong; i++) {
        const rigcal_observation *const next =
            i + 1 < n_wrong ? &s->seen[order[i + 1]] : &first;

        for (int k = 0; k < 2; k++) {
            s->seen[order[i]].uv[k] =
                way == SWAPPED ? next->uv[k] : RC(test_uniform(&s->rng, low[k], high[k]));
        }
    }
    p->n_rest = 0;
    for (int i = 0; i < s->n; i++) {
        if (p->right[i]) {
            p->rest[p->n_rest++] = s->seen[i];
        }
    }
}

/* The error of the pose nearest to the truth: the angle, and the length over the
 * distance. */
static void nearest(double error[2], const bench_scene *s, const rigcal_pose poses[],
                    size_t n)
{
    error[0] = error[1] = 1e300;
    for (size_t i = 0; i < n; i++) {
        double R[9], t[3], d[3], angle;

        test_transform_parts(R, t, &poses[i].cam_from_world);
        angle = test_angle_between(R, s->R);
        for (int k = 0; k < 3; k++) {
            d[k] = t[k] - s->t[k];
        }
        if (angle < error[0]) {
            error[0] = angle;
            error[1] = test_norm(d) / test_norm(s->t);
        }
    }
}

/* Whether a pose is right: its error is at most three times that of the pose of the right
 * points alone, plus 2 degrees and 2 %. The first is the same least squares, except for a
 * point or two at the threshold. The second allows for the distance between two optima of
 * some scenes. */
static int is_right(const spoilt *p, const rigcal_pose poses[], size_t n)
{
    rigcal_pose others[RIGCAL_POSES_MAX];
    double here[2], there[2];
    size_t n_others = 0;

    if (rigcal_pose_solve(others, RIGCAL_POSES_MAX, &n_others, NULL,
                          &VIEW(&p->scene.camera, p->rest, NULL, p->n_rest), NULL) < 0) {
        n_others = 0;
    }
    nearest(here, &p->scene, poses, n);
    nearest(there, &p->scene, others, n_others);
    return here[0] <= 3 * there[0] + 2 * BENCH_DEGREE && here[1] <= 3 * there[1] + 0.02;
}

static void row(const bench_family *f, int n, int n_wrong, int way, long count)
{
    long missed = 0, believed = 0, exact = 0;
    tally statuses = {{0}};

    for (long index = 0; index < count; index++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        uint8_t inliers[N_MOST];
        size_t n_found = 0, n_inliers;
        spoilt p;

        bench_scene_make(&p.scene, f, n, index, &NEAR);
        spoil(&p, n_wrong, way);
        const rigcal_status status =
            rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found, inliers, &n_inliers,
                                NULL, &VIEW(&p.scene.camera, p.scene.seen, NULL, n), NULL);
        tally_add(&statuses, status);
        const int is_wrong = status < 0 || n_wrong == n || !is_right(&p, poses, n_found);
        missed += is_wrong;
        believed += is_wrong && status >= 0 && status != RIGCAL_FEW_AGREE;
        exact += status >= 0 && memcmp(inliers, p.right, (size_t)n) == 0;
    }
    printf("| %s | %d | %d | %s | %ld | %ld | %ld | ", f->name, n, n_wrong, WAY[way],
           missed, believed, exact);
    tally_print(&statuses);
    printf(" |\n");
}

int main(int argc, char **argv)
{
    static const char *const FAMILY[3] = {"general", "planar", "near-planar"};
    static const int FEW[3] = {5, 6, 8}, MANY[3] = {12, 20, 50};
    const char *const what = argc > 1 ? argv[1] : "";
    const long count = argc > 2 ? atol(argv[2]) : 10000;

    if ((strcmp(what, "wrong") != 0 && strcmp(what, "one") != 0 &&
         strcmp(what, "all") != 0) ||
        count < 1) {
        fprintf(stderr, "bench_robust wrong|one|all [COUNT]\n");
        return 2;
    }
    printf("%s\n\n%ld scenes a line.\n\n", BENCH_BUILD, count);
    printf("| target | points | wrong | where | pose not right | of these believed | "
           "inliers exact | not OK |\n");
    printf("| --- | ---: | ---: | --- | ---: | ---: | ---: | --- |\n");
    for (int f = 0; f < 3; f++) {
        for (int i = 0; i < 3; i++) {
            const int n = strcmp(what, "one") == 0 ? FEW[i] : MANY[i];

            for (int way = 0; way < (*what == 'o' ? SWAPPED : WAYS); way++) {
                row(bench_family_of(FAMILY[f]), n,
                    *what == 'o'   ? 1
                    : *what == 'a' ? n
                                   : n * 3 / 10,
                    way, count);
            }
        }
    }
    return 0;
}
