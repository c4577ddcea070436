/* rigcal_judge.h - which views of a rig are wrong, and why. Included by rigcal.h, whose
 * first page holds here too.
 *
 * A wrong view is one of another placement than its number says, of a target turned by its
 * own symmetry, of another camera, with points in another unit. It bends the whole rig.
 *
 *   rigcal_rig_judge   adjusts the rig, and leaves out the views that contradict it
 *   rigcal_rig_cause   why a view contradicts: turned, late or early, swapped, or unknown
 *
 * EQUATIONS.md RIG has the mathematics, (G17) and (G18). */
#ifndef RIGCAL_JUDGE_H
#define RIGCAL_JUDGE_H

#include "rigcal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ==== which ================================================================== */

enum rigcal_view_verdicts {
    RIGCAL_VIEW_FITS = 0,
    RIGCAL_VIEW_CONTRADICTS = 1, /* left out: two others of its placement or more agree */
    RIGCAL_VIEW_ONE_OF_TWO = 2,  /* left out: no two views of its placement agree, and
                                    nothing says which of them is wrong */
    RIGCAL_VIEW_UNCHECKED = 3    /* no other camera saw its placement */
};

typedef struct rigcal_judged_view {
    int32_t verdict;    /* RIGCAL_VIEW_ */
    rigcal_real cost;   /* what it adds to the sum of squared errors, its placement settling
                           with and without it, over the limit of that. Above 1 a view is
                           left out. 0 of one that is unchecked */
    rigcal_real rms_px; /* reprojection error a point, sigma_i included, where the others
                           have its placement; -1: a point is then behind the camera or
                           beyond its lens, or there are no others */
} rigcal_judged_view;

typedef struct rigcal_judgement {
    rigcal_rig_fit fit;   /* of the views that are not left out */
    rigcal_real sigma_px; /* noise by which views were judged: the choice's */
    rigcal_real scale;    /* 1: views differ by noise alone. Else the limit is as many
                             times as large, since all of them differ by more */
    int32_t n_fit, n_contradict, n_one_of_two, n_unchecked; /* views of each verdict */
    int32_t adjustments;
} rigcal_judgement;

typedef struct rigcal_judge_solver rigcal_judge_solver; /* see rigcal_solvers.h */

/* Reals of the rig's memory to work in. The same as a function: rigcal_judge_work. */
#define RIGCAL_JUDGE_WORK(n_cameras, n_placements) \
    (RIGCAL_RIG_WORK(n_cameras, n_cameras, n_placements) + 78 * (size_t)(n_cameras))
RIGCAL_API size_t rigcal_judge_work(size_t n_cameras, size_t n_placements);

/* After rigcal_rig_choose, in the place of rigcal_rig_adjust: adjusts the rig, from where
 * it is, and names the views that contradict it. They are left out, and it is adjusted
 * again, at most 9 times.
 *
 *   judged     out     n_views: of each its verdict
 *   left_out   out     n_views: 1 where a view is left out. rig->left_out points to it
 *   choice     in/out  takes, n_views, and sigma_px; second_poses if there are any. takes
 *                      is none of a view that is left out
 *   rig        in/out  as for rigcal_rig_adjust, with views and view_poses
 *
 * The limit: a view may cost 40 sigma^2 s. It costs what the sum of squared errors falls by
 * without it, its placement settling again. The middle cost of all views says how much they
 * differ by more than noise; where noise is all, s is 1. It holds while less than half of
 * the views are wrong. Of two views that contradict each other both are left out.
 *
 * RIGCAL_VIEWS_LEFT_OUT: some are. OK, and those of rigcal_rig_adjust and
 * rigcal_rig_choose, but not ERR_CONTRADICTION; ERR_RANGE also: sigma_px is 0, a view takes
 * what is not there; ERR_TOO_FEW also: no view is left. */
RIGCAL_API rigcal_status rigcal_rig_judge(rigcal_judgement *judgement, int32_t *at_fault,
                                          rigcal_judged_view judged[], uint8_t left_out[],
                                          rigcal_choice *choice, rigcal_rig *rig);

/* The same in steps. A unit is one of rigcal_rig_step; one view, checked or evaluated,
 * O(n), or what it costs, O(n_cameras); one placement's choice, O(n_cameras^2); or passes
 * over `judged`, O(n_views). The same bits whatever the budgets. All must last. */
RIGCAL_API rigcal_status rigcal_judge_begin(rigcal_judge_solver *solver,
                                            rigcal_judged_view judged[], uint8_t left_out[],
                                            rigcal_choice *choice, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_judge_step(rigcal_judge_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_judge_result(rigcal_judgement *judgement, int32_t *at_fault,
                                             const rigcal_judge_solver *solver);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_JUDGE_H */
