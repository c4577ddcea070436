#include "rc_elimination.h"
#include "rc_neldermead.h"
#include "rc_transform.h"
#include "rc_translation.h"

/* ---- constants ----------------------------------------------------------- */

/* nodes: the size of the grid in the first angle, over half a turn. No node is on an
 * axis. */
enum { GRID_FIRST = 6 };

/* nodes: the size of the grid in the second angle, over a whole turn. */
enum { GRID_SECOND = 12 };

/* rad: distance between nodes of the grid. A coarser grid misses basins. */
#define GRID_STEP (RC_PI / 6)

/* rad: edge of a seed's first simplex, two thirds of a cell. */
#define GRID_EDGE (RC_PI / 9)

/* rad, and of the objective: tolerance of a seed's search, which only has to end in the
 * right basin. The winner is searched again to the caller's tolerances. */
#define SEED_TOL RC(1e-4)

/* evaluations: the most of a seed's search. */
enum { SEED_EVALS_MAX = 120 };

/* evaluations: the most of one simplex. If it has not met the tolerances by then, it is
 * flat against a kink of the objective, which is a sum of absolute values. A new simplex at
 * the same place goes on. */
enum { SIMPLEX_EVALS_MAX = 400 };

/* rad, and of the objective: default of xtol and ftol. */
#define DEFAULT_TOL RC_TOL(1e-10, 1e-5)

/* evaluations: default of max_evals with a guess. */
enum { DEFAULT_EVALS = 1000 };

/* rad: a guess farther from 0 is a mistake. */
#define GUESS_MAX RC(1e3)

/* Number of nodes of the grid, and of the best ones, which become seeds. */
enum { GRID_NODES = GRID_FIRST * GRID_SECOND, SEEDS = RIGCAL_PAPER_SEEDS };

enum {
    NOT_BEGUN = 0,
    SEEDING,
    SEARCHING_SEED,
    JUDGING_SEED,
    CONDITIONING, /* which angle the last search eliminates */
    SEARCHING_LAST,
    JUDGING_LAST,
    DONE
};

/* ---- the objective ------------------------------------------------------- */

static rigcal_real objective(const rigcal_paper_solver *s, const rigcal_real angles[3])
{
    rigcal_elimination at;
    if (s->options.angles == 3) {
        return rc_pairs_residual(s->pairs, s->n_pairs, angles);
    }
    const rigcal_status status = rc_eliminate(&at, s->pairs, s->n_pairs,
                                              s->options.pairs_used, s->eliminated, angles);
    return (status == RIGCAL_OK) ? at.residual : RC_MAX;
}

/* cond(A) at ypr if `eliminated` is the eliminated angle. RC_MAX if A is singular. */
static rigcal_real condition_at(const rigcal_paper_solver *s, int32_t eliminated,
                                const rigcal_real ypr[3])
{
    rigcal_real angles[2];
    rigcal_elimination at;
    rc_angles_split(angles, eliminated, ypr);
    return (rc_eliminate(&at, s->pairs, s->n_pairs, s->options.pairs_used, eliminated,
                         angles) == RIGCAL_OK)
               ? at.condition
               : RC_MAX;
}

/* Chooses this angle to be eliminated, if it is better conditioned than any so far. */
static void consider(rigcal_paper_solver *s, int32_t eliminated, const rigcal_real ypr[3])
{
    const rigcal_real condition = condition_at(s, eliminated, ypr);
    if (condition < s->least_condition) {
        s->least_condition = condition;
        s->eliminated = eliminated;
    }
}

/* ---- from angles to a pose ----------------------------------------------- */

/* Fills in what follows from the angles: rotation, translation (16), residual. */
static rigcal_status pose_of_angles(rigcal_paper_pose *pose, const rigcal_paper_solver *s,
                                    const rigcal_real angles[3], rigcal_real residual)
{
    pose->residual = residual;
    if (s->options.angles == 3) {
        rc_angles_join(pose->ypr, RC_NONE_ELIMINATED, angles, 0);
        pose->condition = 0;
        pose->eliminated = -1;
    } else {
        rigcal_elimination at;
        const rigcal_status status = rc_eliminate(
            &at, s->pairs, s->n_pairs, s->options.pairs_used, s->eliminated, angles);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_angles_join(pose->ypr, s->eliminated, angles, at.angle);
        pose->condition = at.condition;
        pose->eliminated = s->eliminated;
    }
    /* The search may have gone round the circle: takes the angles back to their range. */
    rigcal_transform *const T = &pose->cam_from_world;
    rc_rotation_from_yaw_pitch_roll(T->R, pose->ypr);
    rc_yaw_pitch_roll_from_rotation(pose->ypr, T->R);
    return rc_translation_least_squares(T->t, T->R, s->bearings, s->n);
}

