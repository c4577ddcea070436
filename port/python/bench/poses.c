/* The time of a pose in C, for poses.py: views of n points each from a file of reals.
 *
 *   bench FILE N_POINTS REPEATS    prints microseconds of one pose, of a processor */
#include "rigcal.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { CAMERA_REALS = 12 }; /* fx to k6, before the views */

/* Everything of the file: the camera, then the observations. */
static rigcal_observation *read_all(rigcal_camera *camera, const char *path, size_t *count)
{
    FILE *const file = fopen(path, "rb");
    rigcal_observation *all;
    long size;
    if (file == NULL || fseek(file, 0, SEEK_END) != 0 || (size = ftell(file)) < 0) {
        exit(1);
    }
    rewind(file);
    *count = ((size_t)size - CAMERA_REALS * sizeof(rigcal_real)) / sizeof *all;
    all = malloc((size_t)size);
    *camera =
        (rigcal_camera){RIGCAL_LENS_BROWN, 640, 480, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    if (all == NULL ||
        fread(&camera->fx, sizeof(rigcal_real), CAMERA_REALS, file) != CAMERA_REALS ||
        fread(all, sizeof *all, *count, file) != *count) {
        exit(1);
    }
    fclose(file);
    return all;
}

int main(int argc, char **argv)
{
    rigcal_camera camera;
    size_t count, failed = 0;
    if (argc != 4) {
        return 1;
    }
    rigcal_observation *const all = read_all(&camera, argv[1], &count);
    const size_t n = (size_t)atol(argv[2]), views = count / n;
    rigcal_pose *const poses = malloc(views * sizeof *poses);
    double best = 1e30;
    for (long repeat = atol(argv[3]); repeat > 0 && poses != NULL; repeat--) {
        const clock_t begin = clock();
        for (size_t k = 0; k < views; k++) {
            const rigcal_view view = {&camera, &all[k * n], NULL, n};
            size_t n_found;
            failed += rigcal_pose_solve(&poses[k], 1, &n_found, NULL, &view, NULL) != 0;
        }
        const double took = 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC;
        best = took / (double)views < best ? took / (double)views : best;
    }
    printf("%.3f %lu\n", best, (unsigned long)failed);
    free(poses);
    free(all);
    return 0;
}
