#include "rc_neldermead.h"

/* fminsearch's first simplex. */
#define EDGE_RELATIVE RC(0.05)
#define EDGE_AT_ZERO RC(0.00025)

/* Roundings of the best vertex below which a tolerance cannot be met. */
#define TOL_FLOOR (10 * RC_EPS)

/* The point whose cost is awaited. */
enum {
    NOT_BEGUN = 0,
    FIRST_SIMPLEX, /* vertex vertex_next */
    REFLECTION,
    EXPANSION,
    CONTRACTION_OUTSIDE,
    CONTRACTION_INSIDE,
    SHRINK, /* vertex vertex_next */
    DONE
};

/* trial = (1 + s) centroid - s worst, the centroid of all but the worst: s = 1
 * reflects, 2 expands, 1/2 contracts outside, -1/2 inside. */
static void set_trial(rigcal_neldermead *nm, rigcal_real s, int32_t phase)
{
    const int32_t k = nm->k;
    for (int32_t i = 0; i < k; i++) {
        rigcal_real sum = nm->vertex[0][i];
        for (int32_t v = 1; v < k; v++) {
            sum += nm->vertex[v][i];
        }
        const rigcal_real centroid = sum / (rigcal_real)k;
        nm->trial[i] = (1 + s) * centroid - s * nm->vertex[k][i];
    }
    nm->phase = phase;
}

/* trial = vertex v, moved halfway to the best. */
static void set_trial_shrunk(rigcal_neldermead *nm, int32_t v)
{
    for (int32_t i = 0; i < nm->k; i++) {
        const rigcal_real best = nm->vertex[0][i];
        nm->trial[i] = best + (nm->vertex[v][i] - best) / 2;
    }
    nm->vertex_next = v;
    nm->phase = SHRINK;
}

static void set_trial_vertex(rigcal_neldermead *nm, int32_t v)
{
    rc_vec3_copy(nm->trial, nm->vertex[v]);
    nm->vertex_next = v;
    nm->phase = FIRST_SIMPLEX;
}

static void put(rigcal_neldermead *nm, int32_t v, const rigcal_real x[3],
                rigcal_real cost)
{
    rc_vec3_copy(nm->vertex[v], x);
    nm->cost[v] = cost;
}

/* Insertion sort by cost; equal costs keep their order. */
static void sort_vertices(rigcal_neldermead *nm)
{
    for (int32_t i = 1; i <= nm->k; i++) {
        rigcal_real x[3];
        const rigcal_real cost = nm->cost[i];
        int32_t at = i;
        rc_vec3_copy(x, nm->vertex[i]);
        for (; at > 0 && nm->cost[at - 1] > cost; at--) {
            put(nm, at, nm->vertex[at - 1], nm->cost[at - 1]);
        }
        put(nm, at, x, cost);
    }
}

static int has_converged(const rigcal_neldermead *nm)
{
    const rigcal_real ftol = rc_max(nm->ftol, TOL_FLOOR * RC_FABS(nm->cost[0]));
    for (int32_t v = 1; v <= nm->k; v++) {
        if (!(RC_FABS(nm->cost[v] - nm->cost[0]) <= ftol)) {
            return 0;
        }
        for (int32_t i = 0; i < nm->k; i++) {
            const rigcal_real best = nm->vertex[0][i];
            const rigcal_real xtol = rc_max(nm->xtol, TOL_FLOOR * RC_FABS(best));
            if (!(RC_FABS(nm->vertex[v][i] - best) <= xtol)) {
                return 0;
            }
        }
    }
    return 1;
}

/* The simplex is complete: sort it, then stop or reflect. */
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

static void accept(rigcal_neldermead *nm, const rigcal_real x[3],
                   rigcal_real cost)
{
    put(nm, nm->k, x, cost);
    next_iteration(nm);
}

