#include "rc_rotation.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: how far elements and rows of a rotation may be off. It allows for a rotation that was
 * written to a file with seven digits, but not for one that scales or shears. */
#define ROTATION_TOL RC_TOL(1e-6, 1e-3)

/* cosine of pitch: at or below it yaw and roll turn about the same axis, and only their sum
 * is known. */
#define GIMBAL_COS (4 * RC_EPS)

/* 1: a matrix whose largest element is 1 is singular to rounding if its determinant is no
 * more. */
#define SINGULAR_DET (64 * RC_EPS)

/* iterations: the most to find the nearest rotation, usually 4 to 8. */
enum { POLAR_ITERATIONS_MAX = 40 };

/* 1: the iteration ends if no element changes more. It converges quadratically: the next
 * change would be near the square of this, which is below rounding. */
#define POLAR_END RC_TOL(1e-9, 1e-4)

/* The cofactors of a rotation are the rotation itself, and each of its rows has length
 * 1. */
int rc_is_rotation(const rigcal_real R[9])
{
    rigcal_real off[9];
    (void)rc_mat3_cofactors(off, R);
    int is_one = 1;
    for (int i = 0; i < 9; i += 3) {
        rc_vec3_sub(&off[i], &off[i], &R[i]);
        is_one = is_one && RC_FABS(rc_vec3_dot(&R[i], &R[i]) - 1) <= ROTATION_TOL;
    }
    return is_one && rc_all_within(off, 9, ROTATION_TOL);
}

