/* rigcal_paper.h - the published procedure, and its parts.
 *
 * For those who study it, teach it or build on it. rigcal_pose_solve of rigcal.h is more
 * accurate, needs no guess, and takes less time. The first page of rigcal.h holds here too.
 *
 * There are three parts. neldermead is the search. pairs are the calibration equations.
 * paper is the solver that uses both. */
#ifndef RIGCAL_PAPER_H
#define RIGCAL_PAPER_H

#include "rigcal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ==== neldermead ==========================================================
 *
 * Minimises a function of 1 to 3 variables by the simplex method of Nelder and Mead
 * (1965), in the form of Lagarias et al. (1998). fminsearch and SciPy use the same form:
 * reflection 1, expansion 2, contraction 1/2, shrink 1/2. From the same simplex, each
 * evaluation is that of scipy.optimize.minimize(method='Nelder-Mead'). The search knows
 * nothing of cameras.
 *
 * Ask for the point to evaluate, and tell its cost, until the search is done:
 *
 *     rigcal_neldermead_begin(&nm, x0, k, xtol, ftol, max_evals);
 *     while (rigcal_neldermead_ask(x, &nm) == RIGCAL_RUNNING)
 *         rigcal_neldermead_tell(&nm, cost(x));
 *     status = rigcal_neldermead_result(x, &least, &evals, &nm);
 *
 * So there is no callback, and the search may pause at any evaluation.
 *
 * The search stops when every vertex is within xtol of the best one in every coordinate,
 * and every cost is within ftol of the best cost. Both tolerances are at least a few
 * roundings of the best. It also stops after max_evals. It moves away from a cost of NaN
 * or infinity. */
enum rigcal_neldermead_limits { RIGCAL_NELDERMEAD_DIM_MAX = 3 };

/* Starts from x0[k] with the simplex of fminsearch: each further vertex has one coordinate
 * that is 5 % larger, or 0.00025 if the coordinate is zero. k 1 .. 3, tolerances >= 0,
 * max_evals >= 1; ERR_RANGE otherwise.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_neldermead_begin(rigcal_neldermead *nm,
                                                 const rigcal_real x0[], int32_t k,
                                                 rigcal_real xtol, rigcal_real ftol,
                                                 int32_t max_evals);

/* The same from a simplex that the caller gives: k + 1 vertices of k coordinates. */
RIGCAL_API rigcal_status rigcal_neldermead_begin_simplex(rigcal_neldermead *nm,
                                                         const rigcal_real simplex[],
                                                         int32_t k, rigcal_real xtol,
                                                         rigcal_real ftol,
                                                         int32_t max_evals);

/* RUNNING: x[k] is the point to evaluate. OK: the search is done, ask for the result; x is
 * untouched. ERR_NULL, ERR_STATE (not begun). */
RIGCAL_API rigcal_status rigcal_neldermead_ask(rigcal_real x[],
                                               const rigcal_neldermead *nm);

/* Tells the cost of the point that was asked for. Returns the status of the next ask, or
 * ERR_STATE when no point was asked for. */
RIGCAL_API rigcal_status rigcal_neldermead_tell(rigcal_neldermead *nm, rigcal_real cost);

/* Makes at most `budget` >= 1 evaluations of `cost` (ERR_NULL if NULL), for callers who
 * prefer a callback. RUNNING: call again. OK: ask for the result. ERR_RANGE, ERR_STATE. */
typedef rigcal_real (*rigcal_cost)(void *context, const rigcal_real x[]);
RIGCAL_API rigcal_status rigcal_neldermead_step(rigcal_neldermead *nm, rigcal_cost cost,
                                                void *context, int32_t budget);

/* The best vertex so far, at any time after the first cost was told: x[k], its cost,
 * evaluations spent (`cost` and `evals` may be NULL). A reflection becomes a vertex only
 * when the cost of its expansion has been told. Until then, or if the evaluations end
 * first, it does not count. RUNNING, OK (the tolerances are met), BUDGET_SPENT
 * (max_evals), ERR_NULL, ERR_STATE (too early), or ERR_NOT_FINITE (no vertex has a finite
 * cost). */
