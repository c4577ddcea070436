/* The band that rigcal line prints. */
#include "cli_band.h"

#include <math.h>
#include <string.h>

static double probability_of(const cli_band *band)
{
    double probability = 0.99;

    if (band->probability != NULL) {
        cli_numbers(&probability, 1, "--probability", band->probability);
        if (!(probability >= 0.001 && probability <= 0.999999)) {
            cli_fail("--probability is from 0.001 to 0.999999, not \"%s\"",
                     band->probability);
        }
    }
    return probability;
}

void cli_band_check(const cli_band *band)
{
    (void)probability_of(band);
    if (band->rig->sigma_px == NULL &&
        (band->probability != NULL || band->candidates != NULL)) {
        cli_fail("--%s needs the noise of a pixel: give --sigma, or a rig.csv that rigcal "
                 "calibrate wrote",
                 band->candidates != NULL ? "candidates" : "probability");
    }
}

/* Where views of the rig disagree by more than noise, matches do too. */
static rigcal_real noise_of(const cli_rig *rig, size_t camera)
{
    const double F = (double)rig->rig.F;

    return (rigcal_real)((double)rig->sigma_px[camera] * (F > 1 ? sqrt(F) : 1));
}

static rigcal_status make_band(rigcal_band *made, const cli_band *band)
{
    const rigcal_calibrated_rig *rig = &band->rig->rig;
    rigcal_match_pair pair;
    rigcal_status status;

    memset(&pair, 0, sizeof pair);
    pair.camera_a = &rig->cameras[band->a].camera;
    pair.camera_b = &rig->cameras[band->b].camera;
    pair.sigma_a = noise_of(band->rig, band->a);
    pair.sigma_b = noise_of(band->rig, band->b);
    pair.near_a = band->near_a;
    pair.far_a = band->far_a;
    if (rig->sigma_px > 0) {
        status = rigcal_calibrated_pair(&pair.b_from_a, pair.Sigma, rig, band->a, band->b);
    } else {
        status =
            rigcal_transform_between(&pair.b_from_a, &rig->cameras[band->b].cam_from_rig,
                                     &rig->cameras[band->a].cam_from_rig);
    }
    if (status == RIGCAL_OK) {
        status =
            rigcal_match_k(&pair.k, (rigcal_real)probability_of(band), RIGCAL_MATCH_SEARCH);
    }
    return status == RIGCAL_OK ? rigcal_band_make(made, &pair, band->uv_a) : status;
}

static int failed(rigcal_status status, const char *what)
{
    if (status < 0) {
        cli_say("cannot compute %s: %s", what, rigcal_status_text(status));
    }
    return status < 0;
}

/* Prints the middle line of the band, its half width and the depth, at places from near to
 * far. */
static int print_curve(const rigcal_band *made)
{
    enum { PLACES = 17 };
    rigcal_band_point points[PLACES];
    size_t i, n;

    if (failed(rigcal_band_curve(points, PLACES, &n, made), "band")) {
        return CLI_GEOMETRY;
    }
    for (i = 0; i < n; i++) {
        printf("band");
        cli_write_numbers(stdout, points[i].uv, 2);
        cli_write_numbers(stdout, &points[i].half_width, 1);
        cli_write_known(stdout, points[i].depth_a, points[i].depth_a > 0);
        printf("\n");
    }
    return CLI_DONE;
}

static int print_spans(const rigcal_band *made)
{
    const size_t room = (size_t)made->camera_b.height * RIGCAL_SPANS_ROW;
    rigcal_spans_solver *solver = cli_alloc(1, sizeof *solver);
    rigcal_span *spans = cli_alloc(room, sizeof *spans);
    size_t i, n;

    if (failed(rigcal_spans_find(spans, room, &n, solver, made), "spans")) {
        return CLI_GEOMETRY;
    }
    for (i = 0; i < n; i++) {
        printf("span,%ld,%ld,%ld,\n", (long)spans[i].row, (long)spans[i].first,
               (long)spans[i].last);
    }
    return CLI_DONE;
}

/* The columns u and v of a file, one pair for each candidate, and the line of each pair.
 * There may be millions of pairs. */
typedef struct {
    csv_table table; /* without its rows */
    rigcal_real *uv;
    uint32_t *line;
    size_t count;
} candidate_list;

static void read_candidates(candidate_list *list, const char *path)
{
    csv_table *table = &list->table;
    size_t room = 1024, u, v;

    csv_open(table, path);
    u = csv_column(table, "u");
    v = csv_column(table, "v");
    list->uv = cli_alloc(2 * room, sizeof *list->uv);
    list->line = cli_alloc(room, sizeof *list->line);
    for (list->count = 0; csv_next(table); list->count++) {
        if (list->count == room) {
            room += room / 2;
            list->uv = cli_resize(list->uv, 2 * room, sizeof *list->uv);
            list->line = cli_resize(list->line, room, sizeof *list->line);
        }
        if (table->lines[0] > UINT32_MAX) {
            csv_fail(table, 0, "the file has more lines than can be counted");
        }
        list->uv[2 * list->count] = csv_real(table, 0, u);
        list->uv[2 * list->count + 1] = csv_real(table, 0, v);
        list->line[list->count] = (uint32_t)table->lines[0];
    }
}

/* Prints the candidates that are inside the band, best first, each by its line in the
 * file. */
static int print_candidates(const rigcal_band *made, const char *path)
{
    candidate_list list;
    rigcal_match *matches;
    size_t i, n, n_inside;
    int32_t at_fault;
    rigcal_status status;

    read_candidates(&list, path);
    matches = cli_alloc(list.count, sizeof *matches);
    status = rigcal_band_search(matches, list.count, &n, &n_inside, &at_fault, made,
                                list.uv, list.count);
    if (status < 0 && at_fault >= 0) {
        csv_fail_line(&list.table, list.line[at_fault], "%s", rigcal_status_text(status));
    }
    if (failed(status, "candidates")) {
        return CLI_GEOMETRY;
    }
    for (i = 0; i < n; i++) {
        const size_t k = (size_t)matches[i].index;

        printf("candidate,%lu", (unsigned long)list.line[k]);
        cli_write_numbers(stdout, &list.uv[2 * k], 2);
        cli_write_numbers(stdout, &matches[i].chi2, 1);
        printf("\n");
    }
    cli_say("%lu of %lu candidates are in the band", (unsigned long)n,
            (unsigned long)list.count);
    return CLI_DONE;
}

int cli_band_print(const cli_band *band)
{
    rigcal_band made;
    int exit_status;

    if (band->rig->sigma_px == NULL) {
        return CLI_DONE;
    }
    if (failed(make_band(&made, band), "band")) {
        return CLI_GEOMETRY;
    }
    cli_say("band of %g %%, for noise of %.4g px of %s and %.4g px of %s",
            100 * probability_of(band), (double)noise_of(band->rig, band->a),
            band->rig->file.names.name[band->a], (double)noise_of(band->rig, band->b),
            band->rig->file.names.name[band->b]);
    exit_status = print_curve(&made);
    if (band->probability != NULL && print_spans(&made) != CLI_DONE) {
        exit_status = CLI_GEOMETRY;
    }
    if (band->candidates != NULL && print_candidates(&made, band->candidates) != CLI_DONE) {
        exit_status = CLI_GEOMETRY;
    }
    return exit_status;
}
