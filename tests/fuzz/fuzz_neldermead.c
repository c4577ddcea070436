/* Nelder-Mead on costs made from the bytes: quadratic at first, then any numbers. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum { EVALS_MOST = 400 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const int32_t k = fuzz_below(&bytes, 5);
    const int is_simplex = fuzz_below(&bytes, 2);
    const int32_t max_evals = fuzz_below(&bytes, 256) - 1;
    rigcal_real start[16], xtol, ftol, x[3], best[3], least = 0, cost;
    rigcal_neldermead search;
    rigcal_status status;
    int32_t evals, told = 0;
    int i;

    memset(start, 0, sizeof start);
    fuzz_reals(start, is_simplex ? 12 : 3, &bytes);
    xtol = fuzz_real(&bytes);
    ftol = fuzz_real(&bytes);
    MARK(search);
    status = is_simplex
                 ? rigcal_neldermead_begin_simplex(&search, start, k, xtol, ftol, max_evals)
                 : rigcal_neldermead_begin(&search, start, k, xtol, ftol, max_evals);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, search);
    PROMISE((k >= 1 && k <= 3 && max_evals >= 1 && xtol >= 0 && ftol >= 0) || status < 0);
    if (status < 0) {
        return 0;
    }
    MARK(best);
    PROMISE(rigcal_neldermead_result(best, NULL, NULL, &search) == RIGCAL_ERR_STATE);
    PROMISE(IS_MARKED(best));
    while ((status = rigcal_neldermead_ask(x, &search)) == RIGCAL_RUNNING) {
        PROMISE(told < max_evals);
        if (fuzz_is_empty(&bytes)) {
            cost = 0;
            for (i = 0; i < k; i++) {
                cost += x[i] * x[i];
            }
        } else {
            cost = fuzz_real(&bytes);
        }
        if (isfinite(cost) && (told == 0 || !(least <= cost))) {
            least = cost;
        } else if (told == 0) {
            least = (rigcal_real)INFINITY;
        }
        status = rigcal_neldermead_tell(&search, cost);
        PROMISE(status == RIGCAL_RUNNING || status == RIGCAL_OK);
        told++;
    }
    PROMISE(status == RIGCAL_OK);
    PROMISE(rigcal_neldermead_tell(&search, 0) == RIGCAL_ERR_STATE);
    status = rigcal_neldermead_result(best, &cost, &evals, &search);
    PROMISE(status == RIGCAL_OK || status == RIGCAL_BUDGET_SPENT ||
            status == RIGCAL_ERR_NOT_FINITE);
    if (status >= 0) {
        PROMISE(evals == told && cost >= least);
        /* The result must be the best of all costs, unless the evaluations ended at a
         * reflection. */
        PROMISE(cost <= least || status == RIGCAL_BUDGET_SPENT);
    } else { /* such a reflection may have the only finite cost */
        PROMISE(!isfinite(least) || told == max_evals);
    }
    return 0;
}