RIGCAL_API rigcal_status rigcal_neldermead_result(rigcal_real x[], rigcal_real *cost,
                                                  int32_t *evals,
                                                  const rigcal_neldermead *nm);

/* ==== bearings ============================================================ */

/* A reference point and its bearing: the ray along which it was seen, in the camera frame,
 * of any length but zero. The procedure takes bearings, so it works with any lens. */
typedef struct rigcal_bearing {
    rigcal_real X_w[3];
    rigcal_real ray[3];
} rigcal_bearing;

/* Bearings of the n >= 1 points of a view. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA,
 * ERR_RANGE, ERR_TOO_FEW, ERR_NO_RAY. */
RIGCAL_API rigcal_status rigcal_bearings_of_view(rigcal_bearing bearings[],
                                                 int32_t *at_fault,
                                                 const rigcal_view *view);

/* ==== pairs: the calibration equations ==================================== */

/* Which Euler angle is found by linear algebra while the other two are searched. These two
 * keep the order yaw, pitch, roll. */
enum rigcal_angles {
    RIGCAL_YAW = 0,
    RIGCAL_PITCH = 1,
    RIGCAL_ROLL = 2,
    RIGCAL_BEST_CONDITIONED = 3 /* solver only: the one with the least cond(A) */
};

/* The equation of one pair of points (11)..(13): normal . R offset = 0. */
typedef struct rigcal_pair {
    rigcal_real normal[3]; /* unit, of the plane of rays i and j: m_i x m_j */
    rigcal_real offset[3]; /* unit, X_i - X_j */
    int32_t i, j;          /* indices of the bearings */
} rigcal_pair;

/* A sufficient number of pairs for n bearings: 4 n, or all n (n - 1) / 2 if that is
 * less. */
#define RIGCAL_PAIRS_FOR(n) ((n) <= 9 ? (n) * ((n)-1) / 2 : 4 * (n))
RIGCAL_API size_t rigcal_pairs_for(size_t n);

/* Makes the pair (i, j). The other bearings are not read. ERR_COINCIDENT: the points, or
 * the rays, are the same to rounding, and such a pair gives no equation. OK, ERR_NULL,
 * ERR_NOT_FINITE, ERR_RANGE (a ray of length zero; i, j not two different indices below
 * n). */
RIGCAL_API rigcal_status rigcal_pair_make(rigcal_pair *pair,
                                          const rigcal_bearing bearings[], size_t n,
                                          int32_t i, int32_t j);

/* Chooses pairs among n >= 3 bearings. Up to n = 9 it takes all pairs. Beyond, it takes 4
 * n, each point in about eight of them, spread in a fixed disorder so that runs repeat. It
 * leaves out degenerate pairs, and pairs whose rays are closer than a sixth of the image
 * that the target fills, because their sine is mostly noise. The first two pairs are well
 * conditioned for the published elimination by two pairs. With a capacity below
 * rigcal_pairs_for(n), fewer pairs are chosen, still spread: this saves memory and costs
 * accuracy, much of it with few points. A larger capacity changes nothing. Time O(n).
 *
 *   pairs     out   `capacity` >= 3 entries, *n_pairs of them written; >= 3
 *   bearings  in    n of them; every ray less than 90 degrees off the axis
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (ray of length zero, a coordinate beyond
 * 1e30 / 1e9, n above 2^28), ERR_TOO_FEW (n < 3), ERR_CAPACITY (capacity < 3),
 * ERR_WIDE_RAY, ERR_COINCIDENT, ERR_COLLINEAR, ERR_EDGE_ON, ERR_PRECISION. */
RIGCAL_API rigcal_status rigcal_pairs_choose(rigcal_pair pairs[], size_t capacity,
                                             size_t *n_pairs,
                                             const rigcal_bearing bearings[], size_t n);

