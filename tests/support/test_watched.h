/* test_watched.h - a simulated rig that is watched by a monitor. The truth, and what comes
 * of it, are in double. Camera 0 is the frame; f = 800 px, no distortion; the scene is 2 to
 * 4 before the cameras. */
#ifndef TEST_WATCHED_H
#define TEST_WATCHED_H

#include "test_support.h"

enum {
    WATCHED_CAMERAS_MAX = RIGCAL_TEST_RAM < 32768 ? 2 : 8,
    WATCHED_TARGETS_MAX = 1,
    WATCHED_BODIES_MAX = WATCHED_CAMERAS_MAX + WATCHED_TARGETS_MAX,
    WATCHED_FREE_MAX = 6 * (WATCHED_CAMERAS_MAX - 1)
};

typedef struct {
    double R[9], t[3];
} watched_pose;

typedef struct {
    int n_cameras, n_targets, is_parallel;
    watched_pose truth[WATCHED_BODIES_MAX]; /* body_from_rig; targets after the cameras */
    rigcal_mounted_camera cameras[WATCHED_CAMERAS_MAX];
    int32_t group[WATCHED_CAMERAS_MAX];
    uint8_t held[WATCHED_CAMERAS_MAX];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(WATCHED_CAMERAS_MAX - 1)];
    rigcal_calibrated_rig rig; /* points to the arrays above */
    rigcal_real monitor[RIGCAL_MONITOR_SIZE(WATCHED_CAMERAS_MAX, WATCHED_TARGETS_MAX)];
    size_t size; /* of the monitor, in reals */
} test_watched;

/* What matches are like. */
typedef struct {
    int matches;     /* a frame */
    double noise_px; /* of each coordinate, normal */
    double wrong;    /* share of them of which the second pixel is anywhere within 40 px */
    int by_rays;     /* handed in by rays */
} watched_matches;

/* Cameras that are known to sd_rad and sd_t each: two side by side, 0.12 apart, or on an
 * arc. Their covariance is diagonal. The monitor is not begun. */
void test_watched_make(test_watched *w, test_rng *rng, int n_cameras, int is_parallel,
                       double sd_rad, double sd_t);

/* Begins the monitor with the rig; options NULL: all defaults. */
void test_watched_begin(test_watched *w, int n_targets,
                        const rigcal_monitor_options *options);

/* The truth moves: a body by d = (w, dt), or every camera at random. */
void test_watched_bump(test_watched *w, int body, const double d[6]);
void test_watched_walk(test_watched *w, test_rng *rng, double sd_rad, double sd_t);

/* A point of the scene, and what a camera sees of it. */
void test_watched_point(double X[3], const test_watched *w, test_rng *rng);
void test_watched_pixel(double uv[2], const test_watched *w, int camera, const double X[3]);

/* A target's point X_w in the rig. */
void test_watched_target_point(double X[3], const test_watched *w, int target,
                               const double X_w[3]);

/* Hands in the matches of a frame, of any two cameras each. */
void test_watched_match(test_watched *w, test_rng *rng, const watched_matches *like);

/* e = (w, dt) of all cameras but the first, by which the truth differs from the monitor's
 * poses; and e . P^-1 e of all n. */
void test_watched_error(double e[], test_watched *w);
double test_watched_nees(test_watched *w, double e[]);

/* The value that chi squared of n degrees of freedom exceeds in 5 %. */
double test_chi2_95(int n);

#endif /* TEST_WATCHED_H */
