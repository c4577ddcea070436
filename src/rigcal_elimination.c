#include "rc_elimination.h"

/* ---- constants ----------------------------------------------------------- */

/* 1 / condition: if it is less, two pairs are singular to rounding. */
#define SINGULAR_TWO (4 * RC_EPS)

/* 1 / condition^2: if it is less, all pairs together are singular to rounding. */
#define SINGULAR_ALL (16 * RC_EPS)

/* ---- elimination --------------------------------------------------------- */

/* The eliminated angle turns axis a to axis b, and keeps axis c. */
typedef struct {
    int a, b, c;
} turned_axes;

static turned_axes axes_of(int32_t eliminated)
{
    switch (eliminated) {
    case RIGCAL_YAW:
        return (turned_axes){0, 1, 2};
    case RIGCAL_PITCH:
        return (turned_axes){2, 0, 1};
    default:
        return (turned_axes){1, 2, 0};
    }
}

/* R = L E(w) Q: L and Q are the factors left and right of the eliminated rotation E. */
typedef struct {
    rigcal_real L[9], Q[9];
    turned_axes axes;
} split_rotation;

/* R = Rz Ry Rx: pitch is left of an eliminated roll and right of an eliminated yaw. The
 * angle 0 leaves the eliminated factor out. */
static void split_at(split_rotation *split, int32_t eliminated, const rigcal_real angles[2])
{
    rigcal_real ypr[3], Rz[9], Ry[9], Rx[9];
    rc_angles_join(ypr, eliminated, angles, 0);
    rc_rotation_z(Rz, ypr[0]);
    rc_rotation_y(Ry, (eliminated == RIGCAL_ROLL) ? ypr[1] : 0);
    rc_mat3_mul(split->L, Rz, Ry);
    rc_rotation_y(Ry, (eliminated == RIGCAL_YAW) ? ypr[1] : 0);
    rc_rotation_x(Rx, ypr[2]);
    rc_mat3_mul(split->Q, Ry, Rx);
    split->axes = axes_of(eliminated);
}

/* (14): with m = L^T normal and v = Q offset,  e = p cos w + q sin w + k. */
static void coefficients(rigcal_real pqk[3], const rigcal_pair *pair,
                         const split_rotation *split)
{
    const turned_axes ax = split->axes;
    rigcal_real m[3], v[3];
    rc_mat3_tmul_vec3(m, split->L, pair->normal);
    rc_mat3_mul_vec3(v, split->Q, pair->offset);
    pqk[0] = m[ax.a] * v[ax.a] + m[ax.b] * v[ax.b];
    pqk[1] = m[ax.b] * v[ax.a] - m[ax.a] * v[ax.b];
    pqk[2] = m[ax.c] * v[ax.c];
}

void rc_angles_join(rigcal_real ypr[3], int32_t eliminated, const rigcal_real angles[],
                    rigcal_real w)
{
    RIGCAL_ASSERT(eliminated >= RIGCAL_YAW && eliminated <= RC_NONE_ELIMINATED);
    int next = 0;
    for (int i = 0; i < 3; i++) {
        ypr[i] = (i == eliminated) ? w : angles[next++];
    }
}

void rc_angles_split(rigcal_real angles[2], int32_t eliminated, const rigcal_real ypr[3])
{
    RIGCAL_ASSERT(eliminated >= RIGCAL_YAW && eliminated <= RIGCAL_ROLL);
    int next = 0;
    for (int i = 0; i < 3; i++) {
        if (i != eliminated) {
            angles[next++] = ypr[i];
        }
    }
}

/* Sums for the normal equations of A (c, s)^T = b over the first n_pairs pairs. */
typedef struct {
    rigcal_real pp, pq, qq, pk, qk;
} normal_sums;

static void sum_normals(normal_sums *sums, const rigcal_pair pairs[], size_t n_pairs,
                        const split_rotation *split)
{
    *sums = (normal_sums){0, 0, 0, 0, 0};
    for (size_t i = 0; i < n_pairs; i++) {
        rigcal_real pqk[3];
        coefficients(pqk, &pairs[i], split);
        sums->pp += pqk[0] * pqk[0];
        sums->pq += pqk[0] * pqk[1];
        sums->qq += pqk[1] * pqk[1];
        sums->pk += pqk[0] * pqk[2];
        sums->qk += pqk[1] * pqk[2];
    }
}

/* Larger eigenvalue of A^T A. */
static rigcal_real larger_eigenvalue(const normal_sums *sums)
{
    const rigcal_real half_gap = (sums->pp - sums->qq) / 2;
    return (sums->pp + sums->qq) / 2 + RC_SQRT(half_gap * half_gap + sums->pq * sums->pq);
}

/* Solves two equations with two unknowns by Cramer's rule on A itself, which keeps the
 * accuracy that A^T A would lose. cond(A) is the largest singular value squared over |det
 * A|. */
static int solve_two_pairs(rigcal_elimination *out, const rigcal_pair pairs[2],
                           const split_rotation *split)
{
    rigcal_real e[3], f[3];
    normal_sums sums;
    coefficients(e, &pairs[0], split);
    coefficients(f, &pairs[1], split);
    sum_normals(&sums, pairs, 2, split);
    const rigcal_real det = e[0] * f[1] - e[1] * f[0];
    const rigcal_real largest = larger_eigenvalue(&sums);
    if (!(RC_FABS(det) > SINGULAR_TWO * largest)) {
        return 0;
    }
    out->cosine = (e[1] * f[2] - f[1] * e[2]) / det;
    out->sine = (f[0] * e[2] - e[0] * f[2]) / det;
    out->condition = largest / RC_FABS(det);
    return 1;
}

