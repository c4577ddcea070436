/* test_watched.h - a simulated rig that a monitor watches. The truth and all that follows
 * from it are in double. Camera 0 is the frame; f = 800 px, no distortion; the scene is at
 * a distance of 2 to 4. */
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
    watched_pose truth[WATCHED_BODIES_MAX]; /* true body_from_rig; targets come after the
                                               cameras */
    rigcal_mounted_camera cameras[WATCHED_CAMERAS_MAX];
    int32_t group[WATCHED_CAMERAS_MAX];
    uint8_t held[WATCHED_CAMERAS_MAX];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(WATCHED_CAMERAS_MAX - 1)];
    rigcal_calibrated_rig rig; /* points to the arrays above */
    rigcal_real monitor[RIGCAL_MONITOR_SIZE(WATCHED_CAMERAS_MAX, WATCHED_TARGETS_MAX)];
    size_t size; /* size of the monitor, in reals */
} test_watched;

/* The properties of matches. */
typedef struct {
    int matches;     /* a frame */
    double noise_px; /* of each coordinate; normal noise */
    double wrong;    /* share of matches whose second pixel is anywhere within 40 px */
    int by_rays;     /* whether they are given by rays */
} watched_matches;

/* Cameras whose (w, dt) is known to sd_rad and sd_t: two side by side, 0.12 apart, or more
 * on an arc. Their covariance is diagonal. The monitor is not begun. */
void test_watched_make(test_watched *w, test_rng *rng, int n_cameras, int is_parallel,
                       double sd_rad, double sd_t);

/* Begins the monitor with the rig; options NULL: all defaults. */
void test_watched_begin(test_watched *w, int n_targets,
                        const rigcal_monitor_options *options);

/* Moves the truth: a body by d = (w, ds), or every camera at random. Each turns by w about
 * its own centre, and shifts by ds. */
void test_watched_bump(test_watched *w, int body, const double d[6]);
void test_watched_walk(test_watched *w, test_rng *rng, double sd_rad, double sd_t);

/* A point of the scene, and its noisy pixel in a camera. */
void test_watched_point(double X[3], const test_watched *w, test_rng *rng);
void test_watched_pixel(double uv[2], const test_watched *w, int camera, const double X[3]);

/* The place X_w in the rig of a target's point. */
void test_watched_target_point(double X[3], const test_watched *w, int target,
                               const double X_w[3]);

/* Turns a target at random, 2.5 in front of the cameras and aside by `shift`. */
void test_watched_hang(test_watched *w, test_rng *rng, int target, double shift);

/* What a camera sees of a target with these n points. */
void test_watched_see(rigcal_observation o[], const test_watched *w, int camera, int target,
                      double X_w[][3], int n, test_rng *rng, double noise_px);

/* Gives the monitor the matches of a frame. Each match is of two random cameras. */
void test_watched_match(test_watched *w, test_rng *rng, const watched_matches *like);

/* e = (w, dt) of all cameras except the first, by which the truth differs from the
 * monitor's poses; and e . P^-1 e over all n unknowns. */
void test_watched_error(double e[], test_watched *w);
double test_watched_nees(test_watched *w, double e[]);

/* The value that chi squared of n degrees of freedom exceeds in 5 % of cases. */
double test_chi2_95(int n);

#endif /* TEST_WATCHED_H */