/* Checks that every point is in front of the camera. Computes the error in the image. */
static int check_in_front(rigcal_paper_pose *pose, const rigcal_paper_solver *s)
{
    const rigcal_transform *const T = &pose->cam_from_world;
    rigcal_real sum = 0;
    for (size_t i = 0; i < s->n; i++) {
        const rigcal_real *const ray = s->bearings[i].ray;
        rigcal_real X_c[3];
        rc_transform_point(X_c, T, s->bearings[i].X_w);
        if (!(X_c[2] > 0)) {
            return 0;
        }
        const rigcal_real dx = X_c[0] / X_c[2] - ray[0] / ray[2];
        const rigcal_real dy = X_c[1] / X_c[2] - ray[1] / ray[2];
        sum += dx * dx + dy * dy;
    }
    pose->rms = RC_SQRT(sum / (rigcal_real)s->n);
    return rc_is_finite(sum);
}

/* ---- the searches -------------------------------------------------------- */

static void grid_node(rigcal_real angles[2], int32_t node)
{
    const int32_t first = node / GRID_SECOND, second = node % GRID_SECOND;
    angles[0] = ((rigcal_real)first - RC(GRID_FIRST - 1) / 2) * GRID_STEP;
    angles[1] = ((rigcal_real)second - RC(GRID_SECOND - 1) / 2) * GRID_STEP;
}

/* Keeps the SEEDS best nodes, the best first. */
static void remember_seed(rigcal_paper_solver *s, int32_t node, rigcal_real cost)
{
    int32_t at = SEEDS;
    for (; at > 0 && cost < s->seed_cost[at - 1]; at--) {
        if (at < SEEDS) {
            s->seed_cost[at] = s->seed_cost[at - 1];
            s->seed_node[at] = s->seed_node[at - 1];
        }
    }
    if (at < SEEDS) {
        s->seed_cost[at] = cost;
        s->seed_node[at] = node;
    }
}

/* How many evaluations one more search may take: `wanted`, or what is left of max_evals. */
static int32_t allowance(const rigcal_paper_solver *s, int32_t wanted)
{
    const int32_t left = s->options.max_evals - s->evals;
    return (left < wanted) ? left : wanted;
}

static void start_seed(rigcal_paper_solver *s)
{
    rigcal_real node[2], simplex[6];
    grid_node(node, s->seed_node[s->next]);
    for (int v = 0; v < 3; v++) {
        simplex[2 * v] = node[0] + ((v == 1) ? GRID_EDGE : 0);
        simplex[2 * v + 1] = node[1] + ((v == 2) ? GRID_EDGE : 0);
    }
    (void)rigcal_neldermead_begin_simplex(&s->nm, simplex, 2, SEED_TOL, SEED_TOL,
                                          allowance(s, SEED_EVALS_MAX));
    s->phase = SEARCHING_SEED;
    s->starts++;
}

static void start_last(rigcal_paper_solver *s, const rigcal_real ypr[3])
{
    const rigcal_paper_options *const o = &s->options;
    rigcal_real angles[3] = {ypr[0], ypr[1], ypr[2]};
    if (o->angles == 2) {
        rc_angles_split(angles, s->eliminated, ypr);
    }
    rc_neldermead_begin(&s->nm, angles, o->angles, o->xtol, o->ftol,
                        allowance(s, SIMPLEX_EVALS_MAX));
    s->phase = SEARCHING_LAST;
    s->starts++;
}

