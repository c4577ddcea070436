/* rigcal_faults.h - why the views of a rig disagree. Included by rigcal.h, whose first page
 * holds here too.
 *
 * Views may fit by themselves while the rig does not fit them: the loop closure F of
 * rigcal_rig_fit is large. A fault is one thing that may be the reason: a clock, a wrong
 * focal length, a bent board. Each fault is tested by itself, without adjusting again. It
 * is freed in the equations of the adjustment, and one step tells how large it is, and how
 * much of the sum of squares it explains.
 *
 *   rigcal_rig_faults    after rigcal_rig_adjust: all faults, the likeliest first
 *   rigcal_faults_text   what was found, in sentences
 *
 * Faults are of the whole rig; rigcal_judge.h finds single views that are wrong. Test for
 * faults first, with all views: where one explains, no view is wrong.
 *
 * EQUATIONS.md FAULTS has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
#endif

#ifndef RIGCAL_FAULTS_H
#define RIGCAL_FAULTS_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== faults ================================================================= */

/* What may be wrong, and its parameters: n of them. Up to MOVED they are of one camera. */
enum rigcal_fault_kinds {
    RIGCAL_FAULT_CLOCK = 0,   /* 1: by how much its pictures are later than their stamps */
    RIGCAL_FAULT_DRIFT = 1,   /* 1: the same, a unit of time after the middle of `times` */
    RIGCAL_FAULT_CLOCKS = 2,  /* CLOCK of all cameras but the first of each group */
    RIGCAL_FAULT_SHUTTER = 3, /* 1: by how much the last row is later than the first. The
                                    middle row is at the stamp */
    RIGCAL_FAULT_FOCAL = 4,   /* 1: fx and fy are larger by this part */
    RIGCAL_FAULT_ASPECT = 5,  /* 1: fx / fy is larger by this part */
    RIGCAL_FAULT_CENTRE = 6,  /* 2: cx and cy are larger [px] */
    RIGCAL_FAULT_DISTORTION = 7, /* 2: k1 and k2 are larger */
    RIGCAL_FAULT_MOVED = 8,      /* 6: (w, dt), by which cam_from_rig differs from a
                                    placement on */
    RIGCAL_FAULT_BENT = 9,       /* 2: the board has Z = a (1 - x^2) + b (1 - y^2), x and y
                                    in -1 .. 1 over its points; a and b [length] */
    RIGCAL_FAULT_STRETCHED = 10, /* 1: the board's X is longer than its Y by this part */
    RIGCAL_FAULT_KINDS = 11
};

/* In rigcal_faults_options.kinds: one kind; all kinds. */
#define RIGCAL_FAULTS_OF(kind) ((int32_t)1 << (kind))
#define RIGCAL_FAULTS_ALL (RIGCAL_FAULTS_OF(RIGCAL_FAULT_KINDS) - 1)

/* DEVIATIONS: a fault as large as this number of its standard deviations is found in nine
 * of ten rigs. */
enum rigcal_fault_limits { RIGCAL_FAULT_DEVIATIONS = 5, RIGCAL_FAULT_VALUES = 6 };

typedef struct rigcal_fault {
    int32_t kind;      /* RIGCAL_FAULT_ */
    int32_t camera;    /* whose; -1: of the board, or CLOCKS */
    int32_t placement; /* of MOVED the first after it; else -1 */
    int32_t n;         /* parameters */
    int32_t is_seen;   /* 0: this recording cannot show it, and all numbers below are 0 */
    int32_t explains;  /* 1: without it F is not significant (0.001), or F - 1 is at most
                          half as large */
    rigcal_real value[RIGCAL_FAULT_VALUES], sigma[RIGCAL_FAULT_VALUES]; /* how large it is,
                          and its standard deviation. CLOCKS of more: the first six */
    rigcal_real gain;    /* the sum of squares falls by this without it [px^2] */
    rigcal_real p;       /* chance of that gain from noise alone. MOVED: times the number
                             of placements that were tried, at most 1 */
    rigcal_real bic;     /* Schwarz's criterion, less that of no fault: the least is best */
    rigcal_real F_after; /* F without it */
    rigcal_real turn, shift; /* what it does to the rig when each parameter alone is
                                RIGCAL_FAULT_DEVIATIONS sigma large: how far a camera turns
                                [rad] and shifts [length], at most */
} rigcal_fault;