static int solve_all_pairs(rigcal_elimination *out, const rigcal_pair pairs[],
                           size_t n_pairs, const split_rotation *split)
{
    normal_sums sums;
    sum_normals(&sums, pairs, n_pairs, split);
    const rigcal_real det = sums.pp * sums.qq - sums.pq * sums.pq;
    const rigcal_real largest = larger_eigenvalue(&sums);
    if (!(det > SINGULAR_ALL * largest * largest)) {
        return 0;
    }
    out->cosine = (sums.pq * sums.qk - sums.qq * sums.pk) / det;
    out->sine = (sums.pq * sums.pk - sums.pp * sums.qk) / det;
    out->condition = largest / RC_SQRT(det);
    return 1;
}

rigcal_status rc_eliminate(rigcal_elimination *out, const rigcal_pair pairs[],
                           size_t n_pairs, int32_t pairs_used, int32_t eliminated,
                           const rigcal_real angles[2])
{
    RIGCAL_ASSERT(eliminated >= RIGCAL_YAW && eliminated <= RIGCAL_ROLL);
    RIGCAL_ASSERT(n_pairs >= 2 && (pairs_used == 0 || pairs_used == 2));
    split_rotation split;
    rigcal_elimination found;
    split_at(&split, eliminated, angles);
    const int solved = (pairs_used == 2) ? solve_two_pairs(&found, pairs, &split)
                                         : solve_all_pairs(&found, pairs, n_pairs, &split);
    if (!solved) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real c = found.cosine, s = found.sine;
    const rigcal_real length = RC_SQRT(c * c + s * s);
    if (!(length > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    found.angle = rc_angle(s, c);
    found.unit = c * c + s * s - 1; /* (15) */
    found.residual = RC_FABS(found.unit);
    for (size_t i = (size_t)pairs_used; i < n_pairs; i++) { /* (15): the pairs not used */
        rigcal_real pqk[3];
        coefficients(pqk, &pairs[i], &split);
        found.residual += RC_FABS((pqk[0] * c + pqk[1] * s) / length + pqk[2]);
    }
    *out = found;
    return RIGCAL_OK;
}

static rigcal_real pair_residual(const rigcal_pair *pair, const rigcal_real R[9])
{
    rigcal_real turned[3];
    rc_mat3_mul_vec3(turned, R, pair->offset);
    return rc_vec3_dot(pair->normal, turned);
}

rigcal_real rc_pairs_residual(const rigcal_pair pairs[], size_t n_pairs,
                              const rigcal_real ypr[3])
{
    rigcal_real R[9], sum = 0;
    rc_rotation_from_yaw_pitch_roll(R, ypr);
    for (size_t i = 0; i < n_pairs; i++) {
        sum += RC_FABS(pair_residual(&pairs[i], R));
    }
    return sum;
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_pair_residual(rigcal_real *e, const rigcal_pair *pair,
                                   const rigcal_real R[9])
{
    if (e == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_pairs(pair, 1, 1);
    if (status == RIGCAL_OK) {
        status = rc_check_rotation(R);
    }
    if (status == RIGCAL_OK) {
        *e = pair_residual(pair, R);
    }
    return status;
}

static rigcal_status check_two_angles(int32_t eliminated, const rigcal_real angles[2])
{
    if (angles == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(angles, 2)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (eliminated >= RIGCAL_YAW && eliminated <= RIGCAL_ROLL &&
            rc_all_within(angles, 2, RC_ANGLE_MAX))
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

rigcal_status rigcal_pair_coefficients(rigcal_real pqk[3], const rigcal_pair *pair,
                                       int32_t eliminated, const rigcal_real angles[2])
{
    if (pqk == NULL || pair == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_two_angles(eliminated, angles);
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pair, 1, 1);
    }
    if (status == RIGCAL_OK) {
        split_rotation split;
        split_at(&split, eliminated, angles);
        coefficients(pqk, pair, &split);
    }
    return status;
}

rigcal_status rigcal_pairs_eliminate(rigcal_elimination *out, const rigcal_pair pairs[],
                                     size_t n_pairs, int32_t pairs_used, int32_t eliminated,
                                     const rigcal_real angles[2])
{
    if (out == NULL || pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_two_angles(eliminated, angles);
    if (status == RIGCAL_OK && pairs_used != 0 && pairs_used != 2) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pairs, n_pairs, 3);
    }
    return (status == RIGCAL_OK)
               ? rc_eliminate(out, pairs, n_pairs, pairs_used, eliminated, angles)
               : status;
}

rigcal_status rigcal_pairs_residual(rigcal_real *residual, const rigcal_pair pairs[],
                                    size_t n_pairs, const rigcal_real ypr[3])
{
    if (residual == NULL || pairs == NULL || ypr == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(ypr, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!rc_all_within(ypr, 3, RC_ANGLE_MAX)) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status = rc_check_pairs(pairs, n_pairs, 3);
    if (status == RIGCAL_OK) {
        *residual = rc_pairs_residual(pairs, n_pairs, ypr);
    }
    return status;
}
