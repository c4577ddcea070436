/* cli_covariance.h - the covariances in rig.csv: of each camera, and between cameras. */
#ifndef RIGCAL_CLI_COVARIANCE_H
#define RIGCAL_CLI_COVARIANCE_H

#include "cli_input.h"

/* Columns S11, S21, S22, ..., S66, the lower triangle row by row. */
enum { CLI_COVARIANCE_COLUMNS = 21 };

/* Whether the file has them. */
int cli_covariance_find(size_t columns[CLI_COVARIANCE_COLUMNS], const csv_table *table);

/* Reads the covariance of one line. Ends the program if it is not a covariance. Returns
 * RIGCAL_CAMERA_HELD if it is 0, else RIGCAL_CAMERA_PRIOR. */
uint8_t cli_covariance_read(rigcal_real Sigma[36], const csv_table *table, size_t row,
                            const size_t columns[CLI_COVARIANCE_COLUMNS]);

/* The name "S21@NAME": the covariance of element 2 of (w, dt) of the camera of a line with
 * element 1 of camera NAME. The arguments count elements from 0. */
const char *cli_covariance_between(int row, int column, const char *name);

/* The joint covariance of n cameras: the lower triangle row by row. lines[i]: the line of
 * camera i in the file; own[i]: its own covariance. NULL if the file lacks the covariance
 * of two of them. */
rigcal_real *cli_covariance_joint(const cli_transforms *file, const size_t *lines,
                                  const rigcal_real *const *own, size_t n);

/* px: the least and the largest noise that is accepted. */
#define RIGCAL_CLI_SIGMA_LEAST 1e-6
#define RIGCAL_CLI_SIGMA_MOST 1e6

/* All that rig.csv says. The cameras are in the order of its lines. */
typedef struct {
    cli_transforms file;
    size_t *camera;            /* for each: its number in cameras.csv */
    rigcal_calibrated_rig rig; /* sigma_px 0: there is no joint covariance */
    rigcal_real *sigma_px;     /* for each camera: noise by its residuals; NULL: not
                                  known */
    rigcal_real noise_px;      /* noise of a pixel, by the views at their own poses; 0: not
                                  known */
} cli_rig;

/* sigma_px is that of --sigma, which counts for all cameras; 0: not given. */
void cli_rig_read(cli_rig *rig, const char *path, const cli_cameras *cameras,
                  double sigma_px);

/* Tells the user that a file has no joint covariance, and what follows from that. */
void cli_rig_tell_exact(const cli_rig *rig);

#endif
