#include "rc_roots.h"

/* ---- constants ----------------------------------------------------------- */

/* times the least sum of squared errors plus a pixel's square: a pose of three points is
 * ruled out if the other points are off by more than this. */
#define ROOT_WORSE RC(100)

/* of the longest side: the least width of a triple whose poses are starts. Of a narrower
 * triple, noise decides the turn about the longest side. */
#define NARROW RC(0.25)

/* ---- three points -------------------------------------------------------- */

/* Begins with three of the points. Returns 0 if they have no pose. */
RC_APART_FAST static int begin_poses(rigcal_p3p *P, const rigcal_points *points,
                                     const int32_t index[3], const rigcal_real ray[3][3])
{
    RIGCAL_ASSERT(index[0] != index[1] && index[0] != index[2] && index[1] != index[2]);
    RIGCAL_ASSERT(RC_IS_UNIT(ray[0]) && RC_IS_UNIT(ray[1]) && RC_IS_UNIT(ray[2]));
    for (int k = 0; k < 3; k++) {
        rc_points_at(P->work.x[k], points, (size_t)index[k]);
    }
    return rc_p3p_begin(P, ray);
}

/* Computes all poses. It works in *P. */
static int32_t poses_by(rigcal_transform cam_from_points[RC_P3P_MAX], rigcal_p3p *P,
                        const rigcal_points *points, const int32_t index[3],
                        const rigcal_real ray[3][3])
{
    int32_t n = 0;
    if (begin_poses(P, points, index, ray)) {
        while (n < RC_P3P_MAX && rc_p3p_next(&cam_from_points[n], P, ray)) {
            n++;
        }
    }
    return n;
}

int32_t rc_poses_of_three(rigcal_transform cam_from_points[RC_P3P_MAX],
                          const rigcal_points *points, const int32_t index[3],
                          const rigcal_real ray[3][3])
{
    rigcal_p3p P;
    return poses_by(cam_from_points, &P, points, index, ray);
}

int32_t rc_triple_poses(rigcal_transform cam_from_points[RC_P3P_MAX], rigcal_triple *triple,
                        const rigcal_points *points)
{
    return poses_by(cam_from_points, &triple->poses, points, triple->index,
                    (const rigcal_real(*)[3])triple->ray);
}

#if RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS
/* ---- the widest three ---------------------------------------------------- */

/* Takes the point farthest from the origin, the point farthest from that one, and the point
 * farthest from the line through both. Returns 0 if the last one is near that line. */
RC_APART static int widest_triple(int32_t index[3], const rigcal_points *points)
{
    rigcal_real from[3] = {0, 0, 0}, side[3] = {0, 0, 0}, x[3], across[3], most = -1;
    for (int k = 0; k < 3; k++) {
        most = -1;
        for (size_t i = rc_points_next(points, 0); i < points->view.n;
             i = rc_points_next(points, i + 1)) {
            rc_points_at(x, points, i);
            rc_vec3_sub(x, x, from);
            rc_vec3_cross(across, side, x);
            const rigcal_real far =
                (k < 2) ? rc_vec3_dot(x, x) : rc_vec3_dot(across, across);
            if (far > most) {
                most = far;
                index[k] = (int32_t)i;
            }
        }
        rc_points_at(x, points, (size_t)index[k]);
        if (k == 0) {
            rc_vec3_copy(from, x);
        } else if (k == 1) {
            rc_vec3_sub(side, x, from);
        }
    }
    const rigcal_real squared = rc_vec3_dot(side, side);
    return most > NARROW * NARROW * squared * squared;
}

/* The sum of the squared errors of the points other than the three of the triple. */
static rigcal_real sum_of_others(const rigcal_points *points, const rigcal_transform *T,
                                 const int32_t index[3])
{
    rigcal_real sum = 0;
    for (size_t i = rc_points_next(points, 0); i < points->view.n;
         i = rc_points_next(points, i + 1)) {
        const int32_t k = (int32_t)i;
        if (k != index[0] && k != index[1] && k != index[2]) {
            sum += rc_min(rc_points_error2(points, T, i), RC_MAX / ROOT_WORSE);
        }
    }
    return sum;
}

/* ---- the search ---------------------------------------------------------- */

/* The steps of the search, by their number in triple->count. */
enum { TRIPLE = 0, RAYS = 1, POSES = 4, SCORES = 5 };

/* Puts all poses of the triple into the list, without scores. Returns how many. */
RC_APART static uint8_t put_poses(rigcal_optima *optima, rigcal_triple *triple,
                                  const rigcal_points *points)
{
    const rigcal_real(*const ray)[3] = (const rigcal_real(*)[3])triple->ray;
    rigcal_transform root;
    uint8_t n = 0;
    if (begin_poses(&triple->poses, points, triple->index, ray)) {
        for (; n < RC_P3P_MAX && rc_p3p_next(&root, &triple->poses, ray); n++) {
            (void)rc_optima_insert(optima, -1, &root, (rigcal_real)n);
        }
    }
    optima->n = 0;
    return n;
}

RC_APART static void score(rigcal_optimum *pose, const rigcal_triple *triple,
                           const rigcal_points *points)
{
    rigcal_transform T;
    rc_optimum_transform(&T, pose);
    pose->sse = sum_of_others(points, &T, triple->index);
}

/* Sorts n scored poses, best first. Returns how many the others do not rule out. */
RC_APART static uint8_t rank(rigcal_optimum list[], int32_t n, rigcal_real pixel)
{
    uint8_t kept = 0;
    for (int32_t i = 1; i < n; i++) {
        const rigcal_optimum moved = list[i];
        int32_t at = i;
        for (; at > 0 && list[at - 1].sse > moved.sse; at--) {
            list[at] = list[at - 1];
        }
        list[at] = moved;
    }
    while (kept < n && list[kept].sse <= ROOT_WORSE * (list[0].sse + pixel * pixel)) {
        kept++;
    }
    return kept;
}

int rc_roots_step(rigcal_optima *optima, uint8_t *n_roots, rigcal_triple *triple,
                  const rigcal_points *points)
{
    RIGCAL_ASSERT(optima->n == 0 && points->n_used > 3);
    const int32_t step = triple->count++;
    if (step == TRIPLE) {
        return !widest_triple(triple->index, points);
    }
    if (step < POSES) {
        const int32_t k = step - RAYS;
        return rc_pixel_to_ray(triple->ray[k], points->view.camera,
                               points->view.observations[triple->index[k]].uv) != RIGCAL_OK;
    }
    if (step == POSES) {
        *n_roots = put_poses(optima, triple, points);
    } else {
        score(&optima->list[step - SCORES], triple, points);
    }
    if (step - POSES < *n_roots) {
        return 0;
    }
    *n_roots = rank(optima->list, *n_roots, points->pixel_size);
    return 1;
}
#endif
