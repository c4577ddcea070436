/* rigcal_monitor.h - while a rig runs: has it moved, which camera, where is it now.
 * Included by rigcal.h, whose first page holds here too.
 *
 * A monitor begins with a calibrated rig. Frame by frame it takes what the cameras see:
 * matched points, views of a target that is carried about, and of one that stays. It
 * follows the poses of the cameras with their joint covariance, raises an alarm when one of
 * them has been bumped, and solves that one anew.
 *
 *   rigcal_monitor_begin    from a calibrated rig
 *   rigcal_monitor_match    two cameras see one point; _match_rays, its rays are known
 *   rigcal_monitor_view     a camera sees a target
 *   rigcal_monitor_frame    ends a frame: poses, evidence, alarm
 *   rigcal_monitor_moved    the answer to an alarm: this one did; _dismiss: none did
 *   rigcal_monitor_rig      what to keep of it, for rigcal_store_save_rig
 *
 * Bodies are numbered: the cameras 0 .. n_cameras - 1, then the targets, so that target k
 * is body n_cameras + k. One camera, the first that is held, is the frame: its pose stays,
 * and a move of it shows as one of all others.
 *
 * What it cannot see: with matches alone the length of a baseline, and the scale of a rig
 * of more cameras; with two cameras and matches alone, which of the two moved. A move that
 * is too small to be noticed is followed instead. Matches must not be chosen by the
 * calibration under test: search a band of several pixels about the line, or track.
 *
 * EQUATIONS.md MONITOR has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
#endif

#ifndef RIGCAL_MONITOR_H
#define RIGCAL_MONITOR_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== memory ================================================================= */

/* A monitor is an array of reals of the caller's, `monitor` in every function. It holds no
 * pointer: it may be copied and stored as it is, for a build of the same precision and byte
 * order. Memory that was not begun, or was altered since, is refused with ERR_STATE: its
 * head in every call, the whole in the first call after each frame. */
enum rigcal_monitor_limits {
    RIGCAL_MONITOR_CAMERAS_MAX = 64,
    RIGCAL_MONITOR_TARGETS_MAX = 16,
    RIGCAL_MONITOR_HEAD = 48,  /* reals of a monitor at most, besides those of its bodies */
    RIGCAL_MONITOR_BODY = 179, /* reals of a body: pose, and evidence of a move */
    RIGCAL_MONITOR_LENS = 15   /* reals of a camera's intrinsics at most */
};

/* Reals of a monitor of n_cameras, 2 or more, and of n_targets at a time. In float and
 * without targets: 2 cameras 1876 bytes, 4 cameras 4124, 8 cameras 10348; 60 bytes of each
 * camera are its intrinsics. The function gives 0 for counts that are out of range. */
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
                                1e9. Default 1e6. No noise is asked for: the alarm measures
                                what it needs of it */
    rigcal_real common;      /* 0 .. 1: how far the matches of a frame err together. 0: by
                                themselves; 1: all alike. Default 0.5, for a lens model that
                                is a little wrong where the matches happen to be */
    rigcal_real wrong;       /* share of wrong matches expected, 0 .. 0.9. Default 0.1.
                                Below 1e-5 it is that */
    rigcal_real walk_rad;    /* random walk of each camera: rad, and lengths, per square */
    rigcal_real walk_t;      /* root of a second, 0 .. 1 and 0 or more. Default 0: none */
    rigcal_real move_rad;    /* the largest move thought possible: rad, > 0 .. 0.5 */
    rigcal_real move_t;      /* and length, > 0. Defaults: 3 degrees, and a tenth of the
                                mean distance of the cameras times move_rad; 0: default */
} rigcal_monitor_options;

/* Writes all defaults. move_t is 0, because its default depends on the rig. OK,
 * ERR_NULL. */
RIGCAL_API rigcal_status rigcal_monitor_defaults(rigcal_monitor_options *options);

