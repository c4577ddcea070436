/* test_rigs.h - a simulated rig and what its cameras saw, as arguments of calls. The
 * cameras stand in an arc about the placements; camera 0 is the frame. Truth and
 * composition are in double. */
#ifndef TEST_RIGS_H
#define TEST_RIGS_H

#include "test_support.h"

enum {
    RIG_CAMERAS_MAX = 4,
    RIG_PLACEMENTS_MAX = 8,
    RIG_VIEWS_MAX = RIG_CAMERAS_MAX * RIG_PLACEMENTS_MAX,
    RIG_POINTS_MAX = 12,
    RIG_WORK = RIGCAL_RIG_WORK(RIG_CAMERAS_MAX, RIG_CAMERAS_MAX, RIG_PLACEMENTS_MAX)
};

typedef struct {
    /* the truth */
    rigcal_transform true_cams[RIG_CAMERAS_MAX], true_places[RIG_PLACEMENTS_MAX];
    rigcal_camera camera[RIG_CAMERAS_MAX];
    double X[RIG_POINTS_MAX][3];
    int n_points;
    /* the arguments of calls; `rig` points to the other arrays */
    rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
    int32_t group[RIG_CAMERAS_MAX];
    rigcal_rig_view views[RIG_VIEWS_MAX];
    rigcal_view_pose own[RIG_VIEWS_MAX];
    rigcal_observation o[RIG_VIEWS_MAX][RIG_POINTS_MAX];
    uint8_t roles[RIG_CAMERAS_MAX];
    rigcal_camera_prior priors[RIG_CAMERAS_MAX];
    rigcal_real work[RIG_WORK];
    rigcal_rig rig;
} test_rig;

/* A random rig, of which nothing was seen yet. The poses are the true ones. */
void test_rig_random(test_rig *r, test_rng *rng, int n_cameras, int n_placements,
                     int n_points);

/* Adds a view of a placement by a camera: exact pixels and noise. Call it in the order of
 * placements. */
void test_rig_see(test_rig *r, test_rng *rng, int camera, int placement, double noise_px);
void test_rig_see_all(test_rig *r, test_rng *rng, double noise_px);

/* The pose of every view by itself, with its information. */
void test_rig_solve_views(test_rig *r);

/* Sets the poses from which to start: the true ones with normal errors of turn and
 * shift. */
void test_rig_start(test_rig *r, test_rng *rng, double turn, double shift);

/* The true cam_from_target of a view. */
rigcal_transform test_rig_chain(const test_rig *r, int camera, int placement);

/* R <- exp([w]x) R, t <- t + dt; and back: the d that takes `origin` to `moved`, for turns
 * below pi. */
rigcal_transform test_moved(const rigcal_transform *origin, const double d[6]);
void test_step_between(double d[6], const rigcal_transform *moved,
                       const rigcal_transform *origin);

#endif /* TEST_RIGS_H */
