/* fuzz.h - what the fuzz harnesses share: arguments made from bytes, and promises.
 *
 * A harness is one function, which libFuzzer calls with bytes of its own making. It reads
 * arguments from them, calls the library, and checks what the public headers promise for
 * any input. The sanitizers watch the memory meanwhile.
 *
 * A number is the eight bytes of a double, so NaN, infinity and denormals are as likely as
 * the mutation makes them. Bytes that are missing read as zero. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>
#include <stdint.h>

#include "rigcal_paper.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* ---- promises --------------------------------------------------------------- */

/* Ends the program and prints the promise that was broken, with file and line. */
#define PROMISE(holds) \
    do { \
        if (!(holds)) { \
            fuzz_broken(#holds, __FILE__, __LINE__); \
        } \
    } while (0)
void fuzz_broken(const char *promise, const char *file, int line);

/* Marks an output before a call. After a negative status the mark must still be there ("a
 * negative one failed and wrote no output"). */
void fuzz_mark(void *output, size_t size);
int fuzz_is_marked(const void *output, size_t size);
#define MARK(output) fuzz_mark(&(output), sizeof(output))
#define IS_MARKED(output) fuzz_is_marked(&(output), sizeof(output))

/* `status` must be one of the library's. After a negative one `output` must be
 * untouched. */
#define PROMISE_UNTOUCHED(status, output) PROMISE((status) >= 0 || IS_MARKED(output))
int fuzz_is_status(rigcal_status status);

/* Whether all n numbers are finite. Whether R is a rotation to `tolerance`, which limits
 * each element of R^T R - I, and det R - 1. */
int fuzz_all_finite(const rigcal_real x[], size_t n);
int fuzz_is_rotation(const rigcal_real R[9], double tolerance);
int fuzz_is_transform(const rigcal_transform *b_from_a);

/* Whether a matrix n x n can be a covariance: finite, symmetric, no negative variance, and
 * no correlation beyond 1. `slack` is the part of the variances that rounding may cost. */
int fuzz_is_covariance(const rigcal_real Sigma[], int n, double slack);

/* The tolerance of a result that double computes to 1e-9, for the rounding of
 * rigcal_real. */
#define FUZZ_TOL(for_double, for_float) \
    (sizeof(rigcal_real) == 8 ? (for_double) : (for_float))

/* ---- arguments from bytes ----------------------------------------------------- */

typedef struct fuzz_bytes {
    const uint8_t *next, *end;
} fuzz_bytes;

int fuzz_is_empty(const fuzz_bytes *bytes);
uint8_t fuzz_byte(fuzz_bytes *bytes);
uint32_t fuzz_word(fuzz_bytes *bytes);               /* any 32 bits, little-endian */
int32_t fuzz_below(fuzz_bytes *bytes, int32_t most); /* 0 .. most - 1, from one byte */
rigcal_real fuzz_real(fuzz_bytes *bytes);            /* any, NaN and infinity included */
void fuzz_reals(rigcal_real x[], size_t n, fuzz_bytes *bytes);

/* A rotation from a rotation vector or, if the first byte is odd, from any nine numbers. */
void fuzz_rotation(rigcal_real R[9], fuzz_bytes *bytes);
void fuzz_transform(rigcal_transform *b_from_a, fuzz_bytes *bytes);
void fuzz_camera(rigcal_camera *camera, fuzz_bytes *bytes);

/* Sets the focal lengths, the principal point and the coefficients, in the order of their
 * names below. Inline, because fuzz_narrow.c is compiled with another rigcal_real. */
static inline void fuzz_camera_set(rigcal_camera *camera, const rigcal_real numbers[12])
{
    camera->fx = numbers[0];
    camera->fy = numbers[1];
    camera->cx = numbers[2];
    camera->cy = numbers[3];
    camera->k1 = numbers[4];
    camera->k2 = numbers[5];
    camera->p1 = numbers[6];
    camera->p2 = numbers[7];
    camera->k3 = numbers[8];
    camera->k4 = numbers[9];
    camera->k5 = numbers[10];
    camera->k6 = numbers[11];
}

/* A view of up to `capacity` points. sigma[capacity] is used if the bytes say so. */
void fuzz_view(rigcal_view *view, rigcal_camera *camera, rigcal_observation observations[],
               rigcal_real sigma[], size_t capacity, fuzz_bytes *bytes);

/* Budgets for the steps of a solver: from the bytes, then 1, 2, 3, 5, 8, and so on. */
typedef struct fuzz_budget {
    int32_t last, before;
} fuzz_budget;
fuzz_budget fuzz_budget_of(fuzz_bytes *bytes);
int32_t fuzz_budget_next(fuzz_budget *budget);

#endif /* FUZZ_H */
