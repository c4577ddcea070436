/* rigcal_monitor.h - watches a rig in use: whether a camera has moved, which one, and
 * where it is now. Included by rigcal.h, whose first page holds here too.
 *
 * A monitor begins with a calibrated rig. Frame by frame it takes what the cameras see:
 * matched points, and views of targets that stay or are carried about. It follows the
 * poses of the cameras with their joint covariance. It raises an alarm when a camera has
 * been bumped, and solves the pose of that camera anew.
 *
 *   rigcal_monitor_begin    from a calibrated rig
 *   rigcal_monitor_match    two cameras see one point; _match_rays: the same from rays
 *   rigcal_monitor_view     a camera sees a target
 *   rigcal_monitor_frame    ends a frame: poses, evidence, alarm
 *   rigcal_monitor_moved    answers an alarm: this body moved; _dismiss: none moved
 *   rigcal_monitor_rig      the rig as it is now, for rigcal_store_save_rig
 *
 * A body is a camera or a target. Bodies are numbered: the cameras are 0 .. n_cameras - 1,
 * and target k is body n_cameras + k. The first camera that is held is the frame: its pose
 * stays. If that camera moves, all others seem to move.
 *
 * Matches alone do not show the length of a baseline, or the scale of a rig of more
 * cameras. With two cameras they do not show which one moved, unless it turned far: that
 * looks like a shift of the other by many times move_t. But if a camera turned about a
 * point farther from it than the baseline is long, the blame is surer than it should be:
 * with 15 cm on a base of 12 cm, a blame of 0.99 was right in 81 %. A move that is too
 * small for an alarm is followed instead. Do not choose matches by the calibration that is
 * under test: search a band of several pixels about the line, or track points.
 *
 * A move or a walk of a camera is a turn about its own centre, and a shift of this centre.
 * The rig may have its origin anywhere: apart from rounding, a monitor says the same. In
 * float, with the cameras 1 to 3 apart, an origin at 12 changed poses by 0.003 of their
 * standard deviations, and an origin at 1000 by 0.3. A target turns about its own origin,
 * and may shift farther than move_t: by a tenth of move_rad times its distance from the
 * frame.
 *
 * EQUATIONS.md MONITOR has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_MONITOR_H
#define RIGCAL_MONITOR_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== memory ================================================================= */

/* A monitor is an array of reals that the caller owns, `monitor` in every function. It
 * holds no pointer. It may be copied, and stored for a build of the same precision and
 * byte order. Memory that was not begun, or was altered since, is refused with ERR_STATE.
 * Every call checks the head; the first call after each frame checks the whole. */
enum rigcal_monitor_limits {
    RIGCAL_MONITOR_CAMERAS_MAX = 64,
    RIGCAL_MONITOR_TARGETS_MAX = 16,
    RIGCAL_MONITOR_HEAD = 48,  /* reals of a monitor at most, besides those of its bodies */
    RIGCAL_MONITOR_BODY = 179, /* reals of a body: pose, and evidence of a move */
    RIGCAL_MONITOR_LENS = 15   /* reals of a camera's intrinsics at most */
};

/* Reals of a monitor of n_cameras >= 2 cameras that see up to n_targets at a time. In
 * float and without targets, 2 cameras take 1876 bytes, 4 cameras 4124, 8 cameras 10348;
 * 60 bytes of each camera are its intrinsics. The function returns 0 for counts that are
 * out of range. */
#define RIGCAL_MONITOR_UNKNOWNS(n_cameras, n_targets) \
    (6 * ((size_t)(n_cameras) + (size_t)(n_targets)-1))
#define RIGCAL_MONITOR_SIZE(n_cameras, n_targets) \
    (RIGCAL_MONITOR_HEAD + RIGCAL_MONITOR_LENS * (size_t)(n_cameras) + \
     RIGCAL_MONITOR_BODY * ((size_t)(n_cameras) + (size_t)(n_targets)) + \
     RIGCAL_MONITOR_UNKNOWNS(n_cameras, n_targets) * \
         (RIGCAL_MONITOR_UNKNOWNS(n_cameras, n_targets) + 5) / 2)
RIGCAL_API size_t rigcal_monitor_size(size_t n_cameras, size_t n_targets);

/* ==== begin ================================================================== */

typedef struct rigcal_monitor_options {
    rigcal_real arl0_frames; /* mean number of frames between false alarms, 100 .. 1e9 /
                                1e9. Default 1e6. The alarm measures the noise by itself */
    rigcal_real common;      /* 0 .. 1: how far the matches of a frame have the same error.
                                0: errors are independent; 1: all are the same. Default 0.5,
                                for a lens model that is a little wrong where the matches
                                happen to be */
    rigcal_real wrong;       /* expected share of wrong matches, 0 .. 0.9. Default 0.1.
                                Values below 1e-5 count as 1e-5 */
    rigcal_real walk_rad;    /* random walk of each camera's rotation, in rad per square
                                root of a second, 0 .. 1. Default 0: none */
    rigcal_real walk_t;      /* the same of its centre, in lengths, 0 or more. Default 0 */
    rigcal_real move_rad;    /* the largest turn that is expected, in rad, > 0 .. 0.5.
                                Default 3 degrees */
    rigcal_real move_t;      /* the largest shift of a centre, > 0. 0: default, a tenth of
                                the mean distance of the cameras times move_rad */
} rigcal_monitor_options;

