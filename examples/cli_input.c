#include "cli_input.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== names =============================================================== */

static void names_open(cli_names *names, size_t most)
{
    names->n_slots = 2 * most + 1;
    names->slots = cli_alloc(names->n_slots, sizeof *names->slots);
    names->name = cli_alloc(most, sizeof *names->name);
    names->count = 0;
}

/* Where the name is, or the free slot it belongs in (FNV-1a hash). */
static size_t slot_of(const cli_names *names, const char *name)
{
    uint32_t hash = 2166136261u;
    size_t slot;
    const char *c;

    for (c = name; *c != '\0'; c++) {
        hash = (hash ^ (unsigned char)*c) * 16777619u;
    }
    for (slot = hash % names->n_slots; names->slots[slot] != 0;
         slot = (slot + 1) % names->n_slots) {
        if (strcmp(names->name[names->slots[slot] - 1], name) == 0) {
            break;
        }
    }
    return slot;
}

size_t cli_names_find(const cli_names *names, const char *name)
{
    const size_t number = names->slots[slot_of(names, name)];

    return number > 0 ? number - 1 : CLI_UNKNOWN;
}

/* Number of the name, which is new if it equals the count there was. */
static size_t names_add(cli_names *names, const char *name)
{
    const size_t slot = slot_of(names, name);

    if (names->slots[slot] == 0) {
        names->name[names->count++] = name;
        names->slots[slot] = names->count;
    }
    return names->slots[slot] - 1;
}

/* Names that a file may tell once only: row i gets number i. */
static void names_add_new(cli_names *names, const csv_table *table, size_t row,
                          size_t column)
{
    const char *name = csv_id(table, row, column);
    const size_t number = names_add(names, name);

    if (number != row) {
        csv_fail(table, row, "%s %s is on line %lu already",
                 table->columns[column], name,
                 (unsigned long)table->lines[number]);
    }
}

/* ==== cameras ============================================================= */

static int32_t read_lens(const csv_table *table, size_t row, size_t column)
{
    const char *lens =
        column == CSV_NONE ? "brown" : csv_id(table, row, column);

    if (strcmp(lens, "brown") != 0 && strcmp(lens, "fisheye") != 0) {
        csv_fail(table, row, "column lens: \"%s\" is neither brown nor fisheye",
                 lens);
    }
    return strcmp(lens, "fisheye") == 0 ? RIGCAL_LENS_FISHEYE
                                        : RIGCAL_LENS_BROWN;
}

static rigcal_real read_focal(const csv_table *table, size_t row,
                              const char *name)
{
    const rigcal_real focal = csv_real(table, row, csv_column(table, name));

    if (!(focal > 0)) {
        csv_fail(table, row, "column %s: the focal length must be positive",
                 name);
    }
    return focal;
}

static void read_coefficients(rigcal_camera *camera, const csv_table *table,
                              size_t row)
{
    camera->k1 = csv_real(table, row, csv_optional(table, "k1"));
    camera->k2 = csv_real(table, row, csv_optional(table, "k2"));
    camera->p1 = csv_real(table, row, csv_optional(table, "p1"));
    camera->p2 = csv_real(table, row, csv_optional(table, "p2"));
    camera->k3 = csv_real(table, row, csv_optional(table, "k3"));
    camera->k4 = csv_real(table, row, csv_optional(table, "k4"));
    camera->k5 = csv_real(table, row, csv_optional(table, "k5"));
    camera->k6 = csv_real(table, row, csv_optional(table, "k6"));
}

