#include "cli_input.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Adds the names of a file in which each may stand only once: row i gets number i. */
static void names_add_new(cli_names *names, const csv_table *table, size_t row,
                          size_t column)
{
    const char *name = csv_id(table, row, column);
    const size_t number = cli_names_add(names, name);

    if (number != row) {
        csv_fail(table, row, "%s %s is on line %lu already: it takes one line",
                 table->columns[column], name, (unsigned long)table->lines[number]);
    }
}

/* ==== cameras ============================================================= */

static int32_t read_lens(const csv_table *table, size_t row, size_t column)
{
    const char *lens = column == CSV_NONE ? "brown" : csv_id(table, row, column);

    if (strcmp(lens, "brown") != 0 && strcmp(lens, "fisheye") != 0) {
        csv_fail(table, row, "column lens: \"%s\" is neither brown nor fisheye", lens);
    }
    return strcmp(lens, "fisheye") == 0 ? RIGCAL_LENS_FISHEYE : RIGCAL_LENS_BROWN;
}

static rigcal_real read_focal(const csv_table *table, size_t row, const char *name)
{
    const rigcal_real focal = csv_real(table, row, csv_column(table, name));

    if (!(focal > 0)) {
        csv_fail(table, row,
                 "column %s: the focal length must be positive, in "
                 "pixels",
                 name);
    }
    return focal;
}

static void read_coefficients(rigcal_camera *camera, const csv_table *table, size_t row)
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