static void tell_reflection(rigcal_neldermead *nm, rigcal_real cost)
{
    const int32_t k = nm->k;
    rc_vec3_copy(nm->reflected, nm->trial);
    nm->cost_reflected = cost;
    if (cost < nm->cost[0]) {
        set_trial(nm, 2, EXPANSION);
    } else if (cost < nm->cost[k - 1]) {
        accept(nm, nm->trial, cost);
    } else if (cost < nm->cost[k]) {
        set_trial(nm, RC(0.5), CONTRACTION_OUTSIDE);
    } else {
        set_trial(nm, RC(-0.5), CONTRACTION_INSIDE);
    }
}

static void tell_expansion(rigcal_neldermead *nm, rigcal_real cost)
{
    if (cost < nm->cost_reflected) {
        accept(nm, nm->trial, cost);
    } else {
        accept(nm, nm->reflected, nm->cost_reflected);
    }
}

static void tell_contraction(rigcal_neldermead *nm, rigcal_real cost)
{
    const int helps = (nm->phase == CONTRACTION_OUTSIDE)
                          ? cost <= nm->cost_reflected
                          : cost < nm->cost[nm->k];
    if (helps) {
        accept(nm, nm->trial, cost);
    } else {
        set_trial_shrunk(nm, 1);
    }
}

/* A vertex of the first simplex, or of a shrunk one. */
static void tell_vertex(rigcal_neldermead *nm, rigcal_real cost)
{
    const int32_t v = nm->vertex_next;
    put(nm, v, nm->trial, cost);
    if (v == nm->k) {
        next_iteration(nm);
    } else if (nm->phase == SHRINK) {
        set_trial_shrunk(nm, v + 1);
    } else {
        set_trial_vertex(nm, v + 1);
    }
}

static void begin(rigcal_neldermead *nm, int32_t k, rigcal_real xtol,
                  rigcal_real ftol, int32_t max_evals)
{
    nm->k = k;
    nm->xtol = xtol;
    nm->ftol = ftol;
    nm->max_evals = max_evals;
    nm->evals = 0;
    nm->cost_reflected = RC_MAX;
    for (int32_t v = 0; v <= RIGCAL_NELDERMEAD_DIM_MAX; v++) {
        nm->cost[v] = RC_MAX;
    }
    for (int32_t i = 0; i < RIGCAL_NELDERMEAD_DIM_MAX; i++) {
        nm->trial[i] = nm->reflected[i] = 0;
    }
    nm->status = RIGCAL_RUNNING;
    set_trial_vertex(nm, 0);
}

void rc_neldermead_begin(rigcal_neldermead *nm, const rigcal_real x0[], int32_t k,
                         rigcal_real xtol, rigcal_real ftol, int32_t max_evals)
{
    for (int32_t v = 0; v <= RIGCAL_NELDERMEAD_DIM_MAX; v++) {
        for (int32_t i = 0; i < RIGCAL_NELDERMEAD_DIM_MAX; i++) {
            nm->vertex[v][i] = (v <= k && i < k) ? x0[i] : 0;
        }
    }
    for (int32_t i = 0; i < k; i++) {
        const int is_zero = !(RC_FABS(x0[i]) > 0);
        nm->vertex[i + 1][i] =
            is_zero ? EDGE_AT_ZERO : (1 + EDGE_RELATIVE) * x0[i];
    }
    begin(nm, k, xtol, ftol, max_evals);
}

void rc_neldermead_begin_simplex(rigcal_neldermead *nm, const rigcal_real simplex[],
                                 int32_t k, rigcal_real xtol, rigcal_real ftol,
                                 int32_t max_evals)
{
    for (int32_t v = 0; v <= RIGCAL_NELDERMEAD_DIM_MAX; v++) {
        for (int32_t i = 0; i < RIGCAL_NELDERMEAD_DIM_MAX; i++) {
            nm->vertex[v][i] = (v <= k && i < k) ? simplex[v * k + i] : 0;
        }
    }
    begin(nm, k, xtol, ftol, max_evals);
}