static void read_camera(rigcal_camera *camera, const csv_table *table,
                        size_t row)
{
    rigcal_status status;

    camera->lens = read_lens(table, row, csv_optional(table, "lens"));
    camera->width =
        csv_whole(table, row, csv_column(table, "width"), 1, 1000000);
    camera->height =
        csv_whole(table, row, csv_column(table, "height"), 1, 1000000);
    camera->reserved = 0;
    camera->fx = read_focal(table, row, "fx");
    camera->fy = read_focal(table, row, "fy");
    camera->cx = csv_real(table, row, csv_column(table, "cx"));
    camera->cy = csv_real(table, row, csv_column(table, "cy"));
    read_coefficients(camera, table, row);
    if (camera->lens == RIGCAL_LENS_FISHEYE &&
        (fabs((double)camera->p1) > 0 || fabs((double)camera->p2) > 0 ||
         fabs((double)camera->k5) > 0 || fabs((double)camera->k6) > 0)) {
        csv_fail(table, row,
                 "a fisheye has k1 to k4 only: p1, p2, k5, k6 must be 0");
    }
    status = rigcal_camera_check(camera);
    if (status != RIGCAL_OK) {
        csv_fail(table, row, "%s", rigcal_status_text(status));
    }
}

void cli_cameras_read(cli_cameras *cameras, const char *path)
{
    csv_table *table = &cameras->table;
    size_t row, column;

    csv_read(table, path);
    names_open(&cameras->names, table->n_rows);
    cameras->camera = cli_alloc(table->n_rows, sizeof *cameras->camera);
    column = csv_column(table, "camera");
    for (row = 0; row < table->n_rows; row++) {
        names_add_new(&cameras->names, table, row, column);
        read_camera(&cameras->camera[row], table, row);
    }
}

/* ==== observations ======================================================== */

static int compare(size_t a, size_t b)
{
    return (a > b) - (a < b);
}

static int by_point(const void *left, const void *right)
{
    const cli_observation *a = left, *b = right;
    int order = compare(a->frame, b->frame);

    order = order != 0 ? order : compare(a->point, b->point);
    order = order != 0 ? order : compare(a->camera, b->camera);
    return order != 0 ? order : compare(a->row, b->row);
}

static int by_view(const void *left, const void *right)
{
    const cli_observation *a = left, *b = right;
    int order = compare(a->camera, b->camera);

    order = order != 0 ? order : compare(a->frame, b->frame);
    return order != 0 ? order : compare(a->row, b->row);
}

void cli_observations_by_view(cli_observations *observations)
{
    qsort(observations->list, observations->count, sizeof *observations->list,
          by_view);
}

static int same_place(const rigcal_real X[3], const rigcal_real Y[3])
{
    return X[0] <= Y[0] && X[0] >= Y[0] && X[1] <= Y[1] && X[1] >= Y[1] &&
           X[2] <= Y[2] && X[2] >= Y[2];
}

/* What two lines about one point of one frame must not say. */
static const char *contradiction(const cli_observation *a,
                                 const cli_observation *b)
{
    if (a->frame != b->frame || a->point != b->point) {
        return NULL;
    }
    if (a->camera == b->camera) {
        return "was observed by this camera in this frame";
    }
    if (!same_place(a->seen.X_w, b->seen.X_w)) {
        return "has other coordinates X, Y, Z";
    }
    return NULL;
}

/* Of all contradictions, the one that the file tells first. */
static void check_contradictions(const cli_observations *observations)
{
    const csv_table *table = &observations->table;
    const cli_observation *list = observations->list;
    const char *problem = NULL;
    size_t i, at = 0, other = 0;

    for (i = 1; i < observations->count; i++) {
        const size_t a = list[i - 1].row, b = list[i].row;
        const size_t later = a > b ? a : b;
        const char *found = contradiction(&list[i - 1], &list[i]);

        if (found != NULL && (problem == NULL || later < at)) {
            problem = found;
            at = later;
            other = a > b ? b : a;
        }
    }
    if (problem != NULL) {
        csv_fail(table, at, "point %s %s on line %lu",
                 csv_id(table, at, csv_column(table, "point")), problem,
                 (unsigned long)table->lines[other]);
    }
}

static size_t find_camera(const cli_cameras *cameras, const csv_table *table,
                          size_t row, size_t column)
{
    const char *name = csv_id(table, row, column);
    const size_t camera = cli_names_find(&cameras->names, name);

    if (camera == CLI_UNKNOWN) {
        csv_fail(table, row, "camera %s is not in %s", name,
                 cameras->table.path);
    }
    return camera;
}