/* ==== the verdict ============================================================ */

enum rigcal_faults_verdicts {
    RIGCAL_RIG_AGREES = 0,     /* F is not significant (0.001) */
    RIGCAL_RIG_EXPLAINED = 1,  /* F is; the first fault was found, and explains */
    RIGCAL_RIG_FOUND = 2,      /* F is; the first fault was found, and is not the reason */
    RIGCAL_RIG_UNEXPLAINED = 3 /* F is; no fault was found */
};

/* Of rigcal_faults.bits. */
enum rigcal_faults_bits {
    RIGCAL_FAULTS_NAMED = 1,   /* the first fault was found. Also where the rig agrees */
    RIGCAL_FAULTS_PATTERN = 2, /* `pattern` is over 0.1 and over 4 pattern_sigma */
    RIGCAL_FAULTS_ALONG_MOTION = 4,  /* `along` is over 0.3, and there is no pattern */
    RIGCAL_FAULTS_ALIKE = 8,         /* other faults fit nearly as well as the first */
    RIGCAL_FAULTS_NO_TIMES = 16,     /* clocks were not tested: no times are known */
    RIGCAL_FAULTS_NO_NEIGHBOUR = 32, /* the same: no placement has a neighbour in time */
    RIGCAL_FAULTS_NO_MOTION = 64,    /* the target stood still: a clock off by a whole frame
                                        would not have been found */
    RIGCAL_FAULTS_TWO_CAMERAS = 128, /* of two cameras, nothing says which one is late, or
                                        which one moved */
    RIGCAL_FAULTS_NO_LOOP = 256 /* the views have nothing in common to disagree about */
};

typedef struct rigcal_faults {
    int32_t verdict; /* RIGCAL_RIG_ */
    int32_t bits;    /* RIGCAL_FAULTS_ */
    int32_t n;       /* faults written, the likeliest first; those that are not seen last */
    int32_t n_alike; /* how many behind the first fit nearly as well: bic within 9.2 */
    int32_t n_seen;  /* faults that could be seen. The first is found where p n_seen is
                        below 0.01 */
    int32_t n_cameras, passes;                      /* of the rig; over all views */
    rigcal_real F, freedom_between, freedom_within; /* as of rigcal_rig_fit, but that the
                                                       views' sums are of second order */
    rigcal_real sigma_px;               /* noise by the rig: sqrt(sum / freedom), */
    rigcal_real own_px;                 /* and by each view alone */
    rigcal_real explained;              /* part of F - 1 that the first fault explains */
    rigcal_real pattern, pattern_sigma; /* correlation of the residuals of neighbouring
                                           points; of noise it is 0, with this deviation */
    rigcal_real along;         /* part of the disagreement along the target's motion; of
                                  noise 1 / 6. 0: no motion is known */
    rigcal_real along_time;    /* standard deviation of single stamps that would do that */
    rigcal_real frame;         /* from one frame to the next; 0: not known */
    const rigcal_real *clocks; /* rigcal_faults_options.clocks */
} rigcal_faults;

/* ==== the test =============================================================== */

/* Set it to zero, then what is there. */
typedef struct rigcal_faults_options {
    int32_t kinds;         /* RIGCAL_FAULTS_OF, added, of what is to be tested; 0: all */
    int32_t is_truncated;  /* 1: points beyond 4 sigma_i sigma_px do not count, as after
                              rigcal_rig_adjust_robust */
    const uint8_t *breaks; /* n_placements, or NULL: all; not 0: a camera may have moved
                              just before that one */
    rigcal_real *clocks;   /* 2 n_cameras, or NULL: written, of CLOCKS the value of each
                              camera, then the sigma of each; 0 of one that is not freed */
    rigcal_real *work;     /* memory to work in, */
    size_t work_capacity;  /* and its number of reals: RIGCAL_FAULTS_WORK */
} rigcal_faults_options;

/* Reals to work in, for cameras that are free or have a prior, and all. With these there
 * are at most two passes over the views. With fewer there are more, and the same results:
 * down to RIGCAL_FAULTS_LEAST. The same as functions. In float 1.4, 4.5 and 16 KB
 * for 2, 4 and 8 cameras of which one is held. */