/* Begins with the poses and the joint covariance of a calibrated rig, all cameras of one
 * group, one of them held or more.
 *
 *   monitor    out  capacity reals: RIGCAL_MONITOR_SIZE
 *   rig        in   n_cameras 2 .. RIGCAL_MONITOR_CAMERAS_MAX; copied
 *   n_targets  in   at a time, 0 .. RIGCAL_MONITOR_TARGETS_MAX
 *   options    in   NULL: all defaults
 *
 * OK; RIGCAL_DISCONNECTED (several groups), nothing is begun then; ERR_NULL,
 * ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE (also: no camera is held, a negative
 * variance), ERR_CAPACITY, ERR_TOO_FEW (one camera), ERR_STATE (no joint covariance),
 * ERR_DEGENERATE (two cameras have one centre, and move_t is 0). O(n_cameras^2) */
RIGCAL_API rigcal_status rigcal_monitor_begin(rigcal_real monitor[], size_t capacity,
                                              const rigcal_calibrated_rig *rig,
                                              size_t n_targets,
                                              const rigcal_monitor_options *options);

/* ==== what is seen =========================================================== */

/* One point of the scene at pixel uv_a of camera_a and uv_b of camera_b: one row (M1).
 * sigma_px: noise of one coordinate of a pixel, 1e-6 .. 1e6; what it is in angles follows
 * from the lens. A match that does not fit counts as much as it is likely to be right.
 *
 * OK; ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (also: no such camera, one camera twice),
 * ERR_STATE, ERR_NO_RAY (the lens images no ray there), ERR_DEGENERATE (the match lies on
 * the line through both centres, and says nothing). A failed call changes nothing.
 * O(n_bodies^2), and two lens inversions. */
RIGCAL_API rigcal_status rigcal_monitor_match(rigcal_real monitor[], size_t camera_a,
                                              const rigcal_real uv_a[2], size_t camera_b,
                                              const rigcal_real uv_b[2],
                                              rigcal_real sigma_px);

/* The same by the rays of the two pixels (rigcal_camera_pixel_to_ray, or undistorted points
 * (x, y, 1)), of any length but 0: no lens is inverted. ERR_BEHIND also. */
RIGCAL_API rigcal_status rigcal_monitor_match_rays(rigcal_real monitor[], size_t camera_a,
                                                   const rigcal_real ray_a[3],
                                                   size_t camera_b,
                                                   const rigcal_real ray_b[3],
                                                   rigcal_real sigma_px);

/* A camera sees a target: two rows a point (M4). Of a target without a place the pose is
 * solved from this view, 3 points or more, which says where it is and nothing else; the
 * next views of it do. A target is in one place until it is lifted: one that is carried
 * about is lifted after each placement, one that stays never is.
 *
 *   observations  in  n: X_w in the frame of the target, uv [px]
 *   sigma_px      in  as above
 *   at_fault      out the observation that an error is of, or -1
 *
 * OK; RIGCAL_AMBIGUOUS, RIGCAL_POOR_FIT: the pose of a target without a place may be
 * another, or does not fit, and it was not placed; the other caveats of rigcal_pose_solve,
 * with which it was placed; ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_STATE (also: between
 * an alarm and its answer no target gets a place), ERR_TOO_FEW, ERR_BEHIND, ERR_NO_RAY and
 * those of rigcal_pose_solve and rigcal_pose_covariance. A failed call changes nothing. O(n
 * n_bodies^2), and for a target without a place one pose. */
RIGCAL_API rigcal_status rigcal_monitor_view(rigcal_real monitor[], int32_t *at_fault,
                                             size_t camera, size_t target,
                                             const rigcal_observation observations[],
                                             size_t n, rigcal_real sigma_px);

/* A target is carried away: it has no place any more. OK, ERR_NULL, ERR_RANGE, ERR_STATE.
 * O(n_bodies) */
RIGCAL_API rigcal_status rigcal_monitor_lifted(rigcal_real monitor[], size_t target);

/* ==== the end of a frame, and what it says ==================================== */

typedef struct rigcal_monitor_report {
    int32_t alarm;          /* 1: raised, and not yet answered */
    int32_t body;           /* the likeliest to have moved; without an alarm, the one with
                                 the largest part of the evidence */
    rigcal_real confidence; /* after an alarm, the probability that it was this one, if it
                                 was one: grows with the frames since. 0 without an alarm */
    rigcal_real evidence;   /* log of the sum over its limit: 0 or more raises the alarm */
    rigcal_real noise;      /* rms of what rows differ by, clipped, over that of normal
                                 noise as stated: 1 is as stated. 0: no row yet */
    rigcal_real
        smallest_rad;      /* the turn of the body that is seen worst that would have been
                                 noticed [rad]; 0: there is a blind body */
    int32_t n_blind;       /* bodies with too few recent rows to say anything */
    uint32_t frames;       /* since the begin */
    uint32_t rows;         /* taken since the begin; it wraps at 2^32, as frames do */
    uint32_t doubted;      /* of them those that were more likely wrong than right */
    uint32_t frames_since; /* since the alarm, that one included; 0 without */
} rigcal_monitor_report;

