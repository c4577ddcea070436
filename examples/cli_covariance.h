/* cli_covariance.h - covariances of rig.csv: those of each camera, and those between. */
#ifndef RIGCAL_CLI_COVARIANCE_H
#define RIGCAL_CLI_COVARIANCE_H

#include "cli_input.h"

/* Columns S11, S21, S22, ..., S66, the lower triangle row by row. */
enum { CLI_COVARIANCE_COLUMNS = 21 };

/* Whether the file has them. */
int cli_covariance_find(size_t columns[CLI_COVARIANCE_COLUMNS], const csv_table *table);

/* Of one line, which ends the program if it is no covariance. RIGCAL_CAMERA_HELD: it is 0;
 * else RIGCAL_CAMERA_PRIOR. */
uint8_t cli_covariance_read(rigcal_real Sigma[36], const csv_table *table, size_t row,
                            const size_t columns[CLI_COVARIANCE_COLUMNS]);

/* "S21@NAME": covariance of element 2 of (w, dt) of a line's camera with element 1 of that
 * of camera NAME. Elements count from 0 here. */
const char *cli_covariance_between(int row, int column, const char *name);

/* px: what a noise may be. */
#define RIGCAL_CLI_SIGMA_LEAST 1e-6
#define RIGCAL_CLI_SIGMA_MOST 1e6

/* rig.csv with all that it tells. Cameras are in the order of its lines. */
typedef struct {
    cli_transforms file;
    size_t *camera;            /* the number of each in cameras.csv */
    rigcal_calibrated_rig rig; /* sigma_px 0: there is no joint covariance */
    rigcal_real *sigma_px;     /* of each camera by its residuals; NULL: not known */
    rigcal_real noise_px;      /* of a pixel, by the views by themselves; 0: not known */
} cli_rig;

/* sigma_px: of --sigma, which counts for all cameras; 0: it is not given. */
void cli_rig_read(cli_rig *rig, const char *path, const cli_cameras *cameras,
                  double sigma_px);

/* Says that a file has no joint covariance, and what follows. */
void cli_rig_tell_exact(const cli_rig *rig);

#endif
