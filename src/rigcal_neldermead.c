#include "rc_neldermead.h"

/* ---- constants ----------------------------------------------------------- */

/* part of a coordinate: the edge of the first simplex, as in fminsearch. */
#define EDGE_RELATIVE RC(0.05)

/* unit of the coordinate: the edge of the first simplex where the coordinate is 0. */
#define EDGE_AT_ZERO RC(0.00025)

/* part of the best vertex: a smaller tolerance cannot be met. */
#define TOL_FLOOR (10 * RC_EPS)

/* Which point's cost the search waits for. */
enum {
    NOT_BEGUN = 0,
    FIRST_SIMPLEX, /* the vertex vertex_next */
    REFLECTION,
    EXPANSION,
    CONTRACTION_OUTSIDE,
    CONTRACTION_INSIDE,
    SHRINK, /* the vertex vertex_next */
    DONE
};

/* trial = (1 + s) centroid - s worst; the centroid is that of all vertices except the
 * worst. s = 1 reflects, 2 expands, 1/2 contracts outside, -1/2 inside. */
static void set_trial(rigcal_neldermead *nm, rigcal_real s, int32_t phase)
{
    const int32_t k = nm->k;
    for (int32_t i = 0; i < k; i++) {
        rigcal_real sum = nm->vertex[0].x[i];
        for (int32_t v = 1; v < k; v++) {
            sum += nm->vertex[v].x[i];
        }
        const rigcal_real centroid = sum / (rigcal_real)k;
        nm->trial.x[i] = (1 + s) * centroid - s * nm->vertex[k].x[i];
    }
    nm->phase = phase;
}

/* trial = vertex v of the first simplex, or of one that shrinks, where it moves halfway to
 * the best. The whole vertex is copied: a compiler would make a memmove of k numbers. */
static void set_trial_vertex(rigcal_neldermead *nm, int32_t v, int32_t phase)
{
    nm->trial = nm->vertex[v];
    for (int32_t i = 0; i < nm->k && phase == SHRINK; i++) {
        const rigcal_real best = nm->vertex[0].x[i];
        nm->trial.x[i] = best + (nm->trial.x[i] - best) / 2;
    }
    nm->vertex_next = v;
    nm->phase = phase;
}

/* Insertion sort by cost; equal costs keep their order. */
static void sort_vertices(rigcal_neldermead *nm)
{
    for (int32_t i = 1; i <= nm->k; i++) {
        const rigcal_vertex moved = nm->vertex[i];
        int32_t at = i;
        for (; at > 0 && nm->vertex[at - 1].cost > moved.cost; at--) {
            nm->vertex[at] = nm->vertex[at - 1];
        }
        nm->vertex[at] = moved;
    }
}

RC_APART static int is_near(rigcal_real x, rigcal_real best, rigcal_real tol)
{
    return RC_FABS(x - best) <= rc_max(tol, TOL_FLOOR * RC_FABS(best));
}

static int has_converged(const rigcal_neldermead *nm)
{
    const rigcal_vertex *const best = &nm->vertex[0];
    for (int32_t v = 1; v <= nm->k; v++) {
        int near = is_near(nm->vertex[v].cost, best->cost, nm->ftol);
        for (int32_t i = 0; i < nm->k; i++) {
            near = near && is_near(nm->vertex[v].x[i], best->x[i], nm->xtol);
        }
        if (!near) {
            return 0;
        }
    }
    return 1;
}

/* The simplex is complete: sorts it, then stops or reflects. */
static void next_iteration(rigcal_neldermead *nm)
{
    sort_vertices(nm);
    if (has_converged(nm)) {
        nm->phase = DONE;
        nm->status = RIGCAL_OK;
    } else {
        set_trial(nm, 1, REFLECTION);
    }
}

RC_APART static void accept(rigcal_neldermead *nm, const rigcal_vertex *vertex)
{
    nm->vertex[nm->k] = *vertex;
    next_iteration(nm);
}

