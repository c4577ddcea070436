/* rigcal_faults.h - why the views of a rig disagree. Included by rigcal.h, whose first page
 * holds here too.
 *
 * Each view may fit by itself while the rig does not fit them all. Then the loop closure F
 * of rigcal_rig_fit is large. A fault is one possible reason: a late clock, a wrong focal
 * length, a bent board. Each fault is tested by itself, without a new adjustment. The test
 * adds the fault's parameters to the unknowns of the adjustment. One step then shows how
 * large the fault is, and how much of the sum of squares it explains.
 *
 *   rigcal_rig_faults    after rigcal_rig_adjust: tests all faults, and sorts them, the
 *                        likeliest first
 *   rigcal_faults_text   says in sentences what was found
 *
 * A fault concerns the whole rig; rigcal_judge.h finds single views that are wrong. Test
 * for faults first, with all views. If a fault explains the disagreement, no view is
 * wrong.
 *
 * EQUATIONS.md FAULTS has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_FAULTS_H
#define RIGCAL_FAULTS_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== faults ================================================================= */

/* What may be wrong. Each comment begins with the number n of parameters. The faults up to
 * MOVED, except CLOCKS, concern one camera. */
enum rigcal_fault_kinds {
    RIGCAL_FAULT_CLOCK = 0,   /* 1: its pictures are later than their stamps by this time */
    RIGCAL_FAULT_DRIFT = 1,   /* 1: the same lateness grows by this in a unit of time; it is
                                 0 at the middle of `times` */
    RIGCAL_FAULT_CLOCKS = 2,  /* one CLOCK for each camera but the first of each group */
    RIGCAL_FAULT_SHUTTER = 3, /* 1: the last row is later than the first by this time. The
                                 middle row is at the stamp */
    RIGCAL_FAULT_FOCAL = 4,   /* 1: fx and fy are larger by this part */
    RIGCAL_FAULT_ASPECT = 5,  /* 1: fx / fy is larger by this part */
    RIGCAL_FAULT_CENTRE = 6,  /* 2: cx and cy are larger [px] */
    RIGCAL_FAULT_DISTORTION = 7, /* 2: k1 and k2 are larger */
    RIGCAL_FAULT_MOVED = 8,      /* 6: from a placement on, cam_from_rig differs by this (w,
                                    dt) */
    RIGCAL_FAULT_BENT = 9,       /* 2: the board has Z = a (1 - x^2) + b (1 - y^2), x and y
                                    in -1 .. 1 over its points; a and b [length] */
    RIGCAL_FAULT_STRETCHED = 10, /* 1: the board's X is longer than its Y by this part */
    RIGCAL_FAULT_KINDS = 11
};

/* In rigcal_faults_options.kinds: one kind; all kinds. */
#define RIGCAL_FAULTS_OF(kind) ((int32_t)1 << (kind))
#define RIGCAL_FAULTS_ALL (RIGCAL_FAULTS_OF(RIGCAL_FAULT_KINDS) - 1)

/* DEVIATIONS: a fault of this many standard deviations is found in nine of ten rigs. */
enum rigcal_fault_limits { RIGCAL_FAULT_DEVIATIONS = 5, RIGCAL_FAULT_VALUES = 6 };

typedef struct rigcal_fault {
    int32_t kind;      /* RIGCAL_FAULT_ */
    int32_t camera;    /* the camera that has it; -1: the fault is of the board, or
                          CLOCKS */
    int32_t placement; /* for MOVED, the first placement after the move; else -1 */
    int32_t n;         /* parameters */
    int32_t is_seen;   /* 0: this recording cannot show it, and all numbers below are 0 */
    int32_t explains;  /* 1: with the fault removed, F is not significant (0.001), or F - 1
                          is at most half as large */
    /* Size of the fault, and its standard deviation. CLOCKS of more: the first six. */
    rigcal_real value[RIGCAL_FAULT_VALUES], sigma[RIGCAL_FAULT_VALUES];
    rigcal_real gain;    /* removing the fault lowers the sum of squares by this [px^2] */
    rigcal_real p;       /* the chance that noise alone gives that gain. For MOVED, it is
                            multiplied by the number of placements that were tried; at most
                            1 */
    rigcal_real bic;     /* Schwarz's criterion, minus that of a rig without faults: the
                            least is best */
    rigcal_real F_after; /* F with the fault removed */
    rigcal_real turn, shift; /* its effect on the rig: how far a camera turns [rad] and
                                shifts [length] at most, when one parameter is
                                RIGCAL_FAULT_DEVIATIONS sigma */
} rigcal_fault;

