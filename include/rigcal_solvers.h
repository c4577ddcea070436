/* rigcal_solvers.h - what each solver keeps between its steps. Included by rigcal.h.
 *
 * A caller needs only the sizes of the solvers. They are flat and may be copied. Do not
 * read or write their contents, which may change with every version. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_SOLVERS_H
#define RIGCAL_SOLVERS_H

#ifdef __cplusplus
extern "C" {
#endif

/* ---- the points of a view that count, and from where they count ------------- */

typedef struct rigcal_points {
    rigcal_view view;
    const uint8_t *mask; /* one for each point: 1: it counts. NULL: all count */
    int32_t left_out;    /* index of one more point that does not count, or -1 */
    uint8_t is_mirrored, is_pinhole; /* mirrored: at the origin */
    size_t n_used;                   /* that count */
    rigcal_real origin[3];           /* weighted mean of the points */
    rigcal_real size;       /* their longest distance from the first point, along an axis */
    rigcal_real extent_px;  /* the same of their pixels */
    rigcal_real pixel_size; /* see rc_pixel_size */
    rigcal_real negligible; /* a change of the sum of squared errors that means nothing */
    rigcal_real proved2;    /* Brown's lens has no fold up to this x^2 + y^2: proved */
} rigcal_points;

/* ---- Nelder-Mead ------------------------------------------------------------ */

typedef struct rigcal_vertex {
    rigcal_real x[3], cost; /* a vertex of the simplex: the first k coordinates count */
} rigcal_vertex;

typedef struct rigcal_neldermead {
    int32_t k, evals, max_evals, phase, vertex_next;
    int32_t status; /* RUNNING, OK or BUDGET_SPENT */
    rigcal_real xtol, ftol;
    rigcal_vertex trial;     /* the point asked for */
    rigcal_vertex reflected; /* kept while an expansion is tried */
    rigcal_vertex vertex[4]; /* k + 1 of them, best first between iterations */
} rigcal_neldermead;

/* ---- Levenberg-Marquardt, and the refinement of a pose by it ---------------- */

typedef struct rigcal_levenberg {
    int32_t want, equations, status;
    rigcal_real sum, last_gain, lambda;
} rigcal_levenberg;

typedef struct rigcal_refinement {
    rigcal_levenberg search;
    int32_t evals;
    uint8_t is_approach, is_part; /* the next step: along the rays; by some points */
    rigcal_transform cam_from_points;
    rigcal_real g[6], H[21];
} rigcal_refinement;

/* ---- where a search of a pose may start ------------------------------------- */

/* Sums over the points. The cost of a direction follows from them (EQUATIONS.md A). */
typedef struct rigcal_moments {
    rigcal_real weight, S, u_mean[2], V_mean[2][3], h[3], K_less_C[6], C[6], G[2][6];
} rigcal_moments;

enum rigcal_seed_limits { RIGCAL_SEEDS_MAX = 3 };

/* The numbers of the best directions of the lattice. */
typedef struct rigcal_lattice {
    int32_t index[RIGCAL_SEEDS_MAX];
    rigcal_real least_cost, azimuth[2], cost[RIGCAL_SEEDS_MAX];
    rigcal_moments moments;
} rigcal_lattice;

/* The poses of three points (EQUATIONS.md D), one after the other. Lengths are in units of
 * the longest side. The point opposite to that side is the first. */
typedef struct rigcal_p3p {
    rigcal_real size, middle[3], frame[9]; /* of the points */
    rigcal_real squared[3], chord2[3], h;  /* sides; chords between the rays, over h^2 */
    union rigcal_p3p_work {
        rigcal_real x[3][3], conic[9]; /* the points, at first */
    } work;
    rigcal_real line[3], v[2][3]; /* the second line; where one crosses the conic */
    uint8_t first, is_second, crossings, next;
} rigcal_p3p;

/* Three points and their rays. `count` is the number of points, 4 for more than three. */
typedef struct rigcal_triple {
    int32_t index[3], count;
    rigcal_real ray[3][3];
    rigcal_p3p poses;
} rigcal_triple;

/* A descent under way, near the direction m3. */
typedef struct rigcal_descent {
    rigcal_real m3[3];
    rigcal_neldermead nm;
} rigcal_descent;

/* ---- a pose ----------------------------------------------------------------- */

/* An optimum: the camera from the points' own origin. The third row of its rotation is the
 * cross product of the two rows. */