static void tell_reflection(rigcal_neldermead *nm)
{
    const rigcal_vertex *const worst = &nm->vertex[nm->k];
    const rigcal_real cost = nm->trial.cost;
    nm->reflected = nm->trial;
    if (cost < nm->vertex[0].cost) {
        set_trial(nm, 2, EXPANSION);
    } else if (cost < worst[-1].cost) {
        accept(nm, &nm->trial);
    } else if (cost < worst->cost) {
        set_trial(nm, RC(0.5), CONTRACTION_OUTSIDE);
    } else {
        set_trial(nm, RC(-0.5), CONTRACTION_INSIDE);
    }
}

static void tell_expansion(rigcal_neldermead *nm)
{
    const int helps = nm->trial.cost < nm->reflected.cost;
    accept(nm, helps ? &nm->trial : &nm->reflected);
}

static void tell_contraction(rigcal_neldermead *nm)
{
    const int helps = (nm->phase == CONTRACTION_OUTSIDE)
                          ? nm->trial.cost <= nm->reflected.cost
                          : nm->trial.cost < nm->vertex[nm->k].cost;
    if (helps) {
        accept(nm, &nm->trial);
    } else {
        set_trial_vertex(nm, 1, SHRINK);
    }
}

/* Takes a vertex of the first simplex, or of a shrunk one. */
static void tell_vertex(rigcal_neldermead *nm)
{
    const int32_t v = nm->vertex_next;
    nm->vertex[v] = nm->trial;
    if (v == nm->k) {
        next_iteration(nm);
    } else {
        set_trial_vertex(nm, v + 1, nm->phase);
    }
}

void rc_neldermead_begin_simplex(rigcal_neldermead *nm, const rigcal_real simplex[],
                                 int32_t k, rigcal_real xtol, rigcal_real ftol,
                                 int32_t max_evals)
{
    RIGCAL_ASSERT(k >= 1 && k <= RIGCAL_NELDERMEAD_DIM_MAX);
    RIGCAL_ASSERT(max_evals >= 1 && xtol >= 0 && ftol >= 0);
    *nm = (rigcal_neldermead){0};
    nm->k = k;
    nm->xtol = xtol;
    nm->ftol = ftol;
    nm->max_evals = max_evals;
    nm->status = RIGCAL_RUNNING;
    for (int32_t v = 0; v <= k; v++) {
        for (int32_t i = 0; i < k; i++) {
            nm->vertex[v].x[i] = *simplex++;
        }
        nm->vertex[v].cost = RC_MAX;
    }
    set_trial_vertex(nm, 0, FIRST_SIMPLEX);
}

void rc_neldermead_begin(rigcal_neldermead *nm, const rigcal_real x0[], int32_t k,
                         rigcal_real xtol, rigcal_real ftol, int32_t max_evals)
{
    RIGCAL_ASSERT(k >= 1 && k <= RIGCAL_NELDERMEAD_DIM_MAX);
    rigcal_real simplex[(RIGCAL_NELDERMEAD_DIM_MAX + 1) * RIGCAL_NELDERMEAD_DIM_MAX];
    for (int32_t v = 0; v <= k; v++) {
        for (int32_t i = 0; i < k; i++) {
            const rigcal_real moved =
                (RC_FABS(x0[i]) > 0) ? (1 + EDGE_RELATIVE) * x0[i] : EDGE_AT_ZERO;
            simplex[v * k + i] = (v == i + 1) ? moved : x0[i];
        }
    }
    rc_neldermead_begin_simplex(nm, simplex, k, xtol, ftol, max_evals);
}

const rigcal_vertex *rc_neldermead_best(const rigcal_neldermead *nm)
{
    const rigcal_vertex *best = nm->vertex; /* they are sorted only between iterations */
    for (int32_t v = 1; v <= nm->k; v++) {
        if (nm->vertex[v].cost < best->cost) {
            best = &nm->vertex[v];
        }
    }
    return best;
}

