/* cli_band.h - the band of rigcal line: where the match of a pixel can be, and how surely.
 * */
#ifndef RIGCAL_CLI_BAND_H
#define RIGCAL_CLI_BAND_H

#include "cli.h"
#include "cli_covariance.h"

typedef struct {
    const cli_rig *rig;
    size_t a, b; /* numbers of the two cameras in the rig */
    rigcal_real uv_a[2];
    rigcal_real near_a, far_a; /* distances along the ray; far_a = 0: no limit */
    const char *probability;   /* text of --probability; NULL: 0.99, and no spans */
    const char *candidates;    /* path of the file; NULL: none */
} cli_band;

/* Ends the program if what is asked for needs the noise of a pixel and that is not
 * known. */
void cli_band_check(const cli_band *band);

/* Prints the lines "band", "span" and "candidate". Says what cannot be computed. Returns
 * the exit status. */
int cli_band_print(const cli_band *band);

#endif