typedef struct rigcal_optimum {
    rigcal_real rows[6], t[3], sse;
} rigcal_optimum;

typedef struct rigcal_optima {
    int32_t n;
    rigcal_optimum list[RIGCAL_POSES_MAX]; /* best first */
} rigcal_optima;

/* The points, the optima found so far, where to start next, and what is under way. */
typedef struct rigcal_search {
    uint8_t phase, next, n_seeds, n_exact, triples, leans, is_flat, is_plane, is_wide;
    uint8_t n_roots; /* number of poses of the widest triple */
    size_t point;
    rigcal_real scale, axis[3], normal[3];
    rigcal_points points;
    rigcal_optima optima;
    union rigcal_search_sources {
        rigcal_lattice lattice;
        rigcal_transform exact[RIGCAL_POSES_MAX];
    } from;
    union rigcal_search_work {
        rigcal_triple triple;
        rigcal_descent descent;
        rigcal_refinement refinement;
    } work;
} rigcal_search;

struct rigcal_pose_solver {
    uint8_t phase, is_warm, is_mirrored, is_unfinished;
    int32_t failure, at_fault, same;
    size_t next;
    rigcal_real sigma_px, variance; /* variance of its rotation, for noise of 1 px */
    rigcal_search search;
};

/* ---- a robust pose ---------------------------------------------------------- */

/* The best pose so far, the rays and poses of one triple, and a good one, improved. */
typedef struct rigcal_trial_poses {
    rigcal_transform best, tried[RIGCAL_POSES_MAX], good;
    rigcal_real ray[3][3], cost, good_cost;
    rigcal_refinement better;
    size_t n_good; /* points that agree with it */
} rigcal_trial_poses;

struct rigcal_robust_solver {
    rigcal_points points; /* all of them */
    uint8_t *inliers;
    size_t n_agree; /* that are marked at last */
    union rigcal_robust_work {
        rigcal_trial_poses trial;
        rigcal_pose_solver pose;
    } work;
    rigcal_transform rival; /* the best pose that differs from the best of all */
    rigcal_real sigma_px, threshold_px, area_px2, by_chance, cost, rival_cost;
    uint32_t random;
    int32_t sample[3], samples, tried, wanted, is_complete, phase, next, n_poses, rounds;
    int32_t rank, stride, units, max_units, failure, is_doubtful;
};

/* ---- an adjusted rig -------------------------------------------------------- */

struct rigcal_rig_solver {
    rigcal_rig *rig;
    const struct rigcal_rig_given *given; /* reads views: points, or own poses */
    const struct rigcal_rig_given *timed; /* if the rig has clocks: the same without them */
    rigcal_levenberg search;
    int32_t loss, is_lagging; /* RIGCAL_LOSS_, 0: squares; the motion lags by a step */
    int32_t phase, is_join, is_trial, is_last, is_final, is_disconnected, at_fault, evals;
    size_t n;                        /* unknowns of the cameras that are not held */
    size_t view, first, placement;   /* under way; the first view of the placement */
    size_t row;                      /* row of the factor, or view of the placement */
    size_t n_points, n_used, n_seen; /* numbers of points, views, placements that count */
    size_t n_free;                   /* cameras without a prior that are not held */
    size_t n_clocks;                 /* number of offsets and drifts that are estimated */
    rigcal_real sum, gain;           /* of one pass; promised by one step */
    rigcal_real own_sum;             /* sum over the views by themselves */
    rigcal_real promised, negligible, gp[6], Hp[21];
};

/* ---- parameters beside cameras and placements -------------------------------- */

typedef struct rigcal_border {
    size_t n, k;           /* unknowns of the cameras; columns: the parameters */
    rigcal_real *T;        /* k rows of n: the part shared with the cameras, or NULL */
    rigcal_real *Z;        /* k rows of 6: B^T E of a placement; eliminated, Y */
    rigcal_real *q;        /* k; NULL: neither q nor Q is wanted */
    rigcal_real *Q;        /* row by row: row i has columns first[i] .. i */
    const uint16_t *first; /* k; NULL: all from 0 on */
    rigcal_real *W, *slot; /* 36 and 1 of each view of a placement, of its camera: A^T H B,
                              eliminated Y_c; and its first unknown, -1: it is held */
    size_t count;          /* views of the placement so far */
    rigcal_real gp[6], Hp[21]; /* of the placement; eliminated, L^-1 g and L */
} rigcal_border;

/* ---- intrinsics that are considered ------------------------------------------ */