void rc_neldermead_tell(rigcal_neldermead *nm, rigcal_real cost)
{
    RIGCAL_ASSERT(nm->status == RIGCAL_RUNNING);
    nm->trial.cost = rc_is_finite(cost) ? cost : RC_MAX;
    nm->evals++;
    switch (nm->phase) {
    case REFLECTION:
        tell_reflection(nm);
        break;
    case EXPANSION:
        tell_expansion(nm);
        break;
    case CONTRACTION_OUTSIDE:
    case CONTRACTION_INSIDE:
        tell_contraction(nm);
        break;
    default:
        tell_vertex(nm);
        break;
    }
    if (nm->phase != DONE && nm->evals >= nm->max_evals) {
        nm->phase = DONE;
        nm->status = RIGCAL_BUDGET_SPENT;
    }
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check_begin(const rigcal_neldermead *nm, const rigcal_real x[],
                                 int32_t k, int whole_simplex, rigcal_real xtol,
                                 rigcal_real ftol, int32_t max_evals)
{
    if (nm == NULL || x == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (k < 1 || k > RIGCAL_NELDERMEAD_DIM_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    const int32_t numbers = whole_simplex ? (k + 1) * k : k;
    if (!rc_all_finite(x, numbers) || !rc_is_finite(xtol) || !rc_is_finite(ftol)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(xtol >= 0) || !(ftol >= 0) || max_evals < 1 ||
        !rc_all_within(x, numbers, RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_RANGE;
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_neldermead_begin(rigcal_neldermead *nm, const rigcal_real x0[],
                                      int32_t k, rigcal_real xtol, rigcal_real ftol,
                                      int32_t max_evals)
{
    const rigcal_status status = check_begin(nm, x0, k, 0, xtol, ftol, max_evals);
    if (status == RIGCAL_OK) {
        rc_neldermead_begin(nm, x0, k, xtol, ftol, max_evals);
    }
    return status;
}

rigcal_status rigcal_neldermead_begin_simplex(rigcal_neldermead *nm,
                                              const rigcal_real simplex[], int32_t k,
                                              rigcal_real xtol, rigcal_real ftol,
                                              int32_t max_evals)
{
    const rigcal_status status = check_begin(nm, simplex, k, 1, xtol, ftol, max_evals);
    if (status == RIGCAL_OK) {
        rc_neldermead_begin_simplex(nm, simplex, k, xtol, ftol, max_evals);
    }
    return status;
}

static void copy(rigcal_real to[], const rigcal_real from[3], int32_t k)
{
    for (int32_t i = 0; i < k; i++) {
        to[i] = from[i];
    }
}

static int is_begun(const rigcal_neldermead *nm)
{
    return nm->phase > NOT_BEGUN && nm->phase <= DONE && nm->k >= 1 &&
           nm->k <= RIGCAL_NELDERMEAD_DIM_MAX && nm->vertex_next >= 0 &&
           nm->vertex_next <= nm->k;
}

/* The status that ask, tell and step return. */
static rigcal_status stepped(const rigcal_neldermead *nm)
{
    return (nm->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_neldermead_ask(rigcal_real x[], const rigcal_neldermead *nm)
{
    if (x == NULL || nm == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!is_begun(nm)) {
        return RIGCAL_ERR_STATE;
    }
    if (nm->phase != DONE) {
        copy(x, nm->trial.x, nm->k);
    }
    return stepped(nm);
}

rigcal_status rigcal_neldermead_tell(rigcal_neldermead *nm, rigcal_real cost)
{
    if (nm == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!is_begun(nm) || nm->phase == DONE) {
        return RIGCAL_ERR_STATE;
    }
    rc_neldermead_tell(nm, cost);
    return stepped(nm);
}

rigcal_status rigcal_neldermead_step(rigcal_neldermead *nm, rigcal_cost cost, void *context,
                                     int32_t budget)
{
    if (nm == NULL || cost == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!is_begun(nm)) {
        return RIGCAL_ERR_STATE;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    for (int32_t i = 0; i < budget && nm->phase != DONE; i++) {
        rc_neldermead_tell(nm, cost(context, nm->trial.x));
    }
    return stepped(nm);
}

rigcal_status rigcal_neldermead_result(rigcal_real x[], rigcal_real *cost, int32_t *evals,
                                       const rigcal_neldermead *nm)
{
    if (x == NULL || nm == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!is_begun(nm) || nm->evals < 1) {
        return RIGCAL_ERR_STATE;
    }
    const rigcal_vertex *const best = rc_neldermead_best(nm);
    if (!(best->cost < RC_MAX)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    copy(x, best->x, nm->k);
    if (cost != NULL) {
        *cost = best->cost;
    }
    if (evals != NULL) {
        *evals = nm->evals;
    }
    return nm->status;
}