int32_t rc_neldermead_best(const rigcal_neldermead *nm)
{
    int32_t best = 0; /* the order holds between iterations only */
    for (int32_t v = 1; v <= nm->k; v++) {
        if (nm->cost[v] < nm->cost[best]) {
            best = v;
        }
    }
    return best;
}

void rc_neldermead_tell(rigcal_neldermead *nm, rigcal_real cost)
{
    const rigcal_real finite = rc_is_finite(cost) ? cost : RC_MAX;
    nm->evals++;
    switch (nm->phase) {
    case REFLECTION:
        tell_reflection(nm, finite);
        break;
    case EXPANSION:
        tell_expansion(nm, finite);
        break;
    case CONTRACTION_OUTSIDE:
    case CONTRACTION_INSIDE:
        tell_contraction(nm, finite);
        break;
    default:
        tell_vertex(nm, finite);
        break;
    }
    if (nm->phase != DONE && nm->evals >= nm->max_evals) {
        sort_vertices(nm);
        nm->phase = DONE;
        nm->status = RIGCAL_BUDGET_SPENT;
    }
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check_begin(const rigcal_neldermead *nm,
                                 const rigcal_real x[], int32_t k,
                                 int whole_simplex, rigcal_real xtol,
                                 rigcal_real ftol, int32_t max_evals)
{
    if (nm == NULL || x == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (k < 1 || k > RIGCAL_NELDERMEAD_DIM_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    const int32_t numbers = whole_simplex ? (k + 1) * k : k;
    if (!rc_all_finite(x, numbers) || !rc_is_finite(xtol) ||
        !rc_is_finite(ftol)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(xtol >= 0) || !(ftol >= 0) || max_evals < 1 ||
        !rc_all_within(x, numbers, RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_RANGE;
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_neldermead_begin(rigcal_neldermead *nm,
                                      const rigcal_real x0[], int32_t k,
                                      rigcal_real xtol, rigcal_real ftol,
                                      int32_t max_evals)
{
    const rigcal_status status =
        check_begin(nm, x0, k, 0, xtol, ftol, max_evals);
    if (status == RIGCAL_OK) {
        rc_neldermead_begin(nm, x0, k, xtol, ftol, max_evals);
    }
    return status;
}

rigcal_status rigcal_neldermead_begin_simplex(rigcal_neldermead *nm,
                                              const rigcal_real simplex[],
                                              int32_t k, rigcal_real xtol,
                                              rigcal_real ftol,
                                              int32_t max_evals)
{
    const rigcal_status status = check_begin(nm, simplex, k, 1, xtol, ftol,
                                             max_evals);
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

rigcal_status rigcal_neldermead_ask(rigcal_real x[], const rigcal_neldermead *nm)
{
    if (x == NULL || nm == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!is_begun(nm)) {
        return RIGCAL_ERR_STATE;
    }
    if (nm->phase != DONE) {
        copy(x, nm->trial, nm->k);
    }
    return nm->status;
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
    return nm->status;
}

rigcal_status rigcal_neldermead_step(rigcal_neldermead *nm, rigcal_cost cost,
                                     void *context, int32_t budget)
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
        rc_neldermead_tell(nm, cost(context, nm->trial));
    }
    return nm->status;
}

rigcal_status rigcal_neldermead_result(rigcal_real x[], rigcal_real *cost,
                                       int32_t *evals,
                                       const rigcal_neldermead *nm)
{
    if (x == NULL || nm == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!is_begun(nm) || nm->evals < 1) {
        return RIGCAL_ERR_STATE;
    }
    const int32_t best = rc_neldermead_best(nm);
    if (!(nm->cost[best] < RC_MAX)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    copy(x, nm->vertex[best], nm->k);
    if (cost != NULL) {
        *cost = nm->cost[best];
    }
    if (evals != NULL) {
        *evals = nm->evals;
    }
    return nm->status;
}
