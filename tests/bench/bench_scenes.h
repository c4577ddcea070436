/* bench_scenes.h - the random scenes that the benchmarks of a pose share, and what
 * the truth says of a pose.
 *
 * A scene is defined by its family, its number of points and its index, so any scene can be
 * made again alone. */
#ifndef BENCH_SCENES_H
#define BENCH_SCENES_H

#include "test_support.h"

#define BENCH_DEGREE (TEST_PI / 180)

/* The target is of size 1. */
typedef struct {
    const char *name;
    double box[3];  /* size of the box that holds the points */
    double aside;   /* distance of the middle from the axis, in parts of its depth */
    int is_tilted;  /* 1: the z axis of the box is within 60 degrees of the line of sight;
                       0: the target has any orientation */
    int has_second; /* flat enough for a second pose */
    int is_tag;     /* the corners of a square, in the order of a detector */
} bench_family;

enum { BENCH_FAMILIES = 6 };
extern const bench_family bench_families[BENCH_FAMILIES];

/* How the targets are seen by a camera of 800 px. */
typedef struct {
    double nearest, farthest; /* in sizes of the target */
    double sigma;             /* noise of a coordinate [px]; 0: only rounding to whole
                                 pixels, of 512 x 512 */
} bench_view;

typedef struct {
    rigcal_camera camera;
    rigcal_observation seen[TEST_SCENE_MAX];
    double R[9], t[3]; /* the truth; the origin of the world is the middle of the box */
    double sigma;      /* px; if the noise is rounding, that of rounding */
    int n;
    test_rng rng; /* state of the random numbers after the scene was made */
} bench_scene;

/* NULL: there is no family of that name. */
const bench_family *bench_family_of(const char *name);
/* Whether the family has targets of n points. */
int bench_has(const bench_family *f, int n);

void bench_scene_make(bench_scene *s, const bench_family *f, int n, long index,
                      const bench_view *view);

/* The true pose with an error of 2 degrees and 2 % of the distance, each in a random
 * direction. Then the same for a scene. */
void bench_beside(double R[9], double t[3], test_rng *rng, const double R_true[9],
                  const double t_true[3]);
void bench_disturb(double R[9], double t[3], bench_scene *s);

/* The least standard deviations that the errors (w, dt) of test_difference can have at the
 * truth: the Cramer-Rao bound, by difference quotients. Returns 0 if there are none. */
int bench_bound(double deviation[6], const bench_scene *s);

/* Mean of (error / bound)^2 over the rotation's three and the translation's. */
void bench_squares(double squares[2], const bench_scene *s, const double deviation[6],
                   const double R[9], const double t[3]);

#endif /* BENCH_SCENES_H */