/* Judges the place where a search ended. */
static void judge(rigcal_paper_solver *s)
{
    rigcal_paper_pose pose = s->best;
    rigcal_real angles[3] = {0, 0, 0}, residual;
    if (rigcal_neldermead_result(angles, &residual, NULL, &s->nm) < 0 ||
        pose_of_angles(&pose, s, angles, residual) != RIGCAL_OK) {
        return;
    }
    if (!check_in_front(&pose, s)) {
        s->behind = 1;
        return;
    }
    /* The last search starts from the best seed, so its result takes that one's place. */
    if (!s->found || s->phase == JUDGING_LAST || pose.rms < s->best.rms) {
        s->found = 1;
        s->best = pose;
    }
}

static void finish(rigcal_paper_solver *s, int32_t spent)
{
    s->spent = spent;
    s->phase = DONE;
}

/* After a seed: begins the next one, or the last search from the best of all. */
static void judging_seed_step(rigcal_paper_solver *s)
{
    judge(s);
    s->next++;
    if (s->evals >= s->options.max_evals) {
        finish(s, 1);
    } else if (s->next < SEEDS && s->seed_cost[s->next] < RC_MAX) {
        start_seed(s);
    } else if (!s->found) {
        finish(s, 0);
    } else if (s->options.eliminated == RIGCAL_BEST_CONDITIONED) {
        s->next = RIGCAL_YAW;
        s->phase = CONDITIONING;
    } else {
        start_last(s, s->best.ypr);
    }
}

static void conditioning_step(rigcal_paper_solver *s)
{
    consider(s, s->next, s->best.ypr);
    if (s->next++ == RIGCAL_ROLL) {
        start_last(s, s->best.ypr);
    }
}

/* Ends the search from the guess or the best seed. It is judged, or a new simplex goes on
 * from where it stopped. */
static void end_last(rigcal_paper_solver *s)
{
    rigcal_real angles[3] = {0, 0, 0}, ypr[3];
    s->phase = JUDGING_LAST;
    if (s->nm.status == RIGCAL_BUDGET_SPENT && s->evals < s->options.max_evals &&
        rigcal_neldermead_result(angles, NULL, NULL, &s->nm) >= 0) {
        rc_angles_join(ypr, s->options.angles == 2 ? s->eliminated : RC_NONE_ELIMINATED,
                       angles, 0);
        start_last(s, ypr);
    }
}

static void judging_last_step(rigcal_paper_solver *s)
{
    judge(s);
    finish(s, s->nm.status == RIGCAL_BUDGET_SPENT);
}

/* Evaluates one node of the grid. */
static void seed_step(rigcal_paper_solver *s)
{
    rigcal_real angles[3] = {0, 0, 0};
    grid_node(angles, s->next);
    s->evals++;
    remember_seed(s, s->next, objective(s, angles));
    s->next++;
    if (s->next == GRID_NODES) {
        s->next = 0;
        start_seed(s);
    }
}

/* Does one evaluation of a simplex search. */
static void search_step(rigcal_paper_solver *s)
{
    s->evals++;
    rc_neldermead_tell(&s->nm, objective(s, s->nm.trial.x));
    if (s->nm.status == RIGCAL_RUNNING) {
        return;
    }
    if (s->phase == SEARCHING_SEED) {
        s->phase = JUDGING_SEED;
    } else {
        end_last(s);
    }
}

