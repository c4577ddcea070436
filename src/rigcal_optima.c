#include "rc_optima.h"

void rc_optimum_transform(rigcal_transform *cam_from_points, const rigcal_optimum *optimum)
{
    const rigcal_real *const x = &optimum->rows[0], *const y = &optimum->rows[3];
    rc_vec3_copy(&cam_from_points->R[0], x);
    rc_vec3_copy(&cam_from_points->R[3], y);
    rc_vec3_cross(&cam_from_points->R[6], x, y);
    rc_vec3_copy(cam_from_points->t, optimum->t);
}

/* The squared differences of the elements of two rotations sum to 8 sin^2(angle / 2). */
RC_APART int32_t rc_optima_near(const rigcal_optima *optima, const rigcal_real R[9],
                                rigcal_real angle)
{
    RIGCAL_ASSERT(angle > 0);
    for (int32_t i = 0; i < optima->n; i++) {
        rigcal_transform other;
        rigcal_real sum = 0;
        rc_optimum_transform(&other, &optima->list[i]);
        for (int k = 0; k < 9; k++) {
            sum += (other.R[k] - R[k]) * (other.R[k] - R[k]);
        }
        if (sum < 2 * angle * angle) {
            return i;
        }
    }
    return -1;
}

int32_t rc_optima_insert(rigcal_optima *optima, int32_t same,
                         const rigcal_transform *cam_from_points, rigcal_real sse)
{
    RIGCAL_ASSERT(same >= -1 && same < optima->n && sse >= 0);
    rigcal_optimum *const list = optima->list;
    int32_t at = same;
    if (at < 0) {
        at = optima->n;
        if (at < RIGCAL_POSES_MAX) {
            optima->n++;
        } else if (!(sse < list[--at].sse)) {
            return -1;
        }
    }
    for (; at > 0 && sse < list[at - 1].sse; at--) {
        list[at] = list[at - 1];
    }
    rc_vec3_copy(&list[at].rows[0], &cam_from_points->R[0]);
    rc_vec3_copy(&list[at].rows[3], &cam_from_points->R[3]);
    rc_vec3_copy(list[at].t, cam_from_points->t);
    list[at].sse = sse;
    return at;
}