/* Writes all defaults. move_t is 0, because its default depends on the rig. OK,
 * ERR_NULL. */
RIGCAL_API rigcal_status rigcal_monitor_defaults(rigcal_monitor_options *options);

/* Begins with the poses and the joint covariance of a calibrated rig. All cameras must be
 * of one group, and at least one must be held.
 *
 *   monitor    out  capacity reals: RIGCAL_MONITOR_SIZE
 *   rig        in   n_cameras 2 .. RIGCAL_MONITOR_CAMERAS_MAX; copied
 *   n_targets  in   targets at a time, 0 .. RIGCAL_MONITOR_TARGETS_MAX
 *   options    in   NULL: all defaults
 *
 * OK; RIGCAL_DISCONNECTED (several groups; nothing is begun); ERR_NULL, ERR_NOT_FINITE,
 * ERR_CAMERA, ERR_ROTATION, ERR_RANGE (also: no camera is held, a negative variance),
 * ERR_CAPACITY, ERR_TOO_FEW (one camera), ERR_STATE (no joint covariance), ERR_DEGENERATE
 * (two cameras have one centre, and move_t is 0). O(n_cameras^2) */
RIGCAL_API rigcal_status rigcal_monitor_begin(rigcal_real monitor[], size_t capacity,
                                              const rigcal_calibrated_rig *rig,
                                              size_t n_targets,
                                              const rigcal_monitor_options *options);

/* ==== what is seen =========================================================== */

/* One point of the scene, at pixel uv_a of camera_a and uv_b of camera_b, gives one row
 * (M1). sigma_px: noise of one coordinate of a pixel, 1e-6 .. 1e6. The lens turns it into
 * an angle. A match that does not fit is weighed by the probability that it is right.
 *
 * OK; ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (also: no such camera, one camera twice),
 * ERR_STATE, ERR_NO_RAY (the lens images no ray there), ERR_DEGENERATE (the match lies on
 * the line through both centres, and carries no information). A failed call changes
 * nothing. O(n_bodies^2), and two lens inversions. */
RIGCAL_API rigcal_status rigcal_monitor_match(rigcal_real monitor[], size_t camera_a,
                                              const rigcal_real uv_a[2], size_t camera_b,
                                              const rigcal_real uv_b[2],
                                              rigcal_real sigma_px);

/* The same from the rays of the two pixels (of rigcal_camera_ray, or undistorted points
 * (x, y, 1)), of any length but 0. No lens is inverted. Also returns ERR_BEHIND. */
RIGCAL_API rigcal_status rigcal_monitor_match_rays(rigcal_real monitor[], size_t camera_a,
                                                   const rigcal_real ray_a[3],
                                                   size_t camera_b,
                                                   const rigcal_real ray_b[3],
                                                   rigcal_real sigma_px);

/* A camera sees a target: two rows for each point (M4). If the target has no place yet,
 * its pose is solved from this view of 3 points or more. Such a view places the target and
 * tells nothing about the cameras; the next views of the target do. A target keeps its
 * place until it is lifted. Lift a target that is carried about after each placement;
 * never lift one that stays.
 *
 *   observations  in  n: X_w in the frame of the target, uv [px]
 *   sigma_px      in  as above
 *   at_fault      out the index of the observation at fault, or -1
 *
 * OK. RIGCAL_AMBIGUOUS, RIGCAL_POOR_FIT, RIGCAL_VAGUE: the pose of a target without a
 * place is ambiguous, does not fit or is vague, and the target was not placed. Other
 * caveats of rigcal_pose_solve: the target was placed. ERR_NULL, ERR_NOT_FINITE,
 * ERR_RANGE, ERR_STATE (also: between an alarm and its answer no target gets a place),
 * ERR_TOO_FEW, ERR_BEHIND, ERR_NO_RAY and those of rigcal_pose_solve and
 * rigcal_pose_covariance. A failed call changes nothing. O(n n_bodies^2), and one pose if
 * the target has no place. */
RIGCAL_API rigcal_status rigcal_monitor_view(rigcal_real monitor[], int32_t *at_fault,
                                             size_t camera, size_t target,
                                             const rigcal_observation observations[],
                                             size_t n, rigcal_real sigma_px);

/* A target is carried away: it no longer has a place. OK, ERR_NULL, ERR_RANGE, ERR_STATE.
 * O(n_bodies) */
RIGCAL_API rigcal_status rigcal_monitor_lifted(rigcal_real monitor[], size_t target);

/* ==== the end of a frame, and what it says ==================================== */