/* (13): the residual e = normal . R offset of one pair, which behaves like a sine.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (the pair's vectors are not of unit
 * length, here and below). */
RIGCAL_API rigcal_status rigcal_pair_residual(rigcal_real *e, const rigcal_pair *pair,
                                              const rigcal_real R[9]);

/* (14): e = p cos w + q sin w + k for the eliminated angle w when the other two are fixed.
 * pqk[3] out. `eliminated` RIGCAL_YAW, _PITCH or _ROLL, else ERR_RANGE.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_pair_coefficients(rigcal_real pqk[3],
                                                  const rigcal_pair *pair,
                                                  int32_t eliminated,
                                                  const rigcal_real angles[2]);

typedef struct rigcal_elimination {
    rigcal_real angle;        /* eliminated angle w, (-pi, pi] */
    rigcal_real cosine, sine; /* solution of A (c, s)^T = b before normalising */
    rigcal_real condition;    /* cond_2(A) */
    rigcal_real unit;         /* (15): c^2 + s^2 - 1 */
    rigcal_real residual;     /* the objective: |(15)| + sum |e| */
} rigcal_elimination;

/* (14), (15) and the objective of the two-angle search at one place.
 *
 *   pairs       n_pairs >= 3
 *   pairs_used  2: only the first two pairs determine the angle, as published; the others
 *               are residuals (15). 0: all pairs determine it, by least squares, and all
 *               are residuals. This has less noise in w for the same work
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_TOO_FEW, ERR_DEGENERATE (A is singular to
 * rounding, with all pairs from cond(A) = 1.7e7 / 720 on; or c = s = 0). Time
 * O(n_pairs). */
RIGCAL_API rigcal_status rigcal_pairs_eliminate(rigcal_elimination *out,
                                                const rigcal_pair pairs[], size_t n_pairs,
                                                int32_t pairs_used, int32_t eliminated,
                                                const rigcal_real angles[2]);

/* (5): sum |e| over n_pairs >= 3 pairs at ypr. It is the objective of the search over all
 * three angles. OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_TOO_FEW. */
RIGCAL_API rigcal_status rigcal_pairs_residual(rigcal_real *residual,
                                               const rigcal_pair pairs[], size_t n_pairs,
                                               const rigcal_real ypr[3]);

/* (10a), (10b), (16): t of cam_from_world for a known rotation, from pairs. t_z is the
 * average of (10a) and (10b) over the pairs, without coordinates that differ by less than
 * 1e-9 / 1e-4. t_x and t_y are the average of (9) over the points.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_ROTATION, ERR_TOO_FEW (n < 2, no pairs),
 * ERR_WIDE_RAY, ERR_DEGENERATE (nothing left to average). */
RIGCAL_API rigcal_status rigcal_translation_from_pairs(rigcal_real t[3],
                                                       const rigcal_real R[9],
                                                       const rigcal_bearing bearings[],
                                                       size_t n, const rigcal_pair pairs[],
                                                       size_t n_pairs);

/* The same by least squares over all 2 n equations t_xy - u t_z = u q_z - q_xy, with q = R
 * X and n >= 2. It is more accurate. Statuses as above; ERR_DEGENERATE when all rays are
 * the same. */
RIGCAL_API rigcal_status rigcal_translation_least_squares(rigcal_real t[3],
                                                          const rigcal_real R[9],
                                                          const rigcal_bearing bearings[],
                                                          size_t n);

/* ==== paper ===============================================================
 *
 * One camera's pose by the published procedure. Nelder-Mead searches two angles while the
 * third is eliminated (14), (15), or all three (5), (6). Least squares give the
 * translation (16). */
