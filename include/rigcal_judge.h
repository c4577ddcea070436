/* rigcal_judge.h - which views of a rig are wrong, and why. Included by rigcal.h, whose
 * first page holds here too.
 *
 * A wrong view is one of another placement than its number says, of a target turned by its
 * own symmetry, of another camera, with points in another unit. It bends the whole rig.
 *
 *   rigcal_rig_judge      adjusts the rig, and leaves out the views that contradict it
 *   rigcal_rig_cause      why a view does: turned, late or early, swapped, or unknown
 *   rigcal_camera_cause   why most views of a camera do
 *
 * EQUATIONS.md JUDGE has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
#endif

#ifndef RIGCAL_JUDGE_H
#define RIGCAL_JUDGE_H

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
 * again: at most 6 times in all.
 *
 *   judged     out     n_views: of each its verdict
 *   left_out   out     n_views: 1 where a view is left out. rig->left_out points to it
 *   choice     in/out  takes, n_views, and sigma_px; second_poses if there are any. takes
 *                      is none of a view that is left out
 *   rig        in/out  as for rigcal_rig_adjust, with views and view_poses
 *
 * The limit: a view may cost 40 sigma^2 s. It costs what the sum of squared errors falls by
 * without it, its placement settling again. The middle cost of all views says how much they
 * differ by more than noise; where noise is all, s is 1. The limit is right while less than
 * half of the views are wrong. Of two views that contradict each other both are left out.
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

/* ==== why ==================================================================== */

enum rigcal_causes {
    RIGCAL_CAUSE_UNKNOWN = 0,
    RIGCAL_CAUSE_TURNED = 1,  /* by a symmetry of the target: its points are permuted */
    RIGCAL_CAUSE_SHIFTED = 2, /* it is of the placement before, or of the one after */
    RIGCAL_CAUSE_SWAPPED = 3  /* it is of another camera, in the same placement */
};

typedef struct rigcal_cause {
    int32_t cause;        /* RIGCAL_CAUSE_ */
    int32_t permutation;  /* which, counted from 0; -1 */
    int32_t shift;        /* -1: the placement before, the camera is late; 1: the one after,
                             the camera is early; 0 */
    int32_t is_still;     /* 1: both fit, the target stood still, and which is open */
    int32_t camera;       /* whose view it is; -1 */
    int32_t n_agree;      /* of a camera: views that agree so, */
    int32_t n_views;      /* and that could be checked so */
    rigcal_real distance; /* of a view: squared distance to where the others have its
                             placement, over the limit: at most 1 */
} rigcal_cause;

/* What a target looks alike by: a board of an even number of squares turned by half, a tag
 * by quarters, a ring of lights by each step. */
typedef struct rigcal_symmetries {
    const int32_t *permutations; /* n_permutations times n_points: row by row, for each
                                    point of a view the number of the one whose coordinates
                                    it has in truth */
    size_t n_permutations;       /* 0: none */
    size_t n_points;             /* of the target, 3 or more. Views of fewer points are not
                                    tested so */
    rigcal_observation *room;    /* n_points, to work in */
} rigcal_symmetries;

typedef struct rigcal_cause_solver rigcal_cause_solver; /* see rigcal_solvers.h */

/* Why a view contradicts the others, after rigcal_rig_judge: its points are permuted and it
 * is solved again; it is taken for one of the placement before and of the one after; and
 * for the view of each camera that is left out in the same placement. What comes within 30
 * sigma^2 s of where the others have the placement is the cause; of several the nearest.
 * The camera's own pose is taken for right: where all its views are left out, ask
 * rigcal_camera_cause. Of two views that contradict each other ask for both: either may be
 * the turned one. Of a view with no cause found, rigcal_pose_diagnose says whether a point
 * is wrong, or the target's coordinates are mirrored or in another unit.
 *
 *   judgement    in  sigma_px, scale: 1, if it is not known
 *   symmetries   in  NULL: none
 *
 * OK; ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (of a permutation also: a point
 * twice, or none's number), ERR_TOO_FEW (also: n_points), ERR_UNSORTED, ERR_CAMERA,
 * ERR_DEGENERATE, and what a source returns. It solves one pose for each permutation and
 * each such camera. */
RIGCAL_API rigcal_status rigcal_rig_cause(rigcal_cause *cause, const rigcal_rig *rig,
                                          const rigcal_judgement *judgement,
                                          const rigcal_symmetries *symmetries, size_t view);

/* Why most views of a camera contradict the others: all of them are turned alike, or are of
 * the placement before or after. For each of these one view puts the camera somewhere, and
 * others agree or not; each view in turn. More than half must agree, two or more, and more
 * than as they are. It wants no adjusted rig: where the other cameras are, if there are
 * two or more; left_out; and placements that they agree on. After ERR_CONTRADICTION of two
 * cameras no placement is known: set left_out to 1 for all views, and try the scales 1, 4,
 * 16 and 64. The statuses above. O(m^2 n_cameras) for m views of the camera, and one pose
 * for each permutation. */
RIGCAL_API rigcal_status rigcal_camera_cause(rigcal_cause *cause, const rigcal_rig *rig,
                                             const rigcal_judgement *judgement,
                                             const rigcal_symmetries *symmetries,
                                             size_t camera);

/* Either in steps. A unit is one of rigcal_pose_step; one comparison, O(n_cameras); or one
 * view of a camera against its others, O(m n_cameras). The same bits whatever the budgets.
 * All that is handed in must last. */
RIGCAL_API rigcal_status rigcal_cause_begin(rigcal_cause_solver *solver,
                                            const rigcal_rig *rig,
                                            const rigcal_judgement *judgement,
                                            const rigcal_symmetries *symmetries,
                                            size_t view);
RIGCAL_API rigcal_status rigcal_camera_cause_begin(rigcal_cause_solver *solver,
                                                   const rigcal_rig *rig,
                                                   const rigcal_judgement *judgement,
                                                   const rigcal_symmetries *symmetries,
                                                   size_t camera);
RIGCAL_API rigcal_status rigcal_cause_step(rigcal_cause_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_cause_result(rigcal_cause *cause,
                                             const rigcal_cause_solver *solver);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_JUDGE_H */
