/* rigcal_judge.h - which views of a rig are wrong, and why. Included by rigcal.h, whose
 * first page holds here too.
 *
 * A view is wrong if it is of another placement than its number says, of another camera,
 * of a target that is turned by its own symmetry, or with points in another unit. One
 * wrong view bends the whole rig.
 *
 *   rigcal_rig_judge      adjusts the rig, and leaves out the views that contradict it
 *   rigcal_rig_cause      why a view contradicts: turned, late or early, swapped, or
 *                         unknown
 *   rigcal_camera_cause   why most views of a camera contradict
 *
 * EQUATIONS.md JUDGE has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_JUDGE_H
#define RIGCAL_JUDGE_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== which ================================================================== */

enum rigcal_view_verdicts {
    RIGCAL_VIEW_FITS = 0,
    RIGCAL_VIEW_CONTRADICTS = 1, /* left out: at least two other views of its placement
                                    agree */
    RIGCAL_VIEW_ONE_OF_TWO = 2,  /* left out: no two views of its placement agree, and
                                    nothing says which of them is wrong */
    RIGCAL_VIEW_UNCHECKED = 3    /* no other camera saw its placement */
};

typedef struct rigcal_judged_view {
    int32_t verdict;    /* RIGCAL_VIEW_ */
    rigcal_real cost;   /* how much the sum of squared errors falls without the view, after
                           its placement settles again, less the view's own sum at its pose
                           by itself; divided by the limit. Above 1 the view is left out. 0:
                           it is unchecked */
    rigcal_real rms_px; /* root mean square reprojection error in the rig, sigma_i included.
                           If the view is left out, the placement is where the other views
                           put it. -1: a point would be behind the camera or beyond its
                           lens, or there are no other views */
} rigcal_judged_view;

typedef struct rigcal_judgement {
    rigcal_rig_fit fit;   /* of the views that are not left out */
    rigcal_real sigma_px; /* noise by which views were judged: that of the choice */
    rigcal_real scale;    /* 1: views differ by noise alone. Above 1: all views differ by
                             more, and the limit is this many times as large */
    int32_t n_fit, n_contradict, n_one_of_two, n_unchecked; /* views of each verdict */
    int32_t adjustments;
} rigcal_judgement;

typedef struct rigcal_judge_solver rigcal_judge_solver; /* see rigcal_solvers.h */

/* Reals of rig->work. As a function: rigcal_judge_work. */
#define RIGCAL_JUDGE_WORK(n_cameras, n_placements) \
    (RIGCAL_RIG_WORK(n_cameras, n_cameras, n_placements) + 78 * (size_t)(n_cameras))
RIGCAL_API size_t rigcal_judge_work(size_t n_cameras, size_t n_placements);

/* Call it after rigcal_rig_choose, instead of rigcal_rig_adjust. It adjusts the rig from
 * where it is, finds the views that contradict it, leaves them out and adjusts again, at
 * most 6 times in all.
 *
 *   judged     out     n_views: the verdict on each view
 *   left_out   out     n_views: 1 where a view is left out. rig->left_out points to it
 *   choice     in/out  reads takes, n_views, sigma_px, and second_poses if there are any.
 *              A view that is left out takes none. A view that took none and is not left
 *              out takes the first
 *   rig        in/out  as for rigcal_rig_adjust, with views and view_poses
 *
 * All views are judged anew, and all need their poses: what rig->left_out says before is
 * not read. Hand in only views that may count.
 *
 * The cost of a view is how much the sum of squared errors falls without it, after its
 * placement settles again, less the view's own sum at its pose by itself. The limit is 40
 * sigma^2 s. The scale s comes from the median cost of all views, which shows by how much
 * more than noise they differ; it is 1 where there is only noise. The limit is right while
 * fewer than half of the views are wrong. Of right views of three points about one in a
 * hundred is left out too: its pose by itself is far from linear. If just two views of a
 * placement contradict each other, both are left out.
 *
 * RIGCAL_VIEWS_LEFT_OUT: some views were left out. OK, and those of rigcal_rig_adjust and
 * rigcal_rig_choose, except ERR_CONTRADICTION; ERR_RANGE (also: sigma_px is 0, or a view
 * takes a pose that is not there); ERR_TOO_FEW (also: no view is left). */
RIGCAL_API rigcal_status rigcal_rig_judge(rigcal_judgement *judgement, int32_t *at_fault,
                                          rigcal_judged_view judged[], uint8_t left_out[],
                                          rigcal_choice *choice, rigcal_rig *rig);

/* The same in steps. A unit is one of rigcal_rig_step; one view, checked or evaluated,
 * O(n), or what it costs, O(n_cameras); one placement's choice, O(n_cameras^2); or passes
 * over `judged`, O(n_views). The budgets do not change one bit of the result. All that is
 * handed in must last. */
