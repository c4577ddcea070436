/* test_motions.h - a simulated rig whose cameras have clocks of their own. A board of 20
 * points moves in front of it, in runs of consecutive frames. The pixels are those of the
 * true path, which is not a polynomial. Truth and projection are in double. */
#ifndef TEST_MOTIONS_H
#define TEST_MOTIONS_H

#include "test_support.h"

enum {
    MOTION_CAMERAS_MAX = 4,
    MOTION_PLACES_MAX = 24,
    MOTION_VIEWS_MAX = MOTION_CAMERAS_MAX * MOTION_PLACES_MAX,
    MOTION_POINTS = 20,
    MOTION_WORK = RIGCAL_JUDGE_WORK(MOTION_CAMERAS_MAX, MOTION_PLACES_MAX) +
                  RIGCAL_CLOCKS_WORK(MOTION_CAMERAS_MAX, MOTION_CAMERAS_MAX)
};

/* The settings of a recording. */
typedef struct {
    int cameras, runs, frames; /* of each run */
    double fps, speed, turn;   /* rms speeds of the board: m/s, rad/s */
    double pause;              /* from the middle of one run to that of the next [s] */
    double offset, drift,
        stamp; /* clocks are within +- this; noise of a view's stamp [s] */
    double noise_px;
} motion_scene;

typedef struct {
    double base_R[9], base_t[3], amplitude[6], rate[6], phase[6], middle;
} motion_path;

typedef struct {
    rigcal_camera camera;
    double X[MOTION_POINTS][3];
    rigcal_transform true_cams[MOTION_CAMERAS_MAX];
    double true_offsets[MOTION_CAMERAS_MAX], true_drifts[MOTION_CAMERAS_MAX];
    motion_path paths[MOTION_PLACES_MAX]; /* for each placement: the path of its run */
    /* the arguments of calls; `rig` points to the other arrays */
    rigcal_transform cams[MOTION_CAMERAS_MAX], places[MOTION_PLACES_MAX];
    int32_t group[MOTION_CAMERAS_MAX], states[MOTION_CAMERAS_MAX];
    rigcal_rig_view views[MOTION_VIEWS_MAX];
    rigcal_view_pose own[MOTION_VIEWS_MAX];
    rigcal_observation o[MOTION_VIEWS_MAX][MOTION_POINTS];
    rigcal_real times[MOTION_PLACES_MAX], instants[MOTION_PLACES_MAX];
    rigcal_real view_times[MOTION_VIEWS_MAX];
    rigcal_real offsets[MOTION_CAMERAS_MAX], drifts[MOTION_CAMERAS_MAX];
    rigcal_real work[MOTION_WORK];
    uint8_t left_out[MOTION_VIEWS_MAX];
    rigcal_rig rig;
    rigcal_rig_clocks clocks; /* the rig does not use these until it is told to */
} test_motions;

/* A random rig. All cameras see all placements. The first camera has offset and drift 0.
 * The poses are the true ones for a rig without clocks. */
void test_motions_make(test_motions *m, test_rng *rng, const motion_scene *scene);

/* The true rig_from_placement of placement f, `after` its stamp. */
rigcal_transform test_motions_at(const test_motions *m, int f, double after);

/* The pose of every view by itself, refined from the present poses. */
void test_motions_solve(test_motions *m);

/* Cameras and placements as test_motions_make left them, offsets and drifts 0. */
void test_motions_reset(test_motions *m);

/* d^T Sigma^-1 d / n. d is the error of all cameras except the first. Sigma is the
 * covariance after an adjustment of this rig, for noise of sigma_px. n is the number of
 * unknowns. */
double test_motions_error2(const test_motions *m, const double inverse[]);

/* inverse[n n] is that Sigma^-1, n = 6 (cameras - 1). */
void test_motions_information(double inverse[], const test_motions *m, double sigma_px);

#endif /* TEST_MOTIONS_H */