static void read_camera(rigcal_camera *camera, const csv_table *table, size_t row)
{
    rigcal_status status;

    camera->lens = read_lens(table, row, csv_optional(table, "lens"));
    camera->width = csv_whole(table, row, csv_column(table, "width"), 1, 1000000);
    camera->height = csv_whole(table, row, csv_column(table, "height"), 1, 1000000);
    camera->fx = read_focal(table, row, "fx");
    camera->fy = read_focal(table, row, "fy");
    camera->cx = csv_real(table, row, csv_column(table, "cx"));
    camera->cy = csv_real(table, row, csv_column(table, "cy"));
    read_coefficients(camera, table, row);
    if (camera->lens == RIGCAL_LENS_FISHEYE &&
        (fabs((double)camera->p1) > 0 || fabs((double)camera->p2) > 0 ||
         fabs((double)camera->k5) > 0 || fabs((double)camera->k6) > 0)) {
        csv_fail(table, row,
                 "a fisheye has k1 to k4 only: leave p1, p2, k5 and k6 out or 0");
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
    table->form = "cameras.csv";
    cli_names_open(&cameras->names);
    cameras->camera = cli_alloc(table->n_rows, sizeof *cameras->camera);
    column = csv_column(table, "camera");
    for (row = 0; row < table->n_rows; row++) {
        names_add_new(&cameras->names, table, row, column);
        read_camera(&cameras->camera[row], table, row);
    }
    cli_names_tell_alike(&cameras->names, "camera", path);
}

/* ==== observations ======================================================== */

static int compare(size_t a, size_t b)
{
    return (a > b) - (a < b);
}

size_t cli_point(const cli_observations *observations, const cli_observation *o)
{
    return observations->X != NULL ? observations->point_of[o->place] : o->place;
}

const rigcal_real *cli_X(const cli_observations *observations, const cli_observation *o)
{
    static const rigcal_real NOT_READ[3] = {0, 0, 0};

    return observations->X != NULL ? observations->X[o->place] : NOT_READ;
}

rigcal_observation cli_seen(const cli_observations *observations, const cli_observation *o)
{
    rigcal_observation seen;

    memcpy(seen.X_w, cli_X(observations, o), sizeof seen.X_w);
    memcpy(seen.uv, o->uv, sizeof seen.uv);
    return seen;
}

rigcal_real cli_sigma_of(const cli_observations *observations, const cli_observation *o)
{
    const cli_line_of_row *from = observations->lines;
    size_t n = observations->n_lines;

    if (observations->sigma == NULL) {
        return 1;
    }
    while (n > 1) { /* the line is one of the n from here on */
        const size_t half = n / 2;

        if (from[half].line <= o->line) {
            from += half;
            n -= half;
        } else {
            n = half;
        }
    }
    return observations->sigma[from->row + (o->line - from->line)];
}

/* qsort hands nothing to what compares. */
static const cli_observations *sorted;

static int by_point(const void *left, const void *right)
{
    const cli_observation *a = left, *b = right;
    int order = compare(a->frame, b->frame);

    order = order != 0 ? order : compare(cli_point(sorted, a), cli_point(sorted, b));
    order = order != 0 ? order : compare(a->camera, b->camera);
    return order != 0 ? order : compare(a->line, b->line);
}

static int by_view(const void *left, const void *right)
{
    const cli_observation *a = left, *b = right;
    int order = compare(a->camera, b->camera);

    order = order != 0 ? order : compare(a->frame, b->frame);
    return order != 0 ? order : compare(a->line, b->line);
}

void cli_observations_by_view(cli_observations *observations)
{
    qsort(observations->list, observations->count, sizeof *observations->list, by_view);
}

static int same_place(const rigcal_real X[3], const rigcal_real Y[3])
{
    return X[0] <= Y[0] && X[0] >= Y[0] && X[1] <= Y[1] && X[1] >= Y[1] && X[2] <= Y[2] &&
           X[2] >= Y[2];
}

/* What two lines about one point of one frame contradict each other in, for the message
 * "point 7 <what> on line 8 <advice>". */
typedef struct {
    const char *what, *advice;
} contradiction;

static const contradiction TWICE = {"of this camera and frame is",
                                    "already: a point that is seen has one line"};
static const contradiction ELSEWHERE = {"has other coordinates X, Y, Z",
                                        ": within a frame a point has one place"};

static const contradiction *find_contradiction(const cli_observations *observations,
                                               const cli_observation *a,
                                               const cli_observation *b)
{
    if (a->frame != b->frame || cli_point(observations, a) != cli_point(observations, b)) {
        return NULL;
    }
    if (a->camera == b->camera) {
        return &TWICE;
    }
    return same_place(cli_X(observations, a), cli_X(observations, b)) ? NULL : &ELSEWHERE;
}

/* Sums of products of coordinates, axis by axis, over the points that two cameras saw in a
 * frame. */
typedef struct {
    double aa[3], ab[3], bb[3];
    size_t n;
} products;

static void add_products(products *p, const rigcal_real a[3], const rigcal_real b[3])
{
    int k;

    for (k = 0; k < 3; k++) {
        p->aa[k] += (double)a[k] * (double)a[k];
        p->ab[k] += (double)a[k] * (double)b[k];
        p->bb[k] += (double)b[k] * (double)b[k];
    }
    p->n++;
}

/* The factor that takes the coordinates for camera a to those for camera b. *is_mirrored
 * says whether axes change their signs. 0: there is no such factor. */
static double factor_between(int *is_mirrored, const products *p)
{
    double aa = 0, ab = 0, bb = 0;
    int k;

    *is_mirrored = 0;
    for (k = 0; k < 3; k++) {
        aa += p->aa[k];
        ab += fabs(p->ab[k]);
        bb += p->bb[k];
        *is_mirrored |= p->ab[k] < 0;
    }
    return p->n >= 3 && aa > 0 && ab * ab > (1 - 1e-9) * aa * bb ? ab / aa : 0;
}

/* Names the difference of coordinates that all points of the view share, if there is
 * one. */
static void name_other_coordinates(const cli_observations *observations,
                                   const cli_cameras *cameras, const cli_observation *a,
                                   const cli_observation *b)
{
    products p = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0};
    const cli_observation *o, *last_a = NULL;
    const cli_observation *end = observations->list + observations->count;
    const char *frame = observations->frames.name[a->frame];
    const char *of_a = cameras->names.name[a->camera];
    const char *of_b = cameras->names.name[b->camera];
    double factor;
    int is_mirrored;

    for (o = observations->list; o < end; o++) {
        if (o->frame == a->frame && o->camera == a->camera) {
            last_a = o;
        } else if (o->frame == a->frame && o->camera == b->camera && last_a != NULL &&
                   cli_point(observations, last_a) == cli_point(observations, o)) {
            add_products(&p, cli_X(observations, last_a), cli_X(observations, o));
        }
    }
    factor = factor_between(&is_mirrored, &p);
    if (factor > 0 && is_mirrored) {
        cli_say(
            "frame %s: the coordinates for camera %s are those for camera %s with other "
            "signs: one of the two is mirrored",
            frame, of_b, of_a);
        cli_say("  give X, Y, Z of all observations in the same right-handed axes");
    } else if (factor > 0) {
        cli_say("frame %s: the coordinates for camera %s are %.4g times those for camera "
                "%s: a wrong unit",
                frame, factor > 1 ? of_b : of_a, factor > 1 ? factor : 1 / factor,
                factor > 1 ? of_a : of_b);
        cli_say("  give X, Y, Z of all observations in the same unit");
    }
}