#define RIGCAL_FAULTS_WORK(n_free, n_cameras) \
    ((size_t)(n_cameras) * (54 * (size_t)(n_free) + 97 + (size_t)(n_cameras) / 2) + \
     24 * (size_t)(n_free) + 32)
#define RIGCAL_FAULTS_LEAST(n_free, n_cameras) \
    ((size_t)(n_cameras) * (18 * (size_t)(n_cameras) + 50) + 78 * (size_t)(n_free) + 64)

/* Reals beyond either, where the adjustment freed clocks. */
#define RIGCAL_FAULTS_CLOCKS_WORK(n_cameras) \
    ((size_t)(n_cameras) * (30 * (size_t)(n_cameras) + 36))
RIGCAL_API size_t rigcal_faults_work(size_t n_free, size_t n_cameras);
RIGCAL_API size_t rigcal_faults_least(size_t n_free, size_t n_cameras);

typedef struct rigcal_faults_solver rigcal_faults_solver; /* see rigcal_solvers.h */

/* Tests an adjusted rig. Nothing of it changes but what is free in its memory to work in:
 * its covariance stays.
 *
 *   found     out     the verdict
 *   faults    out     `capacity` of them, the likeliest first: the others are lost
 *   at_fault  out     the number of a view, or -1; NULL: not asked
 *   options   in
 *   rig       in      adjusted, with views. With rig->clocks, times are known
 *
 * The faults are those of EQUATIONS.md (H4), the test is (H5) to (H9). The target's scale,
 * one offset common to all clocks, and which of two cameras is late, are not to be seen.
 *
 * With rig->clocks the noise of stamps, sigma_time, is that of the adjustment (H11). Clocks
 * that it freed are free here too: CLOCK and CLOCKS are then not seen, nor is DRIFT where
 * drifts were freed.
 *
 * OK, ERR_NULL, ERR_RANGE (capacity is 0, kinds, is_truncated without sigma_px), ERR_STATE
 * (the rig is not adjusted), ERR_CAPACITY (work), and of views those of rigcal_rig_adjust.
 * It evaluates each view once a pass, and costs about as much as 5 evaluations of
 * rigcal_rig_adjust. */
RIGCAL_API rigcal_status rigcal_rig_faults(rigcal_faults *found, rigcal_fault faults[],
                                           size_t capacity, int32_t *at_fault,
                                           const rigcal_faults_options *options,
                                           rigcal_rig *rig);

/* The same in steps. A unit is one view's equations, O(n); one placement's elimination, or
 * one fault's test, O(n_cameras^2). The same bits whatever the budgets. All that is handed
 * in must last. */
RIGCAL_API rigcal_status rigcal_faults_begin(rigcal_faults_solver *solver,
                                             rigcal_fault faults[], size_t capacity,
                                             const rigcal_faults_options *options,
                                             rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_faults_step(rigcal_faults_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_faults_result(rigcal_faults *found, int32_t *at_fault,
                                              const rigcal_faults_solver *solver);

/* ==== in words =============================================================== */

/* What the sentences call things. Set it to zero, then what is there. */
typedef struct rigcal_faults_words {
    const char *const *names; /* n_cameras; NULL: "camera 0" and so on */
    const char *length;       /* the unit to print lengths in; NULL: "units" */
    const char *time;         /* of times; NULL: "s" */
    rigcal_real length_scale; /* of that unit in one of the caller's: 1000 for mm where
                                 coordinates are in m. 0: 1 */
    rigcal_real time_scale;   /* the same of times */
    int32_t with_unseen;      /* 1: and what could have been found, fault by fault */
} rigcal_faults_words;

/* What was found, in plain sentences, ASCII, which ends with what to do next. Sentences are
 * divided by a space, with a line of its own for each step of the verdict. `text` gets as
 * many whole sentences as it has room for, and a 0 at the end; *n_needed, if not NULL, the
 * size that all of them take.
 * OK; ERR_CAPACITY: not all of them fit. A capacity of 0 asks for the size. ERR_NULL;
 * ERR_NOT_FINITE, ERR_RANGE: what is handed in is no result of rigcal_rig_faults, nothing
 * is written. */
RIGCAL_API rigcal_status rigcal_faults_text(char text[], size_t capacity, size_t *n_needed,
                                            const rigcal_faults *found,
                                            const rigcal_fault faults[],
                                            const rigcal_faults_words *words);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_FAULTS_H */