static rigcal_status outcome(const rigcal_paper_solver *s)
{
    if (!s->found) {
        return (s->behind && s->options.use_guess) ? RIGCAL_ERR_BEHIND : RIGCAL_ERR_NO_POSE;
    }
    return s->spent ? RIGCAL_BUDGET_SPENT : RIGCAL_OK;
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_paper_defaults(rigcal_paper_options *options)
{
    if (options == NULL) {
        return RIGCAL_ERR_NULL;
    }
    *options = (rigcal_paper_options){2, RIGCAL_BEST_CONDITIONED, 0, 0, 0, {0, 0, 0}, 0, 0};
    return RIGCAL_OK;
}

static rigcal_status check_options(const rigcal_paper_options *o)
{
    if (!rc_all_finite(o->guess_ypr, 3) || !rc_is_finite(o->xtol) ||
        !rc_is_finite(o->ftol)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    const int counts_ok = (o->angles == 2 || (o->angles == 3 && o->use_guess)) &&
                          (o->pairs_used == 0 || o->pairs_used == 2) &&
                          (o->use_guess == 0 || o->use_guess == 1);
    const int32_t least_evals = o->use_guess ? 1 : GRID_NODES + SEED_EVALS_MAX;
    const int numbers_ok =
        (o->max_evals == 0 || o->max_evals >= least_evals) && o->xtol >= 0 && o->ftol >= 0;
    return (counts_ok && numbers_ok && o->eliminated >= RIGCAL_YAW &&
            o->eliminated <= RIGCAL_BEST_CONDITIONED &&
            rc_all_within(o->guess_ypr, 3, GUESS_MAX))
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

static void fill_defaults(rigcal_paper_options *o)
{
    if (o->max_evals == 0) {
        o->max_evals = o->use_guess ? DEFAULT_EVALS
                                    : GRID_NODES + SEEDS * SEED_EVALS_MAX + DEFAULT_EVALS;
    }
    if (!(o->xtol > 0)) {
        o->xtol = DEFAULT_TOL;
    }
    if (!(o->ftol > 0)) {
        o->ftol = DEFAULT_TOL;
    }
}

rigcal_status rigcal_paper_begin(rigcal_paper_solver *solver,
                                 const rigcal_bearing bearings[], size_t n,
                                 const rigcal_pair pairs[], size_t n_pairs,
                                 const rigcal_paper_options *options)
{
    if (solver == NULL || bearings == NULL || pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_paper_options chosen;
    (void)rigcal_paper_defaults(&chosen);
    if (options != NULL) {
        chosen = *options;
    }
    rigcal_status status = check_options(&chosen);
    if (status == RIGCAL_OK && n < 3) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK) {
        status = rc_check_bearings(bearings, n, 1);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pairs, n_pairs, 3);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    fill_defaults(&chosen);

    rigcal_paper_solver *const s = solver;
    *s = (rigcal_paper_solver){0};
    s->bearings = bearings;
    s->n = n;
    s->pairs = pairs;
    s->n_pairs = n_pairs;
    s->options = chosen;
    s->phase = SEEDING;
    for (int i = 0; i < SEEDS; i++) {
        s->seed_cost[i] = RC_MAX;
    }
    s->least_condition = RC_MAX;
    s->eliminated = chosen.eliminated;
    if (chosen.eliminated == RIGCAL_BEST_CONDITIONED) {
        s->eliminated = RIGCAL_YAW;
        for (int32_t e = RIGCAL_YAW; chosen.use_guess && e <= RIGCAL_ROLL; e++) {
            consider(s, e, chosen.guess_ypr);
        }
    }
    if (chosen.use_guess) {
        start_last(s, chosen.guess_ypr);
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_paper_step(rigcal_paper_solver *solver, int32_t budget)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (solver->phase <= NOT_BEGUN || solver->phase > DONE) {
        return RIGCAL_ERR_STATE;
    }
    for (int32_t i = 0; i < budget && solver->phase != DONE; i++) {
        switch (solver->phase) {
        case SEEDING:
            seed_step(solver);
            break;
        case JUDGING_SEED:
            judging_seed_step(solver);
            break;
        case CONDITIONING:
            conditioning_step(solver);
            break;
        case JUDGING_LAST:
            judging_last_step(solver);
            break;
        default:
            search_step(solver);
            break;
        }
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_paper_result(rigcal_paper_pose *pose,
                                  const rigcal_paper_solver *solver)
{
    if (pose == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    const rigcal_status status = outcome(solver);
    if (status >= 0) {
        *pose = solver->best;
        pose->evals = solver->evals;
        pose->starts = solver->starts;
    }
    return status;
}

rigcal_status rigcal_paper_solve(rigcal_paper_pose *pose, const rigcal_bearing bearings[],
                                 size_t n, const rigcal_pair pairs[], size_t n_pairs,
                                 const rigcal_paper_options *options)
{
    if (pose == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_paper_solver solver;
    rigcal_status status =
        rigcal_paper_begin(&solver, bearings, n, pairs, n_pairs, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (solver.phase != DONE) {
        (void)rigcal_paper_step(&solver, INT32_MAX);
    }
    return rigcal_paper_result(pose, &solver);
}