/* ==== the verdict ============================================================ */

enum rigcal_faults_verdicts {
    RIGCAL_RIG_AGREES = 0,     /* F is not significant (0.001) */
    RIGCAL_RIG_EXPLAINED = 1,  /* F is significant. The first fault was found, and explains
                                  it */
    RIGCAL_RIG_FOUND = 2,      /* F is significant. The first fault was found, but does not
                                  explain it */
    RIGCAL_RIG_UNEXPLAINED = 3 /* F is significant. No fault was found */
};

/* Of rigcal_faults.bits. */
enum rigcal_faults_bits {
    RIGCAL_FAULTS_NAMED = 1,   /* the first fault was found. It may be set where the rig
                                  agrees, too */
    RIGCAL_FAULTS_PATTERN = 2, /* `pattern` is over 0.1 and over 4 pattern_sigma */
    RIGCAL_FAULTS_ALONG_MOTION = 4,  /* `along` is over 0.3, and there is no pattern */
    RIGCAL_FAULTS_ALIKE = 8,         /* the data are explained nearly as well by other
                                        faults */
    RIGCAL_FAULTS_NO_TIMES = 16,     /* clocks were not tested, because no times are
                                        known */
    RIGCAL_FAULTS_NO_NEIGHBOUR = 32, /* clocks were not tested, because no placement has a
                                        neighbour in time */
    RIGCAL_FAULTS_NO_MOTION = 64,    /* the target stood still: a clock off by a whole frame
                                        would not have been found */
    RIGCAL_FAULTS_TWO_CAMERAS = 128, /* there are two cameras, and nothing says which one is
                                        late or moved */
    RIGCAL_FAULTS_NO_LOOP = 256 /* the views have nothing in common to disagree about */
};

typedef struct rigcal_faults {
    int32_t verdict; /* RIGCAL_RIG_ */
    int32_t bits;    /* RIGCAL_FAULTS_ */
    int32_t n;       /* faults written, the likeliest first; those that are not seen last */
    int32_t n_alike; /* number of faults after the first that fit nearly as well: bic within
                        9.2 */
    int32_t n_seen;  /* number of faults that could be seen. The first is found if p n_seen
                        is below 0.01 */
    int32_t n_cameras, passes;                      /* cameras of the rig; passes over all
                                                       views */
    rigcal_real F, freedom_between, freedom_within; /* as in rigcal_rig_fit, except that the
                                                       views' own sums are approximated to
                                                       second order */
    rigcal_real sigma_px;               /* noise from the whole rig: sqrt(sum / freedom) */
    rigcal_real own_px;                 /* noise from the views' own fits */
    rigcal_real explained;              /* part of F - 1 that the first fault explains */
    rigcal_real pattern, pattern_sigma; /* correlation of the residuals of neighbouring
                                           points. For noise alone it is 0, with this
                                           standard deviation */
    rigcal_real along;         /* part of the disagreement along the target's motion. For
                                  noise alone it is 1 / 6. 0: no motion is known */
    rigcal_real along_time;    /* standard deviation of single stamps that would cause it */
    rigcal_real frame;         /* time from one frame to the next; 0: not known */
    const rigcal_real *clocks; /* rigcal_faults_options.clocks */
} rigcal_faults;

/* ==== the test =============================================================== */

/* Set it to zero, then fill in what there is. */
typedef struct rigcal_faults_options {
    int32_t kinds;         /* the sum of RIGCAL_FAULTS_OF for each kind to test; 0: all
                              kinds */
    int32_t is_truncated;  /* 1: points beyond 4 sigma_i sigma_px do not count, as after
                              rigcal_rig_adjust_robust */
    const uint8_t *breaks; /* n_placements; not 0: a camera may have moved just before that
                              placement. NULL: before any */
    rigcal_real *clocks;   /* NULL, or 2 n_cameras, written: the value that CLOCKS gives
                              each camera, then the sigma of each; 0 for a camera that is
                              not freed */
    rigcal_real *work;     /* memory to work in, */
    size_t work_capacity;  /* and its number of reals: RIGCAL_FAULTS_WORK */
} rigcal_faults_options;

/* Reals of `work`, for n_cameras of which n_free are free or have a prior. With this many
 * there are at most two passes over the views. With fewer, down to RIGCAL_FAULTS_LEAST,
 * there are more passes with the same results. Both also exist as functions. In float 1.4,
 * 4.5 and 16 KB for 2, 4 and 8 cameras of which one is held. */
