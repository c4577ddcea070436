/* summary.json: a calibration for a program to read. */
#include "cli_calibrate.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ==== JSON ================================================================ */

/* Writes `size` bytes of text as a JSON string, with quotes. */
static void write_bytes(FILE *file, const char *text, size_t size)
{
    size_t i;

    fputc('"', file);
    for (i = 0; i < size; i++) {
        const unsigned char byte = (unsigned char)text[i];

        if (byte == '"' || byte == '\\') {
            fputc('\\', file);
        }
        if (byte < ' ') {
            fprintf(file, "\\u%04x", (unsigned)byte);
        } else {
            fputc(byte, file);
        }
    }
    fputc('"', file);
}

static void write_text(FILE *file, const char *text)
{
    if (text != NULL) {
        write_bytes(file, text, strlen(text));
    } else {
        fputs("null", file);
    }
}

static void write_key(FILE *file, const char *key)
{
    fprintf(file, ",\n  \"%s\": ", key);
}

static void write_field(FILE *file, const char *key, const char *text)
{
    write_key(file, key);
    write_text(file, text);
}

/* Writes a number with all digits of a double. */
static void write_number(FILE *file, const char *key, double number, int is_known)
{
    write_key(file, key);
    if (is_known && fabs(number) <= DBL_MAX) {
        fprintf(file, "%.17g", number);
    } else {
        fputs("null", file);
    }
}

/* Writes "a,b" as a list of names. */
static void write_names(FILE *file, const char *names)
{
    fputc('[', file);
    while (names != NULL && *names != '\0') {
        const size_t size = strcspn(names, ",");

        write_bytes(file, names, size);
        names += size;
        if (*names == ',') {
            fputs(", ", file);
            names++;
        }
    }
    fputc(']', file);
}

/* ==== what was found ====================================================== */

/* Writes the begin of a line about the rig, a camera or a view, up to what is wrong. */
static void write_subject(FILE *file, const char **divider, finding_rank rank,
                          const char *cameras, const char *frames)
{
    static const char *const ABOUT[] = {"rig", "camera", "view"}; /* in the order of
                                                                     finding_rank */

    fprintf(file, "%s\n    {\"about\": \"%s\", \"cameras\": ", *divider, ABOUT[rank]);
    write_names(file, cameras);
    fputs(", \"frames\": ", file);
    write_names(file, frames);
    fputs(",\n     \"what\": ", file);
    *divider = ",";
}

static void write_trouble(FILE *file, const char **divider, const calibration *c,
                          const view_trouble *trouble)
{
    char *text = trouble_text(c, trouble);

    write_subject(file, divider, ABOUT_VIEW, c->cameras.names.name[trouble->camera],
                  c->observations.frames.name[trouble->frame]);
    write_text(file, text);
    fputs(",\n     \"advice\": \"\"}", file);
    cli_free(text);
}

/* Findings about the rig and the cameras come first. Those about views and the troubles of
 * views follow in the order in which they were found. */
static void write_findings(FILE *file, const calibration *c)
{
    const char *divider = "";
    size_t i, t = 0;

    write_key(file, "findings");
    fputc('[', file);
    for (i = 0; i <= c->n_findings; i++) {
        const finding *f = i < c->n_findings ? &c->findings[i] : NULL;

        while (t < c->n_troubles && (f == NULL || (f->rank == ABOUT_VIEW &&
                                                   c->troubles[t].number < f->number))) {
            write_trouble(file, &divider, c, &c->troubles[t++]);
        }
        if (f == NULL || is_finding_told(c, f)) {
            continue;
        }
        write_subject(file, &divider, f->rank, f->cameras, f->frames);
        write_text(file, f->what);
        fputs(",\n     \"advice\": ", file);
        write_text(file, f->advice);
        fputc('}', file);
    }
    fputc(']', file);
}

/* ==== the rig ============================================================= */

static void write_weakest(FILE *file, const calibration *c)
{
    rigcal_weakest weakest;
    const int is_known = find_weakest(&weakest, c);

    write_field(file, "weakest",
                is_known ? rig_camera_name(c, (size_t)weakest.camera) : NULL);
    write_field(file, "next", is_known ? next_text(c, &weakest) : NULL);
}

static const char *verdict_name(const calibration *c)
{
    switch (c->verdict.verdict) {
    case RIGCAL_RIG_AGREES:
        return "agrees";
    case RIGCAL_RIG_EXPLAINED:
        return "explained";
    case RIGCAL_RIG_FOUND:
        return "found";
    default:
        return "unexplained";
    }
}

static void write_fit(FILE *file, const calibration *c)
{
    const rigcal_rig_fit *fit = &c->fit;
    const int has_F = c->is_adjusted && fit->freedom_between > 0;

    write_number(file, "n_views", (double)c->rig.n_views, 1);
    write_number(file, "n_points", (double)fit->n_points, c->is_adjusted);
    write_number(file, "sigma_px", (double)fit->sigma_px,
                 c->is_adjusted && fit->sigma_px > 0);
    write_number(file, "noise_px", c->noise_px, c->is_adjusted && c->noise_px > 0);
    write_number(file, "F", (double)fit->F, has_F);
    write_number(file, "sqrt_F", c->root_F, has_F);
    write_number(file, "freedom_between", (double)fit->freedom_between, c->is_adjusted);
    write_number(file, "freedom_within", (double)fit->freedom_within, c->is_adjusted);
}

void write_summary(FILE *file, const calibration *c)
{
    const int has_verdict = c->is_tested && c->is_adjusted && c->fit.freedom_between > 0;

    fprintf(file, "{\n  \"exit_status\": %d", c->exit_status);
    write_field(file, "frame", rig_frame_name(c));
    write_fit(file, c);
    write_field(file, "verdict", has_verdict ? verdict_name(c) : NULL);
    write_field(file, "sentences", has_verdict ? verdict_text(c) : NULL);
    write_weakest(file, c);
    write_findings(file, c);
    fputs("\n}\n", file);
}