typedef struct rigcal_monitor_report {
    int32_t alarm;          /* 1: an alarm was raised and has no answer yet */
    int32_t body;           /* the body that most likely moved; without an alarm, the one
                               with the largest part of the evidence */
    rigcal_real confidence; /* after an alarm, the probability that this body moved, if one
                               body did. It grows with the frames since. 0 without an
                               alarm */
    rigcal_real evidence;   /* logarithm of (evidence sum / its limit): 0 or more raises the
                               alarm */
    rigcal_real noise;      /* clipped rms of the rows, divided by that of normal noise as
                               stated. 1: the noise is as stated. 0: no row yet */
    rigcal_real
        smallest_rad;      /* the smallest turn that would have been noticed [rad], of the
                              body that is seen worst; 0: some body is blind */
    int32_t n_blind;       /* number of bodies with too few recent rows for a verdict */
    uint32_t frames;       /* frames since rigcal_monitor_begin */
    uint32_t rows;         /* rows taken since then; it wraps at 2^32, as frames do */
    uint32_t doubted;      /* of these rows, those that were more likely wrong than right */
    uint32_t frames_since; /* since the alarm, its own frame included; 0: no alarm */
} rigcal_monitor_report;

/* Ends a frame. It updates the poses by the frame's rows, adds the random walk of the
 * `seconds` since the last end (0 .. 1e6), and weighs the evidence. An alarm changes no
 * pose. From the alarm to its answer the poses rest, and the rows tell which body moved.
 * report NULL: not wanted.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_STATE. O(n_bodies^2) */
RIGCAL_API rigcal_status rigcal_monitor_frame(rigcal_monitor_report *report,
                                              rigcal_real monitor[], rigcal_real seconds);

/* The same report at any time. OK, ERR_NULL, ERR_STATE. O(n_bodies) */
RIGCAL_API rigcal_status rigcal_monitor_ask(rigcal_monitor_report *report,
                                            const rigcal_real monitor[]);

/* The report on one body. */
typedef struct rigcal_body_report {
    int32_t is_blind;         /* 1: fewer than 6 rows in the last 256 frames or so, or a
                                 target without a place. Then smallest_rad is 0. Without a
                                 place, share and blame are 0 too */
    rigcal_real share;        /* its part of the evidence, 0 .. 1; 0 after an alarm */
    rigcal_real blame;        /* after an alarm, the probability that this body moved */
    rigcal_real smallest_rad; /* the smallest turn that would have been noticed, about the
                                 axis that is seen worst [rad]; 0: none */
    rigcal_real
        weakest[6]; /* the direction in which its pose is known worst: a turn w about its
                       own centre, then a shift ds of X_b to X_b + ds. It has unit length if
                       lengths are in units of move_t / move_rad */
    rigcal_real weakest_sigma; /* its standard deviation [rad]. All are 0 if that unit of
                                  length is so small that its square is 0 */
} rigcal_body_report;

/* OK, ERR_NULL, ERR_RANGE (no such body), ERR_STATE. O(1): some 10 000 operations. */
RIGCAL_API rigcal_status rigcal_monitor_body(rigcal_body_report *report,
                                             const rigcal_real monitor[], size_t body);

/* ==== answers ================================================================ */

/* Says that a body moved. After an alarm, the body gets the pose that explains the rows
 * since the alarm best, with its covariance, and the alarm is over. Without an alarm, the
 * body's pose becomes uncertain by move_rad and move_t, and the next rows solve it. All
 * other bodies keep their poses and covariances.
 * OK, ERR_NULL, ERR_RANGE (no such body, a target without a place), ERR_STATE.
 * O(n_bodies^2) */
RIGCAL_API rigcal_status rigcal_monitor_moved(rigcal_real monitor[], size_t body);

/* Says that nothing moved: the alarm is over, and the poses are followed again. OK,
 * ERR_NULL, ERR_STATE (also: there is no alarm). O(n_bodies) */
RIGCAL_API rigcal_status rigcal_monitor_dismiss(rigcal_real monitor[]);

/* ==== where they are now ===================================================== */

/* A camera with its pose and covariance at the end of the last frame.
 * OK, ERR_NULL, ERR_RANGE, ERR_STATE. */
RIGCAL_API rigcal_status rigcal_monitor_camera(rigcal_mounted_camera *camera,
                                               const rigcal_real monitor[], size_t index);

/* b_from_a of two bodies, cameras or targets, and its covariance, cross terms included.
 * OK, ERR_NULL, ERR_RANGE (also: a target without a place), ERR_STATE. */
RIGCAL_API rigcal_status rigcal_monitor_pair(rigcal_transform *b_from_a,
                                             rigcal_real Sigma[36],
                                             const rigcal_real monitor[], size_t a,
                                             size_t b);

/* Writes all cameras with their joint covariance, for rigcal_store_save_rig. The caller
 * sets the arrays of rig and their capacities. The camera that is the frame is held.
 * sigma_px and F are those of rigcal_monitor_begin. OK, ERR_NULL, ERR_CAPACITY, ERR_STATE;
 * after an error nothing is written. O(n_cameras^2) */
RIGCAL_API rigcal_status rigcal_monitor_rig(rigcal_calibrated_rig *rig,
                                            const rigcal_real monitor[]);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_MONITOR_H */