/* Reports the contradiction that comes first in the file. */
static void check_contradictions(const cli_observations *observations,
                                 const cli_cameras *cameras)
{
    const cli_observation *list = observations->list;
    const contradiction *first = NULL;
    size_t i, at = 0, other = 0, point = 0, number = 0;

    for (i = 1; i < observations->count; i++) {
        const size_t a = list[i - 1].line, b = list[i].line;
        const size_t later = a > b ? a : b;
        const contradiction *found =
            find_contradiction(observations, &list[i - 1], &list[i]);

        if (found != NULL && (first == NULL || later < at)) {
            first = found;
            at = later;
            other = a > b ? b : a;
            point = cli_point(observations, &list[i]);
            number = i;
        }
    }
    if (first == &ELSEWHERE) {
        name_other_coordinates(observations, cameras, &list[number - 1], &list[number]);
    }
    if (first != NULL) {
        csv_fail_line(&observations->table, at, "point %s %s on line %lu%s%s",
                      observations->points.name[point], first->what, (unsigned long)other,
                      *first->advice == ':' ? "" : " ", first->advice);
    }
}

size_t cli_find_camera(const cli_cameras *cameras, const csv_table *table, size_t row,
                       size_t column)
{
    const char *name = csv_id(table, row, column);
    const size_t camera = cli_names_find(&cameras->names, name);

    if (camera == CLI_UNKNOWN) {
        const char *alike = cli_names_alike(&cameras->names, name);

        if (alike != NULL) {
            csv_fail(table, row, "camera %s is not in %s, but %s is: spell them alike",
                     name, cameras->table.path, alike);
        }
        csv_fail(table, row, "camera %s is not in %s: add it there, or correct it here",
                 name, cameras->table.path);
    }
    return camera;
}

static int is_outside(const cli_observation *o, const cli_cameras *cameras)
{
    const rigcal_camera *camera = &cameras->camera[o->camera];
    const rigcal_real *uv = o->uv;

    return uv[0] < (rigcal_real)-0.5 || uv[1] < (rigcal_real)-0.5 ||
           uv[0] > (rigcal_real)camera->width - (rigcal_real)0.5 ||
           uv[1] > (rigcal_real)camera->height - (rigcal_real)0.5;
}

/* Tells in one line of pixels outside the image. They are used, but are seldom right. */
static void tell_outside(const cli_observations *observations, const cli_cameras *cameras)
{
    const cli_observation *first = NULL;
    size_t i, count = 0;

    for (i = 0; i < observations->count; i++) {
        const cli_observation *o = &observations->list[i];

        if (is_outside(o, cameras)) {
            first = first == NULL || o->line < first->line ? o : first;
            count++;
        }
    }
    if (first != NULL) {
        cli_say(
            "%s: %lu pixel%s outside the image, the first on line %lu: "
            "(%.6g, %.6g) of camera %s, %ld x %ld. Check u, v, width and height",
            observations->table.path, (unsigned long)count, count == 1 ? " is" : "s are",
            (unsigned long)first->line, (double)first->uv[0], (double)first->uv[1],
            cameras->names.name[first->camera], (long)cameras->camera[first->camera].width,
            (long)cameras->camera[first->camera].height);
    }
}

/* What is only needed while they are read. */
typedef struct {
    size_t room, room_for_places, room_for_points, room_for_sigma, room_for_lines;
    uint32_t *latest; /* for each point: its place on the last line with it */
} reading;

/* Memory of cli_alloc, or NULL, in which number n is to be written. */
static void *with_room(void *memory, size_t n, size_t *room, size_t size)
{
    if (memory != NULL && n < *room) {
        return memory;
    }
    *room = n + n / 2 + 1024;
    return memory == NULL ? cli_alloc(*room, size) : cli_resize(memory, *room, size);
}

/* Adds an observation at the end of the list. */
static cli_observation *add_observation(cli_observations *observations, reading *r)
{
    observations->list = with_room(observations->list, observations->count, &r->room,
                                   sizeof *observations->list);
    return &observations->list[observations->count++];
}

/* Whether X is the same, to the sign of a zero. */
static int is_repeated(const rigcal_real before[3], const rigcal_real X[3])
{
    int k;

    for (k = 0; k < 3; k++) {
        if (copysign(1, (double)before[k]) * copysign(1, (double)X[k]) < 0) {
            return 0;
        }
    }
    return same_place(before, X);
}

