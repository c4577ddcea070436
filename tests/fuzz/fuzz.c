#include "fuzz.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- promises --------------------------------------------------------------- */

void fuzz_broken(const char *promise, const char *file, int line)
{
    fprintf(stderr, "%s:%d: a promise is broken: %s\n", file, line, promise);
    abort();
}

enum { MARK_BYTE = 0xA5 };

void fuzz_mark(void *output, size_t size)
{
    memset(output, MARK_BYTE, size);
}

int fuzz_is_marked(const void *output, size_t size)
{
    const uint8_t *bytes = output;

    return size == 0 || (bytes[0] == MARK_BYTE && memcmp(bytes, bytes + 1, size - 1) == 0);
}

int fuzz_is_status(rigcal_status status)
{
    return strcmp(rigcal_status_name(status), rigcal_status_name(INT32_MAX)) != 0;
}

int fuzz_all_finite(const rigcal_real x[], size_t n)
{
    size_t i;

    for (i = 0; i < n; i++) {
        if (!isfinite(x[i])) {
            return 0;
        }
    }
    return 1;
}

int fuzz_is_rotation(const rigcal_real R[9], double tolerance)
{
    double determinant = 0;
    int i, j, k;

    if (!fuzz_all_finite(R, 9)) {
        return 0;
    }
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            double dot = i == j ? -1 : 0;

            for (k = 0; k < 3; k++) {
                dot += (double)R[3 * k + i] * (double)R[3 * k + j];
            }
            if (!(fabs(dot) <= tolerance)) {
                return 0;
            }
        }
        j = (i + 1) % 3;
        k = (i + 2) % 3;
        determinant += (double)R[i] * ((double)R[3 + j] * (double)R[6 + k] -
                                       (double)R[3 + k] * (double)R[6 + j]);
    }
    return fabs(determinant - 1) <= tolerance;
}

int fuzz_is_transform(const rigcal_transform *b_from_a)
{
    return fuzz_is_rotation(b_from_a->R, FUZZ_TOL(1e-12, 1e-5)) &&
           fuzz_all_finite(b_from_a->t, 3);
}

int fuzz_is_covariance(const rigcal_real Sigma[], int n, double slack)
{
    int i, j;

    if (!fuzz_all_finite(Sigma, (size_t)n * (size_t)n)) {
        return 0;
    }
    for (i = 0; i < n; i++) {
        if (!(Sigma[i * n + i] >= 0)) {
            return 0;
        }
        for (j = 0; j < i; j++) {
            const double a = (double)Sigma[i * n + i], b = (double)Sigma[j * n + j];
            const double s = (double)Sigma[i * n + j], t = (double)Sigma[j * n + i];
            const double least =
                FUZZ_TOL(DBL_MIN, (double)FLT_MIN); /* may underflow to 0 */
            const double most = sqrt(fmax(a, least)) * sqrt(fmax(b, least)) * (1 + slack);

            if (!(fabs(s) <= most) || !(fabs(s - t) <= slack * most)) {
                return 0;
            }
        }
    }
    return 1;
}

/* ---- arguments from bytes ----------------------------------------------------- */

int fuzz_is_empty(const fuzz_bytes *bytes)
{
    return bytes->next == bytes->end;
}

uint8_t fuzz_byte(fuzz_bytes *bytes)
{
    return fuzz_is_empty(bytes) ? 0 : *bytes->next++;
}

uint32_t fuzz_word(fuzz_bytes *bytes)
{
    uint32_t word = 0;
    int i;

    for (i = 0; i < 4; i++) {
        word |= (uint32_t)fuzz_byte(bytes) << (8 * i);
    }
    return word;
}

int32_t fuzz_below(fuzz_bytes *bytes, int32_t most)
{
    return fuzz_byte(bytes) % most;
}

rigcal_real fuzz_real(fuzz_bytes *bytes)
{
    const uint32_t low = fuzz_word(bytes);
    const uint64_t bits = (uint64_t)fuzz_word(bytes) << 32 | low;
    double x;

    memcpy(&x, &bits, sizeof x);
    if (fabs(x) > (double)FLT_MAX && isfinite(x) && sizeof(rigcal_real) == 4) {
        return (rigcal_real)(x > 0 ? INFINITY : -INFINITY); /* the cast would be
                                                               undefined */
    }
    return (rigcal_real)x;
}

void fuzz_reals(rigcal_real x[], size_t n, fuzz_bytes *bytes)
{
    size_t i;

    for (i = 0; i < n; i++) {
        x[i] = fuzz_real(bytes);
    }
}

void fuzz_rotation(rigcal_real R[9], fuzz_bytes *bytes)
{
    rigcal_real w[3];

    if (fuzz_byte(bytes) % 2 == 1) {
        fuzz_reals(R, 9, bytes);
        return;
    }
    fuzz_reals(w, 3, bytes);
    if (rigcal_rotation_from_vector(R, w) != RIGCAL_OK) {
        memset(R, 0, 9 * sizeof R[0]);
        R[0] = w[0];
        R[4] = R[8] = 1;
    }
}

void fuzz_transform(rigcal_transform *b_from_a, fuzz_bytes *bytes)
{
    fuzz_rotation(b_from_a->R, bytes);
    fuzz_reals(b_from_a->t, 3, bytes);
}

/* Reads the kind of lens, how many of its coefficients follow, and two words for the
 * size. */
void fuzz_camera(rigcal_camera *camera, fuzz_bytes *bytes)
{
    rigcal_real numbers[12] = {0};

    camera->lens = fuzz_below(bytes, 3);
    camera->width = (int32_t)fuzz_word(bytes);
    camera->height = (int32_t)fuzz_word(bytes);
    fuzz_reals(numbers, 4 + (size_t)fuzz_below(bytes, 9), bytes);
    fuzz_camera_set(camera, numbers);
}

void fuzz_view(rigcal_view *view, rigcal_camera *camera, rigcal_observation observations[],
               rigcal_real sigma[], size_t capacity, fuzz_bytes *bytes)
{
    size_t i;

    fuzz_camera(camera, bytes);
    view->camera = camera;
    view->observations = observations;
    view->n = (size_t)fuzz_below(bytes, (int32_t)capacity + 1);
    view->sigma = fuzz_byte(bytes) % 4 == 3 ? sigma : NULL;
    for (i = 0; i < view->n; i++) {
        fuzz_reals(observations[i].X_w, 3, bytes);
        fuzz_reals(observations[i].uv, 2, bytes);
        if (view->sigma != NULL) {
            sigma[i] = fuzz_real(bytes);
        }
    }
}

fuzz_budget fuzz_budget_of(fuzz_bytes *bytes)
{
    fuzz_budget budget;

    budget.before = 1;
    budget.last = 1 + fuzz_byte(bytes);
    return budget;
}

int32_t fuzz_budget_next(fuzz_budget *budget)
{
    const int32_t next = budget->last;

    budget->last = next < 100000 ? budget->before + next : 1;
    budget->before = next;
    return next;
}