static void read_observations(cli_observations *observations,
                              const cli_cameras *cameras, int targets)
{
    const csv_table *table = &observations->table;
    const size_t frame = csv_column(table, "frame");
    const size_t camera = csv_column(table, "camera");
    const size_t point = csv_column(table, "point");
    const size_t X = targets ? csv_column(table, "X") : CSV_NONE;
    const size_t Y = targets ? csv_column(table, "Y") : CSV_NONE;
    const size_t Z = targets ? csv_column(table, "Z") : CSV_NONE;
    const size_t u = csv_column(table, "u"), v = csv_column(table, "v");
    size_t row;

    for (row = 0; row < table->n_rows; row++) {
        cli_observation *o = &observations->list[row];

        o->row = row;
        o->frame = names_add(&observations->frames, csv_id(table, row, frame));
        o->camera = find_camera(cameras, table, row, camera);
        o->point = names_add(&observations->points, csv_id(table, row, point));
        o->seen.X_w[0] = csv_real(table, row, X);
        o->seen.X_w[1] = csv_real(table, row, Y);
        o->seen.X_w[2] = csv_real(table, row, Z);
        o->seen.uv[0] = csv_real(table, row, u);
        o->seen.uv[1] = csv_real(table, row, v);
    }
}

void cli_observations_read(cli_observations *observations, const char *path,
                           const cli_cameras *cameras, int targets)
{
    csv_table *table = &observations->table;

    csv_read(table, path);
    names_open(&observations->frames, table->n_rows);
    names_open(&observations->points, table->n_rows);
    observations->count = table->n_rows;
    observations->list = cli_alloc(table->n_rows, sizeof *observations->list);
    read_observations(observations, cameras, targets);
    qsort(observations->list, observations->count, sizeof *observations->list,
          by_point);
    check_contradictions(observations);
}

/* ==== transforms ========================================================== */

/* How far R R^T is from the identity, in its worst entry. */
static double skewness(const double R[9])
{
    double worst = 0;
    int i, j;

    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            const double *a = R + 3 * i, *b = R + 3 * j;
            const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

            worst = fmax(worst, fabs(dot - (i == j ? 1 : 0)));
        }
    }
    return worst;
}

static void read_transform(rigcal_transform *transform, const csv_table *table,
                           size_t row)
{
    /* Written digits round a rotation; more than that is another matrix. */
    static const double ROUNDING = 1e-6;
    char name[] = "R11", axis[] = "tx";
    rigcal_real M[9];
    double R[9];
    int i;

    for (i = 0; i < 9; i++) {
        name[1] = (char)('1' + i / 3);
        name[2] = (char)('1' + i % 3);
        M[i] = csv_real(table, row, csv_column(table, name));
        R[i] = (double)M[i];
    }
    for (i = 0; i < 3; i++) {
        axis[1] = (char)('x' + i);
        transform->t[i] = csv_real(table, row, csv_column(table, axis));
    }
    if (!(skewness(R) <= ROUNDING) ||
        rigcal_rotation_nearest(transform->R, M) != RIGCAL_OK) {
        csv_fail(table, row, "R11 to R33 are not a rotation");
    }
}

void cli_transforms_read(cli_transforms *transforms, const char *path,
                         const char *key, const cli_cameras *cameras)
{
    csv_table *table = &transforms->table;
    size_t row, column;

    csv_read(table, path);
    names_open(&transforms->names, table->n_rows);
    transforms->transform =
        cli_alloc(table->n_rows, sizeof *transforms->transform);
    column = csv_column(table, key);
    for (row = 0; row < table->n_rows; row++) {
        names_add_new(&transforms->names, table, row, column);
        if (cameras != NULL) {
            find_camera(cameras, table, row, column);
        }
        read_transform(&transforms->transform[row], table, row);
    }
}