/* The place of a point. A point that moves between lines gets a new one. */
static uint32_t add_place(cli_observations *observations, reading *r, size_t point,
                          const rigcal_real X[3])
{
    const uint32_t none = UINT32_MAX;
    const size_t before = r->room_for_points;
    const size_t n = observations->n_places;
    size_t i;

    r->latest = with_room(r->latest, point, &r->room_for_points, sizeof *r->latest);
    for (i = before; i < r->room_for_points; i++) {
        r->latest[i] = none;
    }
    if (r->latest[point] != none && is_repeated(observations->X[r->latest[point]], X)) {
        return r->latest[point];
    }
    i = r->room_for_places;
    observations->X = with_room(observations->X, n, &i, sizeof *observations->X);
    observations->point_of = with_room(observations->point_of, n, &r->room_for_places,
                                       sizeof *observations->point_of);
    memcpy(observations->X[n], X, sizeof *observations->X);
    observations->point_of[n] = (uint32_t)point;
    observations->n_places++;
    return r->latest[point] = (uint32_t)n;
}

/* Reads the relative noise of a line. It must be within the range that rigcal_view
 * accepts. */
static rigcal_real read_sigma(const csv_table *table, size_t column)
{
    static const double LEAST = 1e-6, MOST = 1e6;
    const double sigma = csv_number(table, 0, column);

    if (!(sigma >= LEAST && sigma <= MOST)) {
        csv_fail(table, 0, "column sigma_px: %g is not a noise in pixels, from %g to %g",
                 sigma, LEAST, MOST);
    }
    return (rigcal_real)sigma;
}

/* Adds the relative noise of a line, and notes whether blank lines are before it. */
static void add_sigma(cli_observations *observations, reading *r, const cli_observation *o,
                      size_t column)
{
    const size_t row = observations->count - 1, n = observations->n_lines;
    const cli_line_of_row *last = n > 0 ? &observations->lines[n - 1] : NULL;

    observations->sigma = with_room(observations->sigma, row, &r->room_for_sigma,
                                    sizeof *observations->sigma);
    observations->sigma[row] = read_sigma(&observations->table, column);
    if (last == NULL || o->line - last->line != row - last->row) {
        observations->lines = with_room(observations->lines, n, &r->room_for_lines,
                                        sizeof *observations->lines);
        observations->lines[n].line = o->line;
        observations->lines[n].row = (uint32_t)row;
        observations->n_lines++;
    }
}

/* Reads column turned of a line. All lines of a point must have the same number. */
static void read_turned(cli_observations *observations, size_t point, size_t column)
{
    const csv_table *table = &observations->table;
    const char *name = csv_id(table, 0, column);
    const uint32_t to = (uint32_t)cli_names_add(&observations->points, name);
    const size_t before = observations->room_turned;

    if (observations->turned == NULL) {
        observations->turned = cli_alloc(1, sizeof *observations->turned);
    }
    if (observations->points.count > before) {
        size_t i;

        observations->room_turned = observations->points.count * 2;
        observations->turned = cli_resize(observations->turned, observations->room_turned,
                                          sizeof *observations->turned);
        for (i = before; i < observations->room_turned; i++) {
            observations->turned[i] = CLI_NOT_TURNED;
        }
    }
    if (observations->turned[point] != CLI_NOT_TURNED &&
        observations->turned[point] != to) {
        csv_fail(table, 0, "column turned: point %s is %s here, and %s on a line before",
                 observations->points.name[point], name,
                 observations->points.name[observations->turned[point]]);
    }
    observations->turned[point] = to;
}

