#include "rc_adjust.h"

/* ---- constants ----------------------------------------------------------- */

/* part of a pose: rounding of its numbers. If views agree to this, the join gains nothing
 * more and ends. */
#define POSE_ROUNDING (4 * RC_EPS)

/* ---- views by their own poses -------------------------------------------- */

/* The part of the sum of squares that comes from rounding of a view's pose. */
static rigcal_real negligible_of(const rigcal_view_pose *v)
{
    const rigcal_real *const H = v->information, *const by_dt = &H[RC_SYM6_SECOND];
    const rigcal_real *const t = v->cam_from_target.t;
    const rigcal_real sum =
        H[0] + H[3] + H[5] + (by_dt[0] + by_dt[3] + by_dt[5]) * rc_vec3_dot(t, t);
    return POSE_ROUNDING * POSE_ROUNDING * sum;
}

static rigcal_status check_pose(int32_t *camera, int32_t *placement, rigcal_rig_solver *s)
{
    rigcal_view_pose v;
    const rigcal_status status = rc_rig_pose_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = v.camera;
    *placement = v.placement;
    if (rc_rig_is_left_out(s->rig, s->view)) {
        return RIGCAL_OK;
    }
    s->negligible += negligible_of(&v);
    s->own_sum += v.sse;
    s->n_points += v.n;
    return rc_check_pose(&v);
}

/* The equations of a view from its own pose: the quadratic that its information makes about
 * this pose. */
static rigcal_status equations_of_pose(rigcal_real *sum, rigcal_real g[6],
                                       rigcal_real H[21], rc_chain *chain, int32_t *camera,
                                       const rigcal_rig_solver *s)
{
    rigcal_view_pose v;
    rigcal_real d[6];
    const rigcal_status status = rc_rig_pose_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = v.camera;
    rc_chain_of(chain, &s->rig->cams_from_rig[v.camera],
                &s->rig->rig_from_placements[s->placement]);
    rc_deviation(d, &v.cam_from_target, &chain->cam_from_target);
    for (int k = 0; k < 21; k++) {
        H[k] = v.information[k];
    }
    rc_sym6_mul(g, H, d);
    *sum = rc_vec3_dot(g, d) + rc_vec3_dot(&g[3], &d[3]);
    return RIGCAL_OK;
}

static const struct rigcal_rig_given GIVEN_POSES = {check_pose, equations_of_pose,
                                                    rc_rig_step, rc_rig_move, 1};

/* ---- where to start ------------------------------------------------------
 *
 * From what is fixed, cameras are reached by the view of most information that leads to
 * them, all that one placement apart first. parts->slot says of each camera whether it is
 * reached. */

/* The best way found so far to a camera that is not yet reached. */
typedef struct {
    rigcal_real information;
    rigcal_transform cam_from_rig;
} candidate;

static candidate *candidates_of(const rc_rig_parts *parts)
{
    return (candidate *)(void *)parts->W;
}

/* Places the placement by a view of a reached camera, if the view has more information than
 * those before it. s->gain is the information of the best view. */
static void place_by(rigcal_rig_solver *s, const rigcal_view_pose *v)
{
    const rigcal_real information = rc_view_information(v);
    if (information > s->gain) {
        rigcal_transform rig_from_cam;
        rc_transform_invert(&rig_from_cam, &s->rig->cams_from_rig[v->camera]);
        rc_transform_compose(&s->rig->rig_from_placements[s->placement], &rig_from_cam,
                             &v->cam_from_target);
        s->gain = information;
    }
}

/* Places a camera that is not reached by the placement and this view. The variances of both
 * views add up. */
static void reach_by(const rigcal_rig_solver *s, candidate *best, const rigcal_view_pose *v)
{
    const rigcal_real way = rc_information_of_both(s->gain, rc_view_information(v));
    if (way > best->information) {
        rigcal_transform placement_from_rig;
        rc_transform_invert(&placement_from_rig,
                            &s->rig->rig_from_placements[s->placement]);
        rc_transform_compose(&best->cam_from_rig, &v->cam_from_target, &placement_from_rig);
        best->information = way;
    }
}

