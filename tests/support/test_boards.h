/* test_boards.h - a simulated rig as they are calibrated in practice: cameras in an arc, a
 * flat board of 5 x 4 points shown to them in many placements; and what goes wrong with its
 * views. Truth and projection are in double. */
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
    /* what is handed in; `rig` points to the rest */
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
    uint8_t is_wrong[BOARD_VIEWS_MAX]; /* the truth about the view */
    rigcal_rig rig;
} test_boards;

/* A rig at random, each placement seen by `seen` of the cameras (at least two), with noise,
 * and besides in every view a smooth pattern of so many pixels, as of a bent board. */
void test_boards_make(test_boards *b, test_rng *rng, int n_cameras, int n_places, int seen,
                      double noise_px, double pattern_px);

/* The view of a camera in a placement, or -1. */
int test_boards_view(const test_boards *b, int camera, int placement);

/* What goes wrong: the pixels of view `from` in the place of those of view v; those of v in
 * reverse, as of a board turned by half; two views' pixels exchanged. is_wrong is set. */
void test_boards_replace(test_boards *b, int v, int from);
void test_boards_reverse(test_boards *b, int v);
void test_boards_swap(test_boards *b, int v, int other);

/* Camera c a placement late: each view has the pixels of its placement before, and its
 * first one is taken out. It must see all placements. */
void test_boards_late(test_boards *b, int camera);

/* The pose of every view by itself, of view v alone, and all cameras and placements at the
 * truth, which stand for what was joined. */
void test_boards_solve(test_boards *b);
void test_boards_solve_view(test_boards *b, int v);

/* Leaves out the views whose own pose is too far from the truth for noise of noise_px, as a
 * join by poses that agree does. */
void test_boards_join(test_boards *b, double noise_px);

/* sqrt of d^T Sigma^-1 d / 6 over all pairs of cameras of one group, d by which the pair's
 * transform is off: the error over its bound. */
double test_boards_error(const test_boards *b, rigcal_real sigma_px);

#endif /* TEST_BOARDS_H */
