/* cli_input.h - reads and checks the files of data/FORMAT.md. As in cli_csv.h, any error
 * ends the program with "file:line: what is wrong". */
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
    char *text; /* free memory for the text of further names */
    size_t text_left;
} cli_names;

/* No names yet. The number of a name, or CLI_UNKNOWN. The number of a name that is added
 * (and copied) if it is new. A new name gets the number of names there were. */
#define CLI_UNKNOWN ((size_t)-1)
void cli_names_open(cli_names *names);
size_t cli_names_find(const cli_names *names, const char *name);
size_t cli_names_add(cli_names *names, const char *name);

/* Gives back memory that only finding and adding need. Neither is possible any more. */
void cli_names_close(cli_names *names);

/* Names look alike if they differ only in case, in zeros before a number, in invisible
 * blanks, or as numbers of one value. cli_look_alike compares two names. The next one
 * returns a known name that looks like this one, or NULL. The last prints a message for
 * each two that look alike; `kind` is "camera" and the like. */
int cli_look_alike(const char *a, const char *b);
const char *cli_names_alike(const cli_names *names, const char *name);
void cli_names_tell_alike(const cli_names *names, const char *kind, const char *path);

typedef struct {
    csv_table table;
    cli_names names;
    rigcal_camera *camera;
} cli_cameras;

void cli_cameras_read(cli_cameras *cameras, const char *path);

/* The number of the camera that a cell names. An unknown name ends the program. */
size_t cli_find_camera(const cli_cameras *cameras, const csv_table *table, size_t row,
                       size_t column);

/* There may be millions of observations, so the numbers in them are as small as
 * possible. */
typedef struct {
    rigcal_real uv[2];
    uint32_t frame, camera; /* numbers of their names */
    uint32_t place;         /* see cli_point and cli_X */
    uint32_t line;          /* of the file */
} cli_observation;

/* A line after which no blank line was left out, until the next such line. */
typedef struct {
    uint32_t line, row; /* rows are counted from 0, without blank lines */
} cli_line_of_row;

typedef struct {
    csv_table table; /* the rows are not kept */
    cli_names frames, points;
    cli_observation *list;
    size_t count;

    /* A place is a point with its X, Y, Z. Lines that repeat them share it. */
    rigcal_real (*X)[3]; /* of each place; NULL: X, Y, Z are not read, a place is a point */
    uint32_t *point_of;  /* of each place: the number of the point */
    size_t n_places;

    int has_sigma;      /* with CLI_TARGETS: whether there is a column sigma_px */
    rigcal_real *sigma; /* of each row; NULL: all are 1 */
    cli_line_of_row *lines;
    size_t n_lines;

    uint32_t *turned; /* for each point: the point that it becomes if the target is read
                         from its next side; NULL: there is no column turned */
    size_t room_turned;
} cli_observations;
#define CLI_NOT_TURNED UINT32_MAX

/* Of an observation: the number of its point's name; X, Y, Z; the same with its pixel; the
 * relative noise. */
size_t cli_point(const cli_observations *observations, const cli_observation *o);
const rigcal_real *cli_X(const cli_observations *observations, const cli_observation *o);
rigcal_observation cli_seen(const cli_observations *observations, const cli_observation *o);
rigcal_real cli_sigma_of(const cli_observations *observations, const cli_observation *o);

/* Sorted by frame, point, camera. `columns` may be CLI_TARGETS: X, Y, Z are read; and
 * CLI_SIGMAS: sigma_px is read too, must be there, and is divided by its median. */
enum { CLI_TARGETS = 1, CLI_SIGMAS = 2 };
void cli_observations_read(cli_observations *observations, const char *path,
                           const cli_cameras *cameras, int columns);

/* Sorts them by camera, frame and line, so that each view is together. */
void cli_observations_by_view(cli_observations *observations);

/* Transforms by name: rig.csv by camera, targets.csv by frame. */
typedef struct {
    csv_table table;
    cli_names names;
    rigcal_transform *transform;
} cli_transforms;

/* cameras: the only names that are allowed; NULL: any name is. */
void cli_transforms_read(cli_transforms *transforms, const char *path, const char *key,
                         const cli_cameras *cameras);

#endif