static rigcal_status look_at_view(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    rigcal_view_pose v;
    if (rc_rig_is_left_out(s->rig, s->view)) {
        return RIGCAL_OK;
    }
    const rigcal_status status = rc_rig_pose_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    const int is_reached = parts->slot[v.camera] > 0;
    if (is_reached && s->phase == RC_RIG_PLACING) {
        place_by(s, &v);
    } else if (!is_reached && s->phase == RC_RIG_REACHING) {
        reach_by(s, &candidates_of(parts)[v.camera], &v);
    }
    return RIGCAL_OK;
}

/* Begins the next placement that has views, from s->placement on. Returns 0 if there is
 * none. */
static int begin_placement(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    while (s->placement < s->rig->n_placements &&
           rc_rig_views_of(parts, s->placement) == 0) {
        s->placement++;
    }
    s->first = s->view;
    s->gain = 0;
    s->phase = RC_RIG_PLACING;
    return s->placement < s->rig->n_placements;
}

static void begin_round(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    candidate *const best = candidates_of(parts);
    const size_t n = s->rig->n_cameras;
    for (size_t c = 0; c < n; c++) {
        best[c].information = 0;
    }
    s->view = s->placement = 0;
    (void)begin_placement(s, parts);
}

/* Begins with the cameras that are fixed. */
static void begin(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const rigcal_rig *const rig = s->rig;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_transform *const camera = &rig->cams_from_rig[c];
        parts->slot[c] = 1;
        if (rc_rig_has_prior(rig, c)) {
            *camera = rig->priors[c].cam_from_rig;
        } else if (rc_rig_is_held(rig, c)) {
            const rigcal_status status = rc_check_transform(camera);
            if (status != RIGCAL_OK) {
                rc_rig_end(s, status, -1);
                return;
            }
        } else {
            rc_transform_identity(camera); /* final only for the first camera of a group */
            parts->slot[c] = (parts->column[c] < 0) ? 1 : 0;
        }
    }
    begin_round(s, parts);
}

/* Takes the cameras that were reached. Begins another round if there were any. */
static void end_round(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const candidate *const best = candidates_of(parts);
    int is_more = 0;
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        if (best[c].information > 0) {
            s->rig->cams_from_rig[c] = best[c].cam_from_rig;
            parts->slot[c] = 1;
            is_more = 1;
        }
    }
    if (is_more) {
        begin_round(s, parts);
    } else {
        s->phase = RC_RIG_CHECKED;
        rc_rig_step(s);
    }
}

static void look_step(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const rigcal_status status = look_at_view(s, parts);
    if (status != RIGCAL_OK) {
        rc_rig_end(s, status, (int32_t)s->view);
        return;
    }
    s->view++;
    if (s->view - s->first < rc_rig_views_of(parts, s->placement)) {
        return;
    }
    if (s->phase == RC_RIG_PLACING && s->gain > 0) {
        s->view = s->first;
        s->phase = RC_RIG_REACHING;
        return;
    }
    s->placement++;
    if (!begin_placement(s, parts)) {
        end_round(s, parts);
    }
}

/* ---- steps --------------------------------------------------------------- */

static void step(rigcal_rig_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->n);
    if (s->phase == RC_RIG_CHECKED) {
        begin(s, &parts);
    } else if (s->phase == RC_RIG_PLACING || s->phase == RC_RIG_REACHING) {
        look_step(s, &parts);
    } else {
        rc_rig_step(s);
    }
}

rigcal_status rigcal_rig_join_begin(rigcal_rig_solver *solver, rigcal_rig *rig)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->view_poses == NULL && rig->view_pose_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    return (status == RIGCAL_OK) ? rc_rig_begin(solver, rig, &GIVEN_POSES) : status;
}

rigcal_status rigcal_rig_join_step(rigcal_rig_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (; budget > 0 && solver->phase != RC_RIG_DONE; budget--) {
        step(solver);
    }
    return (solver->phase == RC_RIG_DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_rig_join(rigcal_rig *rig, int32_t *at_fault)
{
    rigcal_rig_solver solver;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    const rigcal_status status = rigcal_rig_join_begin(&solver, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (solver.phase != RC_RIG_DONE) {
        step(&solver);
    }
    return rc_rig_outcome(at_fault, &solver);
}