/* Ends a frame: takes what its rows say into the poses, adds the walk of `seconds` since
 * the last end, 0 .. 1e6, and weighs the evidence. An alarm only reports. From the alarm to
 * its answer the poses rest, and the rows tell which body it was. report NULL: not wanted.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_STATE. O(n_bodies^2) */
RIGCAL_API rigcal_status rigcal_monitor_frame(rigcal_monitor_report *report,
                                              rigcal_real monitor[], rigcal_real seconds);

/* The same report at any time. OK, ERR_NULL, ERR_STATE. O(n_bodies) */
RIGCAL_API rigcal_status rigcal_monitor_ask(rigcal_monitor_report *report,
                                            const rigcal_real monitor[]);

/* What is to be said of one body. */
typedef struct rigcal_body_report {
    int32_t is_blind;         /* 1: fewer than 6 rows in the last 256 frames or so, or a
                                 target without a place. The next four are then 0, but
                                 weakest and weakest_sigma, which hold */
    rigcal_real share;        /* its part of the evidence, 0 .. 1 */
    rigcal_real blame;        /* after an alarm, the probability that it was this one */
    rigcal_real smallest_rad; /* the smallest turn that would have been noticed, about the
                                 axis that is seen worst [rad]; 0: none */
    rigcal_real
        weakest[6]; /* the direction (w, dt) of its pose that is known worst, lengths
                                 in units of move_t / move_rad: unit length */
    rigcal_real weakest_sigma; /* its standard deviation [rad] */
} rigcal_body_report;

/* OK, ERR_NULL, ERR_RANGE (no such body), ERR_STATE. O(1): some 10 000 operations. */
RIGCAL_API rigcal_status rigcal_monitor_body(rigcal_body_report *report,
                                             const rigcal_real monitor[], size_t body);

/* ==== answers ================================================================ */

/* A body moved. After an alarm: its pose is the one that the rows since explain best, with
 * what they left open, and the alarm is over. Without one: its pose is open by move_rad and
 * move_t, and the next rows solve it. All others are held by what is known of them.
 * OK, ERR_NULL, ERR_RANGE (no such body, a target without a place), ERR_STATE.
 * O(n_bodies^2) */
RIGCAL_API rigcal_status rigcal_monitor_moved(rigcal_real monitor[], size_t body);

/* Nothing moved: the alarm is over, the poses are followed again. OK, ERR_NULL, ERR_STATE
 * (also: there is no alarm). O(n_bodies) */
RIGCAL_API rigcal_status rigcal_monitor_dismiss(rigcal_real monitor[]);

/* ==== where they are now ===================================================== */

/* A camera with its pose and its covariance of now, of the last frame's end.
 * OK, ERR_NULL, ERR_RANGE, ERR_STATE. */
RIGCAL_API rigcal_status rigcal_monitor_camera(rigcal_mounted_camera *camera,
                                               const rigcal_real monitor[], size_t index);

/* b_from_a of two bodies, and its covariance, cross terms included; targets among them.
 * OK, ERR_NULL, ERR_RANGE (also: a target without a place), ERR_STATE. */
RIGCAL_API rigcal_status rigcal_monitor_pair(rigcal_transform *b_from_a,
                                             rigcal_real Sigma[36],
                                             const rigcal_real monitor[], size_t a,
                                             size_t b);

/* All cameras with their joint covariance, for rigcal_store_save_rig. rig has its arrays
 * and their capacities; the camera that is the frame is held. sigma_px and F are those of
 * the begin. OK, ERR_NULL, ERR_CAPACITY, ERR_STATE; nothing is written then. O(n_cameras^2)
 * */
RIGCAL_API rigcal_status rigcal_monitor_rig(rigcal_calibrated_rig *rig,
                                            const rigcal_real monitor[]);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_MONITOR_H */
