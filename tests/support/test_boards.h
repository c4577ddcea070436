/* test_boards.h - a simulated rig, calibrated as in practice: cameras in an arc, and a flat
 * board of 5 x 4 points that is shown to them in many placements. Also errors of its views.
 * Truth and projection are in double. */
#ifndef TEST_BOARDS_H
#define TEST_BOARDS_H

#include "test_support.h"

enum {
    BOARD_CAMERAS_MAX = 6,
    BOARD_PLACES_MAX = 24,
    BOARD_VIEWS_MAX = BOARD_CAMERAS_MAX * BOARD_PLACES_MAX / 3 + 32,
    BOARD_POINTS = 20,
    BOARD_WORK = RIGCAL_JUDGE_WORK(BOARD_CAMERAS_MAX, BOARD_PLACES_MAX) +
                 RIGCAL_CHOOSE_WORK(BOARD_CAMERAS_MAX, BOARD_PLACES_MAX, BOARD_VIEWS_MAX)
};

typedef struct {
    rigcal_transform true_cams[BOARD_CAMERAS_MAX], true_places[BOARD_PLACES_MAX];
    rigcal_camera camera;
    double X[BOARD_POINTS][3];
    /* the arguments of calls; `rig` points to the other arrays */
    rigcal_transform cams[BOARD_CAMERAS_MAX], places[BOARD_PLACES_MAX];
    int32_t group[BOARD_CAMERAS_MAX];
    rigcal_rig_view views[BOARD_VIEWS_MAX];
    rigcal_view_pose own[BOARD_VIEWS_MAX];
    rigcal_observation o[BOARD_VIEWS_MAX][BOARD_POINTS];
    rigcal_real work[BOARD_WORK];
    uint8_t left_out[BOARD_VIEWS_MAX], takes[BOARD_VIEWS_MAX];
    rigcal_choice choice;
    rigcal_judged_view judged[BOARD_VIEWS_MAX];
    rigcal_judgement judgement;
    uint8_t is_wrong[BOARD_VIEWS_MAX]; /* the truth about each view */
    rigcal_rig rig;
} test_boards;

/* A random rig. Each placement is seen by `seen` of the cameras (at least two), with noise.
 * Besides, every view has a smooth pattern with an amplitude in pixels, as if the board
 * were bent. */
void test_boards_make(test_boards *b, test_rng *rng, int n_cameras, int n_places, int seen,
                      double noise_px, double pattern_px);

/* The view of a placement by a camera, or -1. */
int test_boards_view(const test_boards *b, int camera, int placement);

/* Errors of views: view v gets the pixels of view `from`; view v gets its own pixels in
 * reverse, as if the board were turned by half a turn; two views exchange their pixels.
 * They set is_wrong. */
void test_boards_replace(test_boards *b, int v, int from);
void test_boards_reverse(test_boards *b, int v);
void test_boards_swap(test_boards *b, int v, int other);

/* Makes camera c late by one placement: each of its views gets the pixels of the placement
 * before, and its first view is removed. The camera must see all placements. */
void test_boards_late(test_boards *b, int camera);

/* Intrinsics as they are assumed: those of the camera that took the pictures, off by
 * numbers drawn with these standard deviations. */
rigcal_camera test_boards_lens(const test_boards *b, test_rng *rng,
                               const rigcal_intrinsics_sigma *sigma);

/* The pose of every view by itself; of view v alone; and all cameras and placements at the
 * truth, in place of joined ones. */
void test_boards_solve(test_boards *b);
void test_boards_solve_view(test_boards *b, int v);

/* Leaves out the views whose own pose is too far from the truth for noise of noise_px. A
 * join by poses that agree does the same. */
void test_boards_join(test_boards *b, double noise_px);

/* The error over its bound: sqrt of d^T Sigma^-1 d / 6 over all pairs of cameras of one
 * group, where d is the error of the pair's transform. */
double test_boards_error(const test_boards *b, rigcal_real sigma_px);

#endif /* TEST_BOARDS_H */