struct rigcal_consider_solver {
    rigcal_rig *rig;
    rigcal_considered *considered;
    int32_t phase, status, at_fault;
    size_t view, first, placement, column; /* under way */
    rigcal_real sum, own_sum;              /* of rigcal_considered, so far */
    rigcal_border border;
};

/* ---- the choice between two poses of each view ------------------------------ */

enum rigcal_choose_rungs { RIGCAL_CHOOSE_RUNGS = 6 };

/* The best hypothesis about a camera's pose. */
typedef struct rigcal_seed {
    rigcal_real score;
    int32_t a, b, number; /* camera b from camera a; a -1: b from the rig */
    int32_t n;            /* placements compared */
} rigcal_seed;

struct rigcal_choose_solver {
    rigcal_rig_solver check; /* checks what is handed in */
    rigcal_choice *choice;
    int32_t phase, status, rung, is_again, is_relaxed, is_final;
    int32_t a, b;                 /* cameras under way; a -1: the rig instead */
    size_t view, placement;       /* under way */
    size_t n, row, column, which; /* number of placements compared, two of them; a claim */
    rigcal_real limit;            /* px^2, at tau^2 = 1 */
    rigcal_real most, counts[RIGCAL_CHOOSE_RUNGS];
    rigcal_seed seed[RIGCAL_CHOOSE_RUNGS];
    int32_t agree, best; /* the best claim of a placement so far */
    rigcal_real cost, spread;
};

/* ---- a rig whose views are judged ------------------------------------------- */

struct rigcal_judge_solver {
    rigcal_rig *rig;
    rigcal_judged_view *judged;
    rigcal_choice *choice;
    uint8_t *left_out;
    int32_t phase, status, at_fault, is_placed, rounds, adjustments;
    int32_t n_of[4];               /* views of each verdict */
    size_t view, first, placement; /* under way; the first view of the placement */
    size_t n_kept, slot;           /* number of its views that count; the one under way */
    size_t n_costs, n_places;      /* numbers of views, placements that can be judged */
    rigcal_real sigma2, scale;
    rigcal_real tried_cost; /* cost of the view that is left out on trial; 0: none is */
    rigcal_rig_solver adjust;
};

struct rigcal_cause_solver {
    const rigcal_rig *rig;
    const rigcal_symmetries *symmetries;
    int32_t phase, status, is_camera, acting; /* the camera that a view is tested for */
    int32_t agree, checked;                   /* numbers of the camera's views */
    size_t view, first, last, test;           /* views of its placement; test under way */
    rigcal_real limit;                        /* px^2 */
    rigcal_cause found;
    rigcal_view_pose own;
    rigcal_rig_view seen; /* the view as it is tested */
    rigcal_camera lens;
    rigcal_transform target_from_turned;
    rigcal_pose_solver pose;
};

/* ---- a point that is measured ------------------------------------------------ */

/* The covariance of the 2 n pixels, and the sums for a point that follow from it. */
typedef struct rigcal_point_sums {
    rigcal_real *V;         /* packed, then its factor */
    rigcal_real N[6];       /* (A^T W A)^-1, W the weights */
    rigcal_real Sigma[6];   /* of the point: N, and the calibration's part */
    rigcal_real M[6], c[3]; /* A^T V^-1 A, A^T V^-1 e */
    rigcal_real q;          /* e^T V^-1 e */
} rigcal_point_sums;

struct rigcal_point_solver {
    const rigcal_sightings *sightings;
    int32_t phase, status, of;         /* of: all views, two, or those that agree */
    int32_t whole;                     /* the status to return if no two views agree */
    int32_t stage, located;            /* stage of the point under way, and its status */
    int32_t is_tried, is_stale, evals; /* a step waits for its sum; old equations */
    size_t view, n_used;               /* the view under way; how many are used */
    size_t pair, two[2];               /* the pair under way */
    size_t n_pairs, agree, best;       /* pairs ranked; views that agree; the most so far */
    rigcal_real tolerance;             /* factor of the limits, 1 at least */
    rigcal_real distance, least;       /* sums of what they miss by; of the best */
    rigcal_levenberg search;
    rigcal_real X[3], before[3], g[3], H[6], sum, gain, negligible;
    rigcal_real aside, chi2; /* aside: sine squared of the parallax */
    rigcal_point_sums sums;
};

/* ---- the spans of a band ---------------------------------------------------- */