rigcal_status rc_check_rotation(const rigcal_real R[9])
{
    if (R == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(R, 9)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return rc_is_rotation(R) ? RIGCAL_OK : RIGCAL_ERR_ROTATION;
}

/* Rotation about axis c, from a to b, where (a, b, c) is a cyclic triple. */
static void rotation_about(rigcal_real R[9], int a, int b, int c, rigcal_real angle)
{
    const rigcal_real cosine = RC_COS(angle), sine = RC_SIN(angle);
    for (int i = 0; i < 9; i++) {
        R[i] = 0;
    }
    R[3 * a + a] = cosine;
    R[3 * a + b] = -sine;
    R[3 * b + a] = sine;
    R[3 * b + b] = cosine;
    R[3 * c + c] = 1;
}

void rc_rotation_x(rigcal_real R[9], rigcal_real angle)
{
    rotation_about(R, 1, 2, 0, angle);
}

void rc_rotation_y(rigcal_real R[9], rigcal_real angle)
{
    rotation_about(R, 2, 0, 1, angle);
}

void rc_rotation_z(rigcal_real R[9], rigcal_real angle)
{
    rotation_about(R, 0, 1, 2, angle);
}

/* (8) */
void rc_rotation_from_yaw_pitch_roll(rigcal_real R[9], const rigcal_real ypr[3])
{
    RIGCAL_ASSERT(rc_all_finite(ypr, 3));
    const rigcal_real cy = RC_COS(ypr[0]), sy = RC_SIN(ypr[0]);
    const rigcal_real cp = RC_COS(ypr[1]), sp = RC_SIN(ypr[1]);
    const rigcal_real cr = RC_COS(ypr[2]), sr = RC_SIN(ypr[2]);

    R[0] = cy * cp;
    R[1] = cy * sp * sr - sy * cr;
    R[2] = cy * sp * cr + sy * sr;
    R[3] = sy * cp;
    R[4] = sy * sp * sr + cy * cr;
    R[5] = sy * sp * cr - cy * sr;
    R[6] = -sp;
    R[7] = cp * sr;
    R[8] = cp * cr;
}

rigcal_real rc_angle(rigcal_real sine, rigcal_real cosine)
{
    const rigcal_real angle = RC_ATAN2(sine, cosine);
    return (angle <= -RC_PI) ? RC_PI : angle;
}

/* Roll comes from Rz(yaw)^T R, not from the third row. Near gimbal lock this row is
 * rounding, but the sum or difference of yaw and roll stays right. */
void rc_yaw_pitch_roll_from_rotation(rigcal_real ypr[3], const rigcal_real R[9])
{
    RIGCAL_ASSERT(rc_is_rotation(R));
    const rigcal_real cos_pitch = RC_SQRT(R[0] * R[0] + R[3] * R[3]);
    ypr[1] = RC_ATAN2(-R[6], cos_pitch);
    if (!(cos_pitch > GIMBAL_COS)) {
        ypr[0] = rc_angle(-R[1], R[4]);
        ypr[2] = 0;
        return;
    }
    ypr[0] = rc_angle(R[3], R[0]);
    const rigcal_real cy = R[0] / cos_pitch, sy = R[3] / cos_pitch;
    ypr[2] = rc_angle(sy * R[2] - cy * R[5], cy * R[4] - sy * R[1]);
}

void rc_rotation_from_quaternion(rigcal_real R[9], const rigcal_real q_wxyz[4])
{
    RIGCAL_ASSERT(rc_all_finite(q_wxyz, 4));
    rigcal_real q[4];
    const rigcal_real largest = rc_max(RC_FABS(q_wxyz[0]), rc_vec3_max_abs(&q_wxyz[1]));
    for (int i = 0; i < 4; i++) {
        q[i] = q_wxyz[i] / largest;
    }
    const rigcal_real w = q[0], x = q[1], y = q[2], z = q[3];
    const rigcal_real s = 2 / (w * w + x * x + y * y + z * z);

    R[0] = 1 - s * (y * y + z * z);
    R[1] = s * (x * y - w * z);
    R[2] = s * (x * z + w * y);
    R[3] = s * (x * y + w * z);
    R[4] = 1 - s * (x * x + z * z);
    R[5] = s * (y * z - w * x);
    R[6] = s * (x * z - w * y);
    R[7] = s * (y * z + w * x);
    R[8] = 1 - s * (x * x + y * y);
}

/* Shepperd (1978): the largest of w, x, y, z comes from the diagonal, so no small number
 * divides. */
void rc_quaternion_from_rotation(rigcal_real q_wxyz[4], const rigcal_real R[9])
{
    RIGCAL_ASSERT(rc_is_rotation(R));
    const rigcal_real trace = R[0] + R[4] + R[8];
    int i = 0;
    for (int d = 1; d < 3; d++) {
        if (R[4 * d] > R[4 * i]) {
            i = d;
        }
    }
    rigcal_real *const v = &q_wxyz[1];
    if (trace >= R[4 * i]) {
        q_wxyz[0] = 1 + trace;
        v[0] = R[7] - R[5];
        v[1] = R[2] - R[6];
        v[2] = R[3] - R[1];
    } else {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        q_wxyz[0] = R[3 * k + j] - R[3 * j + k];
        v[i] = 1 + R[4 * i] - R[4 * j] - R[4 * k];
        v[j] = R[3 * i + j] + R[3 * j + i];
        v[k] = R[3 * i + k] + R[3 * k + i];
    }
    const rigcal_real length = RC_SQRT(q_wxyz[0] * q_wxyz[0] + rc_vec3_dot(v, v));
    const rigcal_real scale = (q_wxyz[0] < 0) ? -1 / length : 1 / length;
    for (int d = 0; d < 4; d++) {
        q_wxyz[d] *= scale;
    }
}

void rc_rotation_from_vector(rigcal_real R[9], const rigcal_real w[3])
{
    RIGCAL_ASSERT(rc_all_within(w, 3, RC_ANGLE_MAX));
    const rigcal_real angle = rc_vec3_norm(w);
    const rigcal_real half = angle / 2;
    const rigcal_real s = (angle > 0) ? RC_SIN(half) / angle : RC(0.5);
    const rigcal_real q_wxyz[4] = {RC_COS(half), s * w[0], s * w[1], s * w[2]};
    rc_rotation_from_quaternion(R, q_wxyz);
}

void rc_vector_from_rotation(rigcal_real w[3], const rigcal_real R[9])
{
    rigcal_real q_wxyz[4];
    rc_quaternion_from_rotation(q_wxyz, R);
    const rigcal_real sine = rc_vec3_norm(&q_wxyz[1]);
    const rigcal_real angle_by_sine = (sine > 0) ? 2 * RC_ATAN2(sine, q_wxyz[0]) / sine : 2;
    for (int i = 0; i < 3; i++) {
        w[i] = angle_by_sine * q_wxyz[1 + i];
    }
}

/* Uses sine and cosine of the angle. Where one of them is inaccurate the other is
 * accurate. */
rigcal_real rc_rotation_angle(const rigcal_real Ra[9], const rigcal_real Rb[9])
{
    rigcal_real Rba[9];
    rc_mat3_mul_t(Rba, Rb, Ra);
    const rigcal_real axis[3] = {Rba[7] - Rba[5], Rba[2] - Rba[6], Rba[3] - Rba[1]};
    return RC_ATAN2(rc_vec3_norm(axis), Rba[0] + Rba[4] + Rba[8] - 1);
}

void rc_rotation_tidy(rigcal_real R[9])
{
    (void)rc_vec3_unit(&R[0], &R[0]);
    rc_vec3_cross(&R[6], &R[0], &R[3]);
    (void)rc_vec3_unit(&R[6], &R[6]);
    rc_vec3_cross(&R[3], &R[6], &R[0]);
}

static rigcal_real frobenius(const rigcal_real M[9])
{
    return RC_SQRT(rc_vec3_dot(&M[0], &M[0]) + rc_vec3_dot(&M[3], &M[3]) +
                   rc_vec3_dot(&M[6], &M[6]));
}

/* Higham (1986): X <- (g X + X^-T / g) / 2 converges quadratically to the orthogonal polar
 * factor. g = sqrt(|X^-1| / |X|) speeds up a badly scaled start, and tends to 1. */
int rc_rotation_nearest(rigcal_real R[9], const rigcal_real M[9])
{
    rigcal_real X[9], cofactors[9];
    const rigcal_real largest = rc_max(
        rc_vec3_max_abs(&M[0]), rc_max(rc_vec3_max_abs(&M[3]), rc_vec3_max_abs(&M[6])));
    if (!(largest > 0)) {
        return 0;
    }
    for (int i = 0; i < 9; i++) {
        X[i] = M[i] / largest;
    }
    if (!(rc_mat3_cofactors(cofactors, X) > SINGULAR_DET)) {
        return 0;
    }
    for (int iteration = 0; iteration < POLAR_ITERATIONS_MAX; iteration++) {
        const rigcal_real det = rc_mat3_cofactors(cofactors, X);
        const rigcal_real g = RC_SQRT(frobenius(cofactors) / (det * frobenius(X)));
        rigcal_real change = 0;
        for (int i = 0; i < 9; i++) {
            const rigcal_real next = (g * X[i] + cofactors[i] / (g * det)) / 2;
            change = rc_max(change, RC_FABS(next - X[i]));
            X[i] = next;
        }
        if (change <= POLAR_END) {
            break;
        }
    }
    for (int i = 0; i < 9; i++) {
        R[i] = X[i];
    }
    return 1;
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check_angles(const rigcal_real out[], const rigcal_real a[3])
{
    if (out == NULL || a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(a, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return rc_all_within(a, 3, RC_ANGLE_MAX) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

rigcal_status rigcal_rotation_from_yaw_pitch_roll(rigcal_real R[9],
                                                  const rigcal_real ypr[3])
{
    const rigcal_status status = check_angles(R, ypr);
    if (status == RIGCAL_OK) {
        rc_rotation_from_yaw_pitch_roll(R, ypr);
    }
    return status;
}

rigcal_status rigcal_rotation_from_vector(rigcal_real R[9], const rigcal_real w[3])
{
    const rigcal_status status = check_angles(R, w);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!(rc_vec3_norm(w) <= RC_ANGLE_MAX)) {
        return RIGCAL_ERR_RANGE;
    }
    rc_rotation_from_vector(R, w);
    return RIGCAL_OK;
}

rigcal_status rigcal_rotation_from_quaternion(rigcal_real R[9], const rigcal_real q_wxyz[4])
{
    if (R == NULL || q_wxyz == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(q_wxyz, 4)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(RC_FABS(q_wxyz[0]) > 0 || rc_vec3_max_abs(&q_wxyz[1]) > 0)) {
        return RIGCAL_ERR_ROTATION;
    }
    rc_rotation_from_quaternion(R, q_wxyz);
    return RIGCAL_OK;
}

static rigcal_status check_out_of_rotation(const rigcal_real out[], const rigcal_real R[9])
{
    return (out == NULL) ? RIGCAL_ERR_NULL : rc_check_rotation(R);
}

rigcal_status rigcal_yaw_pitch_roll_from_rotation(rigcal_real ypr[3],
                                                  const rigcal_real R[9])
{
    const rigcal_status status = check_out_of_rotation(ypr, R);
    if (status == RIGCAL_OK) {
        rc_yaw_pitch_roll_from_rotation(ypr, R);
    }
    return status;
}

rigcal_status rigcal_vector_from_rotation(rigcal_real w[3], const rigcal_real R[9])
{
    const rigcal_status status = check_out_of_rotation(w, R);
    if (status == RIGCAL_OK) {
        rc_vector_from_rotation(w, R);
    }
    return status;
}

rigcal_status rigcal_quaternion_from_rotation(rigcal_real q_wxyz[4], const rigcal_real R[9])
{
    const rigcal_status status = check_out_of_rotation(q_wxyz, R);
    if (status == RIGCAL_OK) {
        rc_quaternion_from_rotation(q_wxyz, R);
    }
    return status;
}

rigcal_status rigcal_rotation_nearest(rigcal_real R[9], const rigcal_real M[9])
{
    if (R == NULL || M == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(M, 9)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return rc_rotation_nearest(R, M) ? RIGCAL_OK : RIGCAL_ERR_ROTATION;
}

rigcal_status rigcal_rotation_angle(rigcal_real *angle, const rigcal_real Ra[9],
                                    const rigcal_real Rb[9])
{
    if (angle == NULL || Ra == NULL || Rb == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_rotation(Ra);
    if (status == RIGCAL_OK) {
        status = rc_check_rotation(Rb);
    }
    if (status == RIGCAL_OK) {
        *angle = rc_rotation_angle(Ra, Rb);
    }
    return status;
}