#define RIGCAL_FAULTS_WORK(n_free, n_cameras) \
    ((size_t)(n_cameras) * (54 * (size_t)(n_free) + 97 + (size_t)(n_cameras) / 2) + \
     24 * (size_t)(n_free) + 32)
#define RIGCAL_FAULTS_LEAST(n_free, n_cameras) \
    ((size_t)(n_cameras) * (18 * (size_t)(n_cameras) + 50) + 78 * (size_t)(n_free) + 64)

/* Reals that are needed in addition to either, if the adjustment freed clocks. */
#define RIGCAL_FAULTS_CLOCKS_WORK(n_cameras) \
    ((size_t)(n_cameras) * (30 * (size_t)(n_cameras) + 36))
RIGCAL_API size_t rigcal_faults_work(size_t n_free, size_t n_cameras);
RIGCAL_API size_t rigcal_faults_least(size_t n_free, size_t n_cameras);

typedef struct rigcal_faults_solver rigcal_faults_solver; /* see rigcal_solvers.h */

/* Tests an adjusted rig for all faults. The rig does not change, except in the unused part
 * of rig->work: its covariance stays.
 *
 *   found     out     the verdict
 *   faults    out     the first `capacity` of them, the likeliest first; others are
 *             dropped
 *   at_fault  out     the number of a view, or -1; NULL: not wanted
 *   options   in
 *   rig       in      adjusted, with views. With rig->clocks, times are known
 *
 * The faults are those of EQUATIONS.md (H4), the test is (H5) to (H9). The test cannot see
 * the target's scale, an offset that all clocks have in common, or which of two cameras is
 * late.
 *
 * With rig->clocks, the noise of stamps is the sigma_time of the adjustment (H11). Clocks
 * that the adjustment freed are free here too. Then CLOCK and CLOCKS are not seen, nor is
 * DRIFT if drifts were freed.
 *
 * OK, ERR_NULL, ERR_RANGE (capacity is 0, kinds, is_truncated without sigma_px), ERR_STATE
 * (the rig is not adjusted), ERR_CAPACITY (work), and what rigcal_rig_adjust returns for
 * views. Each pass evaluates each view once. The whole costs about as much as 5
 * evaluations of rigcal_rig_adjust. */
RIGCAL_API rigcal_status rigcal_rig_faults(rigcal_faults *found, rigcal_fault faults[],
                                           size_t capacity, int32_t *at_fault,
                                           const rigcal_faults_options *options,
                                           rigcal_rig *rig);

/* The same in steps. A unit is one view's equations, O(n); one placement's elimination, or
 * one fault's test, O(n_cameras^2). The budgets do not change one bit of the result. All
 * that is handed in must last. */
RIGCAL_API rigcal_status rigcal_faults_begin(rigcal_faults_solver *solver,
                                             rigcal_fault faults[], size_t capacity,
                                             const rigcal_faults_options *options,
                                             rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_faults_step(rigcal_faults_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_faults_result(rigcal_faults *found, int32_t *at_fault,
                                              const rigcal_faults_solver *solver);

/* ==== in words =============================================================== */

/* Names and units for the sentences. Set it to zero, then fill in what there is. */
typedef struct rigcal_faults_words {
    const char *const *names; /* n_cameras; NULL: "camera 0" and so on */
    const char *length;       /* the unit to print lengths in; NULL: "units" */
    const char *time;         /* the unit of times; NULL: "s" */
    rigcal_real length_scale; /* how many of that unit make one of the caller's: 1000 to
                                 print mm where coordinates are in m. 0: 1 */
    rigcal_real time_scale;   /* like length_scale, for times */
    int32_t with_unseen;      /* 1: the text also says, fault by fault, what could have been
                                 found */
} rigcal_faults_words;

/* Writes what was found as plain sentences in ASCII. The last ones say what to do next. A
 * space divides sentences; each step of the verdict has a line of its own. `text` gets as
 * many whole sentences as it has room for, and a 0 at the end. *n_needed, if not NULL,
 * gets the size that all of them take.
 * OK; ERR_CAPACITY: not all of them fit. A capacity of 0 asks for the size. ERR_NULL.
 * ERR_NOT_FINITE, ERR_RANGE: the input is no result of rigcal_rig_faults, and nothing is
 * written. */
RIGCAL_API rigcal_status rigcal_faults_text(char text[], size_t capacity, size_t *n_needed,
                                            const rigcal_faults *found,
                                            const rigcal_fault faults[],
                                            const rigcal_faults_words *words);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_FAULTS_H */
