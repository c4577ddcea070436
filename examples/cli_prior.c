/* What is known of the cameras beforehand: --prior and --hold. */
#include "cli_calibrate.h"
#include "cli_covariance.h"

#include <string.h>

/* Reads the names of --hold. These cameras become held. */
static void read_hold(known_cameras *known, const cli_cameras *cameras, const char *hold)
{
    char *name, *next;

    for (name = cli_text("%s", hold); name != NULL; name = next) {
        size_t camera;

        next = strchr(name, ',');
        if (next != NULL) {
            *next++ = '\0';
        }
        camera = cli_names_find(&cameras->names, name);
        if (camera == CLI_UNKNOWN) {
            cli_fail("--hold %s: this camera is not in %s", name, cameras->table.path);
        }
        if (known->role[camera] == RIGCAL_CAMERA_HELD) {
            cli_fail("--hold %s is given twice: give it once", name);
        }
        known->role[camera] = RIGCAL_CAMERA_HELD;
        known->n_held++;
    }
}

/* Reads the lines of --prior. Cameras of --hold need no covariance. */
static void read_prior(known_cameras *known, const cli_cameras *cameras, const char *path)
{
    cli_transforms *file = &known->file;
    size_t columns[CLI_COVARIANCE_COLUMNS], row, n_held = 0;
    int has_columns;

    cli_transforms_read(file, path, "camera", cameras);
    known->path = path;
    has_columns = cli_covariance_find(columns, &file->table);
    for (row = 0; row < file->table.n_rows; row++) {
        const size_t camera = cli_names_find(&cameras->names, file->names.name[row]);
        rigcal_camera_prior *prior = &known->prior[camera];

        known->line[camera] = row;
        prior->cam_from_rig = file->transform[row];
        if (known->role[camera] == RIGCAL_CAMERA_HELD) {
            n_held++;
        } else if (!has_columns) {
            csv_fail(&file->table, row,
                     "camera %s has no covariance, columns S11 to S66: add them, hold "
                     "the camera with --hold %s, or remove the line",
                     file->names.name[row], file->names.name[row]);
        } else {
            known->role[camera] =
                cli_covariance_read(prior->Sigma, &file->table, row, columns);
            known->n_prior += known->role[camera] == RIGCAL_CAMERA_PRIOR;
        }
    }
    if (n_held < known->n_held) {
        cli_fail("a camera of --hold has no line in %s, which must say where it is held",
                 path);
    }
}

void read_known(known_cameras *known, const cli_cameras *cameras, const char *prior,
                const char *hold, int has_sigma)
{
    static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    size_t i;

    known->role = cli_alloc(cameras->names.count, sizeof *known->role);
    known->line = cli_alloc(cameras->names.count, sizeof *known->line);
    known->prior = cli_alloc(cameras->names.count, sizeof *known->prior);
    for (i = 0; i < cameras->names.count; i++) {
        known->prior[i].cam_from_rig = IDENTITY;
    }
    if (hold != NULL) {
        read_hold(known, cameras, hold);
    }
    if (prior != NULL) {
        read_prior(known, cameras, prior);
    } else if (known->n_held > 1) {
        cli_fail("--hold of several cameras needs --prior FILE, which says where they are");
    }
    if (known->n_prior > 0 && !has_sigma) {
        cli_fail("--prior needs --sigma: the noise of a pixel weighs the observations "
                 "against the covariances of %s",
                 prior);
    }
}
