/* cli_input.h - the files of data/FORMAT.md, read and checked.
 *
 * As in cli_csv.h, whatever is wrong ends the program with "file:line: what". */
#ifndef RIGCAL_CLI_INPUT_H
#define RIGCAL_CLI_INPUT_H

#include "cli_csv.h"

/* Different names, numbered in order of first appearance. */
typedef struct {
    const char **name;
    size_t count;
    size_t room;
    uint32_t *slots; /* hash table: number + 1, or 0 */
    size_t n_slots;
    char *text; /* room for the text of names to come */
    size_t text_left;
} cli_names;

/* No names yet; number of a name, or CLI_UNKNOWN; number of one that is added, copied, if
 * it is new: it is, if the number equals the count there was. */
#define CLI_UNKNOWN ((size_t)-1)
void cli_names_open(cli_names *names);
size_t cli_names_find(const cli_names *names, const char *name);
size_t cli_names_add(cli_names *names, const char *name);

/* Names look alike that differ only in case, in zeros before a number, in blanks
 * that cannot be seen, or as numbers of one value. One of the names that looks like
 * this one, or NULL; a message for each two of them, kind being "camera" and the
 * like. */
int cli_look_alike(const char *a, const char *b);
const char *cli_names_alike(const cli_names *names, const char *name);
void cli_names_tell_alike(const cli_names *names, const char *kind, const char *path);

typedef struct {
    csv_table table;
    cli_names names;
    rigcal_camera *camera;
} cli_cameras;

void cli_cameras_read(cli_cameras *cameras, const char *path);

/* The number of the camera that a cell names: it must be one of them. */
size_t cli_find_camera(const cli_cameras *cameras, const csv_table *table, size_t row,
                       size_t column);

/* There may be millions: the numbers are no larger than they must be. */
typedef struct {
    rigcal_observation seen;
    rigcal_real sigma;             /* 1, unless column sigma_px is read */
    uint32_t frame, camera, point; /* numbers of their names */
    uint32_t line;                 /* of the file */
} cli_observation;

typedef struct {
    csv_table table; /* its rows have gone */
    cli_names frames, points;
    cli_observation *list;
    size_t count;
    int has_sigma;    /* of CLI_TARGETS: there is a column sigma_px */
    uint32_t *turned; /* of each point, which it becomes where the target is read from its
                         next side; NULL: there is no column turned */
    size_t room_turned;
} cli_observations;
#define CLI_NOT_TURNED UINT32_MAX

/* Sorted by frame, point, camera. `columns`: CLI_TARGETS: X, Y, Z are read;
 * CLI_SIGMAS: sigma_px too, which must be there. It is divided by its median. */
enum { CLI_TARGETS = 1, CLI_SIGMAS = 2 };
void cli_observations_read(cli_observations *observations, const char *path,
                           const cli_cameras *cameras, int columns);

/* Sorts them by camera, frame and line instead: view by view. */
void cli_observations_by_view(cli_observations *observations);

/* Transforms by name: rig.csv by camera, targets.csv by frame. */
typedef struct {
    csv_table table;
    cli_names names;
    rigcal_transform *transform;
} cli_transforms;

/* cameras: the names must be among them; NULL: any name will do. */
void cli_transforms_read(cli_transforms *transforms, const char *path, const char *key,
                         const cli_cameras *cameras);

#endif
