/* Rotations and transforms, with any numbers. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

#define TOLERANCE FUZZ_TOL(1e-12, 1e-5)

/* R must be a rotation, and its three other forms must give it again. */
static void check_forms(const rigcal_real R[9])
{
    rigcal_real ypr[3], w[3], q[4], back[9], angle;

    PROMISE(fuzz_is_rotation(R, TOLERANCE));
    PROMISE(rigcal_yaw_pitch_roll_from_rotation(ypr, R) == RIGCAL_OK);
    PROMISE(rigcal_rotation_from_yaw_pitch_roll(back, ypr) == RIGCAL_OK);
    PROMISE(rigcal_rotation_angle(&angle, back, R) == RIGCAL_OK);
    PROMISE(angle >= 0 &&
            angle < FUZZ_TOL(1e-7, 2e-3)); /* at gimbal lock an error is as large as its
                                              square root */
    PROMISE(rigcal_vector_from_rotation(w, R) == RIGCAL_OK);
    PROMISE(rigcal_rotation_from_vector(back, w) == RIGCAL_OK);
    PROMISE(rigcal_rotation_angle(&angle, back, R) == RIGCAL_OK);
    PROMISE(angle >= 0 && angle < FUZZ_TOL(1e-12, 1e-5));
    PROMISE(rigcal_quaternion_from_rotation(q, R) == RIGCAL_OK && q[0] >= 0);
    PROMISE(rigcal_rotation_from_quaternion(back, q) == RIGCAL_OK);
    PROMISE(rigcal_rotation_angle(&angle, back, R) == RIGCAL_OK);
    PROMISE(angle >= 0 && angle < FUZZ_TOL(1e-12, 1e-5));
}

static void check_rotation(rigcal_status status, rigcal_real R[9])
{
    PROMISE(fuzz_is_status(status) && status <= 0);
    if (status == RIGCAL_OK) {
        check_forms(R);
    } else {
        PROMISE(fuzz_is_marked(R, 9 * sizeof R[0]));
    }
    fuzz_mark(R, 9 * sizeof R[0]);
}

static void make_rotations(fuzz_bytes *bytes)
{
    rigcal_real x[9], R[9];

    MARK(R);
    fuzz_reals(x, 3, bytes);
    check_rotation(rigcal_rotation_from_yaw_pitch_roll(R, x), R);
    check_rotation(rigcal_rotation_from_vector(R, x), R);
    fuzz_reals(x, 4, bytes);
    check_rotation(rigcal_rotation_from_quaternion(R, x), R);
    fuzz_reals(x, 9, bytes);
    check_rotation(rigcal_rotation_nearest(R, x), R);
}

static void combine(fuzz_bytes *bytes)
{
    rigcal_transform b_from_a, c_from_b, c_from_a, a_from_b, again;
    rigcal_real X[3], X_b[3], X_c[3], one[3];
    rigcal_status status;

    fuzz_transform(&b_from_a, bytes);
    fuzz_transform(&c_from_b, bytes);
    fuzz_reals(X, 3, bytes);
    MARK(c_from_a);
    status = rigcal_transform_compose(&c_from_a, &c_from_b, &b_from_a);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, c_from_a);
    MARK(a_from_b);
    status = rigcal_transform_invert(&a_from_b, &b_from_a);
    PROMISE_UNTOUCHED(status, a_from_b);
    if (status == RIGCAL_OK) {
        PROMISE(fuzz_is_rotation(a_from_b.R, FUZZ_TOL(4e-6, 4e-3)));
        PROMISE(fuzz_all_finite(a_from_b.t, 3));
    }
    MARK(again);
    status = rigcal_transform_between(&again, &c_from_b, &b_from_a);
    PROMISE_UNTOUCHED(status, again);
    MARK(X_b);
    if (rigcal_transform_point(X_b, &b_from_a, X) != RIGCAL_OK) {
        PROMISE(IS_MARKED(X_b));
        return;
    }
    PROMISE(fuzz_all_finite(X_b, 3));
    if (rigcal_transform_point(X_c, &c_from_b, X_b) == RIGCAL_OK &&
        rigcal_transform_compose(&c_from_a, &c_from_b, &b_from_a) == RIGCAL_OK &&
        rigcal_transform_point(one, &c_from_a, X) == RIGCAL_OK) {
        const double size = fabs((double)X[0]) + fabs((double)X[1]) + fabs((double)X[2]) +
                            fabs((double)b_from_a.t[0]) + fabs((double)b_from_a.t[1]) +
                            fabs((double)b_from_a.t[2]) + fabs((double)c_from_b.t[0]) +
                            fabs((double)c_from_b.t[1]) + fabs((double)c_from_b.t[2]);
        int i;

        for (i = 0; i < 3; i++) { /* rotations must be right to 1e-6 (float: 1e-3), or are
                                     corrected here */
            PROMISE(fabs((double)X_c[i] - (double)one[i]) <= FUZZ_TOL(1e-5, 1e-2) * size);
        }
    }
}

enum { MEAN_MOST = 6 };

static void average(fuzz_bytes *bytes)
{
    rigcal_transform transforms[MEAN_MOST], mean;
    rigcal_real weight[MEAN_MOST], sigma_rad, sigma_t;
    const size_t n = (size_t)fuzz_below(bytes, MEAN_MOST + 1);
    const int is_weighted = fuzz_below(bytes, 2);
    rigcal_status status;
    size_t i;

    for (i = 0; i < n; i++) {
        fuzz_transform(&transforms[i], bytes);
        weight[i] = fuzz_real(bytes);
    }
    MARK(mean);
    MARK(sigma_rad);
    MARK(sigma_t);
    status = rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, transforms,
                                   is_weighted ? weight : NULL, n);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, mean);
    PROMISE_UNTOUCHED(status, sigma_rad);
    PROMISE_UNTOUCHED(status, sigma_t);
    if (status >= 0) {
        PROMISE(fuzz_is_transform(&mean));
        PROMISE(sigma_rad >= 0 && sigma_rad < 3.2 && sigma_t >= 0);
        PROMISE(fuzz_all_finite(&sigma_t, 1));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};

    switch (fuzz_below(&bytes, 3)) {
    case 0:
        make_rotations(&bytes);
        break;
    case 1:
        combine(&bytes);
        break;
    default:
        average(&bytes);
        break;
    }
    return 0;
}