RIGCAL_API rigcal_status rigcal_judge_begin(rigcal_judge_solver *solver,
                                            rigcal_judged_view judged[], uint8_t left_out[],
                                            rigcal_choice *choice, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_judge_step(rigcal_judge_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_judge_result(rigcal_judgement *judgement, int32_t *at_fault,
                                             const rigcal_judge_solver *solver);

/* ==== why ==================================================================== */

enum rigcal_causes {
    RIGCAL_CAUSE_UNKNOWN = 0,
    RIGCAL_CAUSE_TURNED = 1,  /* the target is turned by a symmetry: its points are
                                 permuted */
    RIGCAL_CAUSE_SHIFTED = 2, /* the view is of the placement before, or of the one after */
    RIGCAL_CAUSE_SWAPPED = 3  /* the view is of another camera, in the same placement */
};

typedef struct rigcal_cause {
    int32_t cause;        /* RIGCAL_CAUSE_ */
    int32_t permutation;  /* number of the permutation, from 0; -1: none */
    int32_t shift;        /* -1: it is of the placement before, the camera is late. 1: it is
                             of the one after, the camera is early. 0: neither */
    int32_t is_still;     /* 1: the target stood still, both placements fit, and which one
                             is right stays open */
    int32_t camera;       /* the camera whose view it is; -1: none */
    int32_t n_agree;      /* of a camera: number of views that agree with this cause, */
    int32_t n_views;      /* and of views that could be checked for it */
    rigcal_real distance; /* of a view: squared distance to where the others put its
                             placement, divided by the limit; at most 1 */
} rigcal_cause;

/* The turns after which a target looks the same: half a turn for a board with an even
 * number of squares, quarter turns for a tag, each step for a ring of lights. */
typedef struct rigcal_symmetries {
    const int32_t *permutations; /* n_permutations rows of n_points: for each point of a
                                    view, the number of the point that it really is */
    size_t n_permutations;       /* 0: none */
    size_t n_points;             /* points of the target, 3 or more. Views of fewer points
                                    are not tested for turns */
    rigcal_observation *room;    /* n_points, to work in */
} rigcal_symmetries;

typedef struct rigcal_cause_solver rigcal_cause_solver; /* see rigcal_solvers.h */

/* Why a view contradicts the others, after rigcal_rig_judge. The function solves the view
 * again with its points permuted. It solves the view as it is and compares its poses with
 * the placement before and the one after. It takes the view for that of each camera whose
 * view of the same placement is left out. Whatever comes within 30 sigma^2 s of where the
 * others put the placement is the cause; of several, the nearest is. The function takes the
 * camera's own pose for right: if all views of a camera are left out, use
 * rigcal_camera_cause. If two views contradict each other, ask for both, because either may
 * be the turned one. If no cause is found, rigcal_pose_diagnose says whether a point is
 * wrong, or the target's coordinates are mirrored or in another unit.
 *
 *   judgement    in  reads sigma_px and scale; set scale to 1 if it is not known
 *   symmetries   in  NULL: none
 *
 * OK; ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (also: a permutation has a point
 * twice, or a number of no point), ERR_TOO_FEW (also: n_points), ERR_UNSORTED, ERR_CAMERA,
 * ERR_DEGENERATE, and what a source returns. It solves the view once as it is, and once for
 * each permutation and for each camera that it tries. */
RIGCAL_API rigcal_status rigcal_rig_cause(rigcal_cause *cause, const rigcal_rig *rig,
                                          const rigcal_judgement *judgement,
                                          const rigcal_symmetries *symmetries, size_t view);

/* Why most views of a camera contradict the others: all of them are turned alike, or all
 * are of the placement before or after. For each of these causes, each view in turn gives
 * a pose of the camera, and the function counts the views that agree with that pose. At
 * least two views and more than half of them must agree, and more than agree without the
 * cause. The rig need not be adjusted. The function needs the poses of the other cameras,
 * if there are two or more of them, left_out, and the placements that they agree on. After
 * ERR_CONTRADICTION with two cameras no placement is known: set left_out to 1 for all
 * views, and try the scales 1, 4, 16 and 64. The statuses above. O(m^2 n_cameras) for m
 * views of the camera, and one pose for each permutation. */
RIGCAL_API rigcal_status rigcal_camera_cause(rigcal_cause *cause, const rigcal_rig *rig,
                                             const rigcal_judgement *judgement,
                                             const rigcal_symmetries *symmetries,
                                             size_t camera);

/* Either function in steps. A unit is one of rigcal_pose_step; the comparison of a
 * view with one placement or two, O(n_cameras); or that of one view of a camera with its
 * others, O(m n_cameras).
 * The budgets do not change one bit of the result. All that is handed in must last. */
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