typedef struct rigcal_paper_options {
    int32_t angles;     /* 2 (default) or 3: how many are searched; 3 needs a guess */
    int32_t eliminated; /* RIGCAL_BEST_CONDITIONED (default), _YAW, .. */
    int32_t pairs_used; /* pairs that determine the eliminated angle: 0 all (default), 2 as
                           published */
    int32_t use_guess;  /* 1: a local search from guess_ypr. 0 (default): searches from a
                           fixed grid of the two angles, without a guess */
    int32_t max_evals;  /* over all starts, >= 1 with a guess, >= 192 without. 0: 1000 with
                           a guess, 3952 without */
    rigcal_real guess_ypr[3]; /* yaw, pitch, roll of cam_from_world; the eliminated one is
                                 not used */
    rigcal_real xtol;         /* radian; 0: 1e-10 / 1e-5 */
    rigcal_real ftol;         /* of the objective; 0: 1e-10 / 1e-5 */
} rigcal_paper_options;

typedef struct rigcal_paper_pose {
    rigcal_transform cam_from_world;
    rigcal_real ypr[3];    /* yaw, pitch, roll of its rotation */
    rigcal_real residual;  /* the objective at the answer: sum of sines */
    rigcal_real condition; /* cond(A) at the answer; 0 with three angles */
    rigcal_real rms;       /* root mean square distance of the projected from the observed
                              normalised image points (x, y) */
    int32_t eliminated;    /* RIGCAL_YAW, _PITCH, _ROLL; -1 with three angles */
    int32_t evals;         /* evaluations of the objective, all starts */
    int32_t starts;        /* simplex searches run */
} rigcal_paper_pose;

enum rigcal_paper_limits { RIGCAL_PAPER_SEEDS = 24 };

/* A search under way. Flat and copyable; do not rely on its contents. */
typedef struct rigcal_paper_solver {
    const rigcal_bearing *bearings;
    const rigcal_pair *pairs;
    size_t n, n_pairs;
    rigcal_paper_options options;
    rigcal_neldermead nm;
    rigcal_paper_pose best;
    rigcal_real least_condition, seed_cost[RIGCAL_PAPER_SEEDS];
    int32_t seed_node[RIGCAL_PAPER_SEEDS];
    int32_t phase, next, eliminated, found, behind, evals, starts, spent;
} rigcal_paper_solver;

/* All defaults. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_paper_defaults(rigcal_paper_options *options);

/* begin, step to the end, result. */
RIGCAL_API rigcal_status rigcal_paper_solve(rigcal_paper_pose *pose,
                                            const rigcal_bearing bearings[], size_t n,
                                            const rigcal_pair pairs[], size_t n_pairs,
                                            const rigcal_paper_options *options);

/* Begins a search over pairs that rigcal_pairs_choose or the caller chose. `bearings` and
 * `pairs` must last until the search is done. n >= 3, n_pairs >= 3. options NULL: all
 * defaults.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_TOO_FEW, ERR_WIDE_RAY. */
RIGCAL_API rigcal_status rigcal_paper_begin(rigcal_paper_solver *solver,
                                            const rigcal_bearing bearings[], size_t n,
                                            const rigcal_pair pairs[], size_t n_pairs,
                                            const rigcal_paper_options *options);

/* Spends at most `budget` >= 1 units. A unit is one of these: an evaluation, O(n_pairs),
 * at most max_evals of them; the pose where a start has ended, O(n_pairs + n), at most 25
 * of them; or the condition of one of the three eliminations. RUNNING: call again. OK: ask
 * for the result. The budgets do not change one bit of it. ERR_NULL, ERR_RANGE,
 * ERR_STATE. */
RIGCAL_API rigcal_status rigcal_paper_step(rigcal_paper_solver *solver, int32_t budget);

/* The best pose of a search that is done, with every point in front.
 * OK, BUDGET_SPENT, ERR_NULL, ERR_STATE (not begun or still running), ERR_BEHIND (the
 * guess led to the mirror solution, which fits with points behind the camera),
 * ERR_NO_POSE. */
RIGCAL_API rigcal_status rigcal_paper_result(rigcal_paper_pose *pose,
                                             const rigcal_paper_solver *solver);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_PAPER_H */
