/* rigcal_choose.h - which cameras of a rig are connected and how well, and which of its two
 * poses each ambiguous view has. Included by rigcal.h, whose first page holds here too.
 *
 *   rigcal_rig_links     what every two cameras share, and the groups
 *   rigcal_rig_advise    if there are several groups: which pairs of cameras should see
 *                        the target at once
 *   rigcal_rig_weakest   in an adjusted rig: the camera that is least sure
 *   rigcal_rig_choose    one pose of each view, cameras, placements: the start of
 *                        rigcal_rig_adjust
 *
 * EQUATIONS.md CHOICE has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_CHOOSE_H
#define RIGCAL_CHOOSE_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== the graph of cameras =================================================== */

/* What two cameras share. */
typedef struct rigcal_link {
    int32_t n_shared;        /* placements that both saw */
    rigcal_real information; /* how well the rotation between them is known: the sum of 1 /
                                variance over these placements, for noise of 1 px
                                [1/rad^2] */
} rigcal_link;

/* Where the link of cameras a < b stands, and how many there are of n cameras. */
#define RIGCAL_LINK(a, b) ((size_t)(b) * ((size_t)(b)-1) / 2 + (size_t)(a))
#define RIGCAL_LINKS(n_cameras) RIGCAL_LINK(0, n_cameras)

/* Computes all links from rig->view_poses, and writes rig->group. *n_groups is 1 where all
 * cameras are connected. `capacity` counts links. The function uses rig->work: the
 * covariance that an adjustment left there is lost. The statuses of rigcal_rig_join. Time
 * O(n_views n_cameras). */
RIGCAL_API rigcal_status rigcal_rig_links(rigcal_link links[], size_t capacity,
                                          int32_t *n_groups, int32_t *at_fault,
                                          rigcal_rig *rig);

/* Cameras a and b are in different groups: place the target where both see it. */
typedef struct rigcal_advice {
    int32_t a, b;
} rigcal_advice;

/* Call it after rigcal_rig_links. One placement for each line of advice joins all groups
 * into one. From each group the advice takes the camera that has most in common with the
 * rest of the group. *n: number of lines, one less than there are groups. OK, ERR_NULL,
 * ERR_TOO_FEW, ERR_NOT_FINITE, ERR_RANGE (also: a group's number is no camera's),
 * ERR_CAPACITY. Time O(n_cameras^2). */
RIGCAL_API rigcal_status rigcal_rig_advise(rigcal_advice advice[], size_t capacity,
                                           size_t *n, const rigcal_link links[],
                                           const rigcal_rig *rig);

/* The camera whose pose is least sure, and the camera against which it is best known. */
typedef struct rigcal_weakest {
    int32_t camera, other;
    rigcal_real rotation;    /* rad, standard deviation of the turn between them */
    rigcal_real translation; /* unit of length, standard deviation of the shift */
} rigcal_weakest;

/* Call it after an adjustment. A camera is sure if its rotation against some other camera
 * has little variance. The statuses of rigcal_rig_covariance, ERR_TOO_FEW (no two cameras
 * have a common frame). Time O(n_cameras^2). */
RIGCAL_API rigcal_status rigcal_rig_weakest(rigcal_weakest *weakest, const rigcal_rig *rig,
                                            rigcal_real sigma_px);

/* ==== the choice ============================================================= */

enum rigcal_takes {
    RIGCAL_TAKES_FIRST = 0,  /* the view's pose is that of view_poses */
    RIGCAL_TAKES_SECOND = 1, /* it is that of second_poses */
    RIGCAL_TAKES_NONE = 2    /* neither agrees with the rest of its placement */
};

/* What rigcal_rig_choose takes besides the rig, and what it returns. The rig's view_poses
 * hold the better pose of each view. Set the struct to zero, then fill in what there
 * is. */
typedef struct rigcal_choice {
    const rigcal_view_pose *second_poses;  /* n_views; n = 0 means no second pose; or
                                              NULL */
    rigcal_view_pose_source second_source; /* the same, with the rig's context; or NULL */
    uint8_t *takes;                        /* n_views, written: of rigcal_takes */

    rigcal_real sigma_px; /* the noise used: the rig's, or that of the views' own fits */
    rigcal_real tau2;  /* 1, 4, 16, 64 or 256: right views differ by sigma^2 times this */
    rigcal_real share; /* of the pairs of views that could agree, the part that does */
    size_t n_left_out; /* number of views that take neither pose */
} rigcal_choice;

/* Two cameras are compared in at most this many placements: those with most information. */
enum rigcal_choose_limits { RIGCAL_CHOOSE_PLACEMENTS = 20 };

/* Reals of rig->work that the choice needs. The adjustment that follows uses the same
 * memory, so give it the larger of this and RIGCAL_RIG_WORK. As a function:
 * rigcal_choose_work. */
#define RIGCAL_CHOOSE_WORK(n_cameras, n_placements, n_views) \
    (44 * (size_t)(n_cameras) + RIGCAL_LINKS(n_cameras) + 1 + 4 * (size_t)(n_placements) + \
     2 * (size_t)(n_views) + \
     ((n_cameras) > 10 ? 78 * (size_t)(n_cameras) \
                       : 25 * (size_t)RIGCAL_CHOOSE_PLACEMENTS + 312))
RIGCAL_API size_t rigcal_choose_work(size_t n_cameras, size_t n_placements, size_t n_views);

/* Chooses for each view the pose that the other views support. Writes the choice. Also
 * writes cams_from_rig, rig_from_placements and group, from which the adjustment starts.
 * The frame of a group is that of its first camera that is held or has a prior, or else of
 * its first camera. Other cameras that are held or have a prior stay where they were
 * given. The noise is rig->sigma_px. Where that is 0, it is the median noise of the views'
 * own fits, at least 0.01 px.
 * OK, RIGCAL_DISCONNECTED, ERR_CONTRADICTION (fewer than half of the pairs of views agree,
 * both among all cameras and among the two cameras that agree best: no pose is written),
 * ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (also: a second pose is not of the
 * camera and placement of the first), ERR_TOO_FEW (also: no noise is stated, and no view
 * has more than three points), ERR_CAPACITY, ERR_TWICE, ERR_UNSORTED, ERR_DEGENERATE, and
 * what a source returns. *at_fault: the number of the view, or -1. Each camera is compared
 * with few others, in at most RIGCAL_CHOOSE_PLACEMENTS placements. */
RIGCAL_API rigcal_status rigcal_rig_choose(rigcal_choice *choice, int32_t *at_fault,
                                           rigcal_rig *rig);

typedef struct rigcal_choose_solver rigcal_choose_solver; /* see rigcal_solvers.h */

/* The same in steps. A unit is one of these: one view, read and checked, or placed,
 * O(n_cameras); the poses of two cameras in one placement compared with those in another,
 * at most 16 comparisons of some 1000 operations; one pose of a placement compared with
 * all its others, O(n_cameras); or the list of what two cameras share, O(n_views). The
 * budgets do not change one bit of the result. `choice` and `rig` must last until then. */
RIGCAL_API rigcal_status rigcal_choose_begin(rigcal_choose_solver *solver,
                                             rigcal_choice *choice, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_choose_step(rigcal_choose_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_choose_result(int32_t *at_fault,
                                              const rigcal_choose_solver *solver);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_CHOOSE_H */