/* A part of the border on which v only rises or only falls. */
typedef struct rigcal_arc {
    rigcal_real low, high;  /* of v, at its ends */
    rigcal_real a[5], b[5]; /* direct: u at v is a[0] + w (a[1] + w ..., w = v - b[0];
                               else u and v by powers of t */
    rigcal_real t_low, t_high;
    int32_t is_direct;
} rigcal_arc;

enum rigcal_outline_limits {
    RIGCAL_SPANS_ARCS = 112,
    RIGCAL_SPANS_ACTIVE = 2 * RIGCAL_SPANS_ROW,
    RIGCAL_SPANS_NODES = 5
};

typedef struct rigcal_outline {
    int32_t n_arcs, height, is_full; /* is_full: there are more arcs than room for them */
    int32_t row, next, n_active;
    rigcal_real changes; /* from this row on, other arcs may be crossed */
    uint8_t order[RIGCAL_SPANS_ARCS], active[RIGCAL_SPANS_ACTIVE];
    rigcal_arc arcs[RIGCAL_SPANS_ARCS];
} rigcal_outline;

/* A border of a band, and where it is over the place of the line that was found last. */
typedef struct rigcal_edge {
    rigcal_band band;
    int32_t is_pinhole, side;
    rigcal_real A, normal[3];   /* (M6); line / across */
    rigcal_real height, slope2; /* over the line; |ds/du|^2, for a p of length 1 */
} rigcal_edge;

/* Where a border ends. */
typedef struct rigcal_border_end {
    rigcal_real uv[2], height;
    int32_t is_of_range; /* 1: at an end of the depth range */
} rigcal_border_end;

struct rigcal_spans_solver {
    rigcal_edge edge;
    int32_t side, way, node, n_arcs, turns;     /* place on a border; of the outline */
    int32_t phase, status, is_last, is_closing; /* last arc in range; near the lens's end */
    rigcal_real ends[2][2], start[2], at[2];    /* at: of the first node of the arc */
    rigcal_real radius2, radius, stride, length; /* image: 1, px; an arc: tangent, px */
    rigcal_real start_uv[2], start_height, start_speed; /* px for a tangent of 1 */
    rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];
    rigcal_border_end corners[2][2]; /* indexed by side and way */
    rigcal_outline outline;
};

/* ---- why the views of a rig disagree ------------------------------------------- */

/* The parameters of the faults that one pass tests, one column each. Sums of each: Q and q
 * with all other unknowns free, Q before placements are eliminated, and Q and q with the
 * pose of each view free. */
typedef struct rigcal_columns {
    const rigcal_rig *rig;
    int32_t kinds;
    size_t n;          /* unknowns of the cameras, before those of the clocks */
    size_t per_clock;  /* unknowns of a clock that the adjustment freed, at most 2 */
    int32_t at[12];    /* for each parameter of a view, its number among those of a camera
                          or the board; -1: not tested in this pass */
    size_t per_camera; /* parameters of a camera besides its clock */
    rigcal_border border;
    rigcal_real *sums[10];  /* sums of columns: see rigcal_columns.c */
    rigcal_real *reference; /* 3 of each camera */
} rigcal_columns;

/* Cameras that moved: S and g of all cameras, summed over the placements so far, and the
 * best fault of each camera so far. */
typedef struct rigcal_moves {
    rigcal_real *S, *g, *best;
    rigcal_real *clocks;         /* S of the free clocks and all cameras */
    rigcal_real *camera;         /* the camera of each view of the placement */
    rigcal_real *total, *so_far; /* numbers of views of each camera */
} rigcal_moves;

struct rigcal_faults_solver {
    rigcal_rig *rig;
    const rigcal_faults_options *options;
    rigcal_fault *faults;
    rigcal_faults found;
    size_t capacity;
    int32_t phase, status, at_fault, left; /* left: kinds for a later pass */
    int32_t test, camera;                  /* what is tested next */
    size_t view, first, placement, slot;   /* under way; the first view of the placement */
    size_t n, n_free; /* unknowns of the cameras; cameras without a prior */
    size_t n_points, n_used, n_seen, n_neighbours;
    rigcal_columns columns;
    rigcal_moves moves;
    rigcal_real low[2], high[2];              /* bounds of the board's points */
    rigcal_real sum, own;                     /* sums of squares: rig; single views */
    rigcal_real product, expected, expected2; /* sums over neighbouring points */
    rigcal_real along, disagreement, speed2;  /* sums along the motion; in all */
};

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_SOLVERS_H */