static void read_observations(cli_observations *observations, const cli_cameras *cameras,
                              int columns)
{
    enum { SHOWN = 100000 };
    csv_table *table = &observations->table;
    const size_t frame = csv_column(table, "frame");
    const size_t camera = csv_column(table, "camera");
    const size_t point = csv_column(table, "point");
    const int targets = columns & CLI_TARGETS;
    const size_t X = targets ? csv_column(table, "X") : CSV_NONE;
    const size_t Y = targets ? csv_column(table, "Y") : CSV_NONE;
    const size_t Z = targets ? csv_column(table, "Z") : CSV_NONE;
    const size_t u = csv_column(table, "u"), v = csv_column(table, "v");
    const size_t sigma = columns & CLI_SIGMAS ? csv_column(table, "sigma_px") : CSV_NONE;
    const size_t turned = targets ? csv_optional(table, "turned") : CSV_NONE;
    reading r;

    memset(&r, 0, sizeof r);
    while (csv_next(table)) {
        cli_observation *o = add_observation(observations, &r);
        rigcal_real place[3];
        size_t number;

        if (table->lines[0] > UINT32_MAX) {
            csv_fail(table, 0, "the file has more lines than can be counted");
        }
        o->line = (uint32_t)table->lines[0];
        o->frame = (uint32_t)cli_names_add(&observations->frames, csv_id(table, 0, frame));
        o->camera = (uint32_t)cli_find_camera(cameras, table, 0, camera);
        number = cli_names_add(&observations->points, csv_id(table, 0, point));
        place[0] = csv_real(table, 0, X);
        place[1] = csv_real(table, 0, Y);
        place[2] = csv_real(table, 0, Z);
        o->place = targets ? add_place(observations, &r, number, place) : (uint32_t)number;
        o->uv[0] = csv_real(table, 0, u);
        o->uv[1] = csv_real(table, 0, v);
        if (sigma != CSV_NONE) {
            add_sigma(observations, &r, o, sigma);
        }
        if (turned != CSV_NONE) {
            read_turned(observations, number, turned);
        }
        if (o->line % SHOWN == 0) {
            cli_progress(o->line, "reading %s, line %lu", table->path,
                         (unsigned long)o->line);
        }
    }
    if (r.latest != NULL) {
        cli_free(r.latest);
        observations->X =
            cli_resize(observations->X, observations->n_places, sizeof *observations->X);
    }
}

static int by_value(const void *left, const void *right)
{
    const rigcal_real a = *(const rigcal_real *)left, b = *(const rigcal_real *)right;

    return (a > b) - (a < b);
}

/* Divides all noises by their median. The noises of the rig are then those of a median
 * line, in pixels. */
static void divide_by_usual_sigma(cli_observations *observations)
{
    const size_t count = observations->count;
    rigcal_real *list = cli_alloc(count + 1, sizeof *list), usual;
    size_t i;

    for (i = 0; i < count; i++) {
        list[i] = observations->sigma[i];
    }
    qsort(list, count, sizeof *list, by_value);
    usual = list[count / 2];
    for (i = 0; i < count; i++) {
        rigcal_real *sigma = &observations->sigma[i];

        *sigma = (rigcal_real)fmin(fmax((double)(*sigma / usual), 1e-6), 1e6);
    }
    cli_free(list);
}

void cli_observations_read(cli_observations *observations, const char *path,
                           const cli_cameras *cameras, int columns)
{
    csv_table *table = &observations->table;

    memset(observations, 0, sizeof *observations);
    csv_open(table, path);
    table->form = "observations.csv";
    cli_names_open(&observations->frames);
    cli_names_open(&observations->points);
    observations->has_sigma = columns != 0 && csv_optional(table, "sigma_px") != CSV_NONE;
    read_observations(observations, cameras, columns);
    if (columns & CLI_SIGMAS) {
        divide_by_usual_sigma(observations);
    }
    observations->list =
        cli_resize(observations->list, observations->count, sizeof *observations->list);
    cli_names_close(&observations->points);
    sorted = observations;
    qsort(observations->list, observations->count, sizeof *observations->list, by_point);
    check_contradictions(observations, cameras);
    tell_outside(observations, cameras);
    cli_names_tell_alike(&observations->frames, "frame", path);
    cli_names_tell_alike(&observations->points, "point", path);
}

/* ==== transforms ========================================================== */

/* The largest error of an entry of R R^T against the identity. */
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

static void read_transform(rigcal_transform *transform, const csv_table *table, size_t row)
{
    /* A rotation that was rounded when it was written is off by less. A matrix that is off
     * by more is refused. */
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
        csv_fail(table, row,
                 "R11 to R33 are not a rotation: the rows of a rotation have length 1 "
                 "and right angles between them, and its determinant is +1");
    }
}

void cli_transforms_read(cli_transforms *transforms, const char *path, const char *key,
                         const cli_cameras *cameras)
{
    csv_table *table = &transforms->table;
    size_t row, column;

    csv_read(table, path);
    table->form = strcmp(key, "camera") == 0 ? "rig.csv" : "targets.csv";
    cli_names_open(&transforms->names);
    transforms->transform = cli_alloc(table->n_rows, sizeof *transforms->transform);
    column = csv_column(table, key);
    for (row = 0; row < table->n_rows; row++) {
        names_add_new(&transforms->names, table, row, column);
        if (cameras != NULL) {
            cli_find_camera(cameras, table, row, column);
        }
        read_transform(&transforms->transform[row], table, row);
    }
    cli_names_tell_alike(&transforms->names, key, path);
}
