/* How accurate the poses are: figures 10 to 14. */
#include <math.h>
#include <string.h>

#include "figures.h"
#include "solve.h"
#include "table.h"

static double rms(const double values[], int n)
{
    double sum = 0;

    for (int i = 0; i < n; i++) {
        sum += values[i] * values[i] / n;
    }
    return sqrt(sum);
}

/* ---- figures 10 to 13: errors against resolution ------------------------ */

enum {
    RESIDUAL,      /* value of the published objective, camera 1 */
    ROTATION,      /* error of camera 1 against the target [deg] */
    TRANSLATION,   /* [cm] */
    MATCH_PAIR,    /* rms distance of the matches from their lines [px] */
    ROTATION_PAIR, /* error of camera 2 against camera 1 */
    TRANSLATION_PAIR,
    DEPTH_1, /* rms of the four points [cm], in each camera */
    DEPTH_2,
    POSITION_1,
    POSITION_2,
    NORM, /* spectral norm of the error of the rotation, camera 1 against the target */
    NORM_PAIR,
    QUANTITIES
};

static const struct {
    const char *figure, *name;
} quantities[QUANTITIES] = {
    {"fig10", "residual"},      {"fig10", "rotation_deg"}, {"fig10", "translation_cm"},
    {"fig11", "match_px"},      {"fig11", "rotation_deg"}, {"fig11", "translation_cm"},
    {"fig12", "depth_1_cm"},    {"fig12", "depth_2_cm"},   {"fig12", "position_1_cm"},
    {"fig12", "position_2_cm"}, {"fig13", "target"},       {"fig13", "camera"}};

/* SHAPE: the points are where the pose of no guess puts them, because their shape is known,
 * not where the rays meet. BOUND: errors drawn from the Cramer-Rao bound. */
enum { PUBLISHED, NO_GUESS, SHAPE, BOUND, METHODS };
static const char *const method_names[METHODS] = {"published", "no_guess", "shape",
                                                  "bound"};

static double norm_of(double degrees)
{
    return 2 * sin(degrees * PAPER_DEGREE / 2);
}

static void relative(rigcal_transform *b_from_a, const rigcal_transform pose[2])
{
    paper_expect(rigcal_transform_between(b_from_a, &pose[1], &pose[0]) == RIGCAL_OK,
                 "two poses have no relation");
}

/* Depth and position errors of the four points in both cameras. X[k][i] is point i in the
 * frame of camera k. */
static void point_errors(double out[], double X[2][PAPER_POINTS][3],
                         const paper_scene *scene)
{
    for (int k = 0; k < 2; k++) {
        double depth[PAPER_POINTS], position[PAPER_POINTS];

        for (int i = 0; i < PAPER_POINTS; i++) {
            double truth[3];

            paper_in_camera(truth, &scene->cam_from_target[k], paper_points[i]);
            depth[i] = X[k][i][2] - truth[2];
            position[i] = paper_length(X[k][i], truth);
        }
        out[DEPTH_1 + k] = rms(depth, PAPER_POINTS);
        out[POSITION_1 + k] = rms(position, PAPER_POINTS);
    }
}

/* The points where the rays meet: (22)..(24) as published, or least squares in pixels. */
static int meet(double X[2][PAPER_POINTS][3], const rigcal_transform *b_from_a,
                const paper_images *images, int published)
{
    for (int i = 0; i < PAPER_POINTS; i++) {
        const double *const ray[2] = {images->bearings[0][i].ray,
                                      images->bearings[1][i].ray};
        double depth[2], miss;

        if (rigcal_depth_two_views(depth, &miss, b_from_a, ray[0], ray[1]) < 0) {
            return 0;
        }
        for (int k = 0; published && k < 2; k++) {
            for (int j = 0; j < 3; j++) {
                X[k][i][j] = depth[k] * ray[k][j];
            }
        }
        if (!published) {
            const rigcal_camera cameras[2] = {images->camera, images->camera};
            const rigcal_transform frames[2] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}},
                                                *b_from_a};
            const double uv[4] = {images->seen[0][i].uv[0], images->seen[0][i].uv[1],
                                  images->seen[1][i].uv[0], images->seen[1][i].uv[1]};
            rigcal_point point;

            if (rigcal_point_triangulate(&point, cameras, frames, uv, 2, PAPER_SIGMA_PX) <
                0) {
                return 0;
            }
            memcpy(X[0][i], point.X, sizeof X[0][i]);
            paper_in_camera(X[1][i], b_from_a, point.X);
        }
    }
    return 1;
}

/* rms distance of the four matches from their matching lines, (25), (26). */
static double match_error(const rigcal_transform *b_from_a, const paper_images *images)
{
    double off[PAPER_POINTS];

    for (int i = 0; i < PAPER_POINTS; i++) {
        double line[3];

        if (rigcal_epiline_px(line, &images->camera, b_from_a, images->bearings[0][i].ray) <
                0 ||
            rigcal_epiline_distance(&off[i], line, &images->camera, images->seen[1][i].uv) <
                0) {
            return HUGE_VAL;
        }
    }
    return rms(off, PAPER_POINTS);
}

/* All quantities for the poses of both cameras, except those of the points and the
 * residual. */
static void pose_errors(double out[], const rigcal_transform pose[2],
                        const paper_images *images, const paper_scene *scene)
{
    rigcal_transform found, truth;

    relative(&found, pose);
    relative(&truth, scene->cam_from_target);
    out[ROTATION] = paper_degrees(&pose[0], &scene->cam_from_target[0]);
    out[TRANSLATION] = paper_length(pose[0].t, scene->cam_from_target[0].t);
    out[ROTATION_PAIR] = paper_degrees(&found, &truth);
    out[TRANSLATION_PAIR] = paper_length(found.t, truth.t);
    out[NORM] = norm_of(out[ROTATION]);
    out[NORM_PAIR] = norm_of(out[ROTATION_PAIR]);
    out[MATCH_PAIR] = match_error(&found, images);
}

/* The errors of the points where the poses put them. */
static void shape_errors(double out[], const rigcal_transform pose[2],
                         const paper_scene *scene)
{
    double X[2][PAPER_POINTS][3];

    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < PAPER_POINTS; i++) {
            paper_in_camera(X[k][i], &pose[k], paper_points[i]);
        }
    }
    point_errors(out, X, scene);
}

static void fill(double out[QUANTITIES], double value)
{
    for (int q = 0; q < QUANTITIES; q++) {
        out[q] = value;
    }
}

/* One method on both images: computes all quantities from its two attempts. They are
 * infinite if it gave no pose. */
static void errors_of(double out[QUANTITIES], const paper_attempt a[2],
                      const paper_images *images, const paper_scene *scene, int published)
{
    const rigcal_transform pose[2] = {a[0].pose, a[1].pose};
    rigcal_transform b_from_a;
    double X[2][PAPER_POINTS][3];

    fill(out, HUGE_VAL);
    if (!a[0].has_pose || !a[1].has_pose) {
        return;
    }
    pose_errors(out, pose, images, scene);
    out[RESIDUAL] = a[0].residual;
    relative(&b_from_a, pose);
    if (meet(X, &b_from_a, images, published)) {
        point_errors(out, X, scene);
    }
}

/* Solves both cameras, by the published procedure from the library's grid, so that it
 * converges, and without a guess. */
static void attempts(paper_attempt a[2][PAPER_CAMERAS], const paper_images *images,
                     const paper_scene *scene)
{
    for (int c = 0; c < PAPER_CAMERAS; c++) {
        paper_procedure p = paper_published(PAPER_POINTS);

        p.use_guess = 0;
        paper_solve(&a[PUBLISHED][c], &p, images, scene, c);
        paper_solve_no_guess(&a[NO_GUESS][c], images, scene, c);
    }
}

/* ---- figure 14: the matching line --------------------------------------- */

/* Two points seen beside the target in the documented scene [cm]. */
static const double matched[2][3] = {{-9, 22, 10}, {27, -6, 12}};

static int line_of(double line[3], const rigcal_camera *camera,
                   const rigcal_transform pose[2], const double uv_a[2])
{
    rigcal_transform b_from_a;
    double ray[3];

    return rigcal_transform_between(&b_from_a, &pose[1], &pose[0]) == RIGCAL_OK &&
           rigcal_camera_ray(ray, camera, uv_a) == RIGCAL_OK &&
           rigcal_epiline_px(line, camera, &b_from_a, ray) == RIGCAL_OK;
}

static double distance_to(const double line[3], const double uv[2])
{
    return line[0] * uv[0] + line[1] * uv[1] + line[2];
}

/* Signed distance of uv_b from the line if parameter `which` is moved by `step`. There are
 * six parameters of each pose, and two of the pixel in a. HUGE_VAL: there is no line. */
static double moved_distance(const rigcal_camera *camera, const rigcal_transform pose[2],
                             const double uv_a[2], const double uv_b[2], int which,
                             double step)
{
    rigcal_transform moved[2] = {pose[0], pose[1]};
    double uv[2] = {uv_a[0], uv_a[1]}, line[3];

    if (which < 12) {
        double d[6] = {0, 0, 0, 0, 0, 0};

        d[which % 6] = step;
        paper_move(&moved[which / 6], &pose[which / 6], d);
    } else {
        uv[which - 12] += step;
    }
    return line_of(line, camera, moved, uv) ? distance_to(line, uv_b) : HUGE_VAL;
}

/* One sigma of the line's distance from uv_b. The covariances of both poses and the noise
 * of the pixel are propagated by difference quotients. */
static double line_sigma(const rigcal_camera *camera, const rigcal_transform pose[2],
                         const double Sigma[2][36], const double uv_a[2],
                         const double uv_b[2])
{
    double J[14], sum = 0;

    for (int k = 0; k < 14; k++) {
        const double step = k >= 12 ? 1e-3 : k % 6 < 3 ? 1e-6 : 1e-4;

        J[k] = (moved_distance(camera, pose, uv_a, uv_b, k, step) -
                moved_distance(camera, pose, uv_a, uv_b, k, -step)) /
               (2 * step);
    }
    for (int k = 0; k < 12; k++) {
        for (int j = 0; j < 6; j++) {
            sum += J[k] * Sigma[k / 6][6 * (k % 6) + j] * J[k / 6 * 6 + j];
        }
    }
    return sqrt(sum + PAPER_SIGMA_PX * PAPER_SIGMA_PX * (J[12] * J[12] + J[13] * J[13]));
}

/* The lines of both methods for one point, whose pixel in a is uv_a, and their distances
 * from the true match uv_b [px]. Returns 0 if one of the lines is missing. */
typedef struct {
    double line[2][3], off[2], sigma;
} matching;

static int match(matching *m, const paper_attempt a[2][PAPER_CAMERAS],
                 const paper_images *images, const double uv_a[2], const double uv_b[2],
                 double Sigma[2][36])
{
    for (int method = PUBLISHED; method <= NO_GUESS; method++) {
        const rigcal_transform pose[2] = {a[method][0].pose, a[method][1].pose};

        double line[3];

        if (!a[method][0].has_pose || !a[method][1].has_pose ||
            !line_of(line, &images->camera, pose, uv_a)) {
            return 0;
        }
        memcpy(m->line[method], line, sizeof line);
        m->off[method] = distance_to(line, uv_b);
        if (method == NO_GUESS) {
            for (int c = 0; c < PAPER_CAMERAS; c++) {
                if (!paper_covariance(Sigma[c], &pose[c], images, c)) {
                    return 0;
                }
            }
            m->sigma =
                line_sigma(&images->camera, pose, (const double(*)[36])Sigma, uv_a, uv_b);
        }
    }
    return 1;
}

/* The v of the line at u in image b. */
static double line_at(const double line[3], double u)
{
    return -(line[0] * u + line[2]) / line[1];
}

/* Writes the lines over image b, in parts of its width from its middle, and the band of the
 * method without a guess. */
static void draw_lines(FILE *file, const paper_scene *scene, int width)
{
    paper_images images, exact;
    paper_attempt a[2][PAPER_CAMERAS];

    paper_look(&images, scene, width, PAPER_DIGITAL);
    paper_look(&exact, scene, width, PAPER_PERFECT);
    attempts(a, &images, scene);
    for (int i = 0; i < 2; i++) {
        double uv_a[2], true_a[2], true_b[2], line[3], Sigma[2][36];
        const rigcal_transform pose[2] = {a[NO_GUESS][0].pose, a[NO_GUESS][1].pose};
        matching m = {{{0}}, {0}, 0};

        paper_see_point(uv_a, &images, scene, 0, matched[i]);
        paper_see_point(true_a, &exact, scene, 0, matched[i]);
        paper_see_point(true_b, &exact, scene, 1, matched[i]);
        paper_expect(match(&m, (const paper_attempt(*)[PAPER_CAMERAS])a, &images, uv_a,
                           true_b, Sigma) &&
                         line_of(line, &images.camera, scene->cam_from_target, true_a),
                     "the documented scene has no matching line");
        for (int k = 0; k <= 40; k++) {
            const double u = -0.5 + k * width / 40.0;
            const double at[2] = {u, line_at(m.line[NO_GUESS], u)};
            /* k sigma across the line are more than that in v */
            const double band =
                line_sigma(&images.camera, pose, (const double(*)[36])Sigma, uv_a, at) /
                fabs(m.line[NO_GUESS][1]);
            const double middle = (width - 1) / 2.0;

            fprintf(file, "%d,%d,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f\n", width, i + 1,
                    (true_b[0] - middle) / width, (true_b[1] - middle) / width,
                    (u - middle) / width, (line_at(line, u) - middle) / width,
                    (line_at(m.line[PUBLISHED], u) - middle) / width,
                    (at[1] - middle) / width, band / width);
        }
    }
}

/* The largest distance [px], within image 1, between two matching lines: the one of
 * pixel uv of camera 2 by `pose`, and the true one of true_uv by `true_pose`. *off is
 * HUGE_VAL when the first does not exist. Returns 0 when the true line misses the
 * image; *off is then not written. */
static int unsettled(double *off, const rigcal_camera *camera,
                     const rigcal_transform pose[2], const double uv[2],
                     const rigcal_transform true_pose[2], const double true_uv[2])
{
    const rigcal_transform back[2] = {pose[1], pose[0]};
    const rigcal_transform true_back[2] = {true_pose[1], true_pose[0]};
    double truth[3], line[3], ends[4];

    if (!line_of(truth, camera, true_back, true_uv) ||
        rigcal_epiline_clip(ends, truth, camera->width, camera->height) != RIGCAL_OK) {
        return 0;
    }
    *off = line_of(line, camera, back, uv)
               ? fmax(fabs(distance_to(line, ends)), fabs(distance_to(line, ends + 2)))
               : HUGE_VAL;
    return 1;
}

/* Distances of the true matches from their lines; how many of them the band holds;
 * distances of the lines in image 1 from the true lines [inch]. */
typedef struct {
    sample off[2], sigma, unsettled[2];
    int lost, held;
} matches;

/* Gathers the line in image 1 of the point X, by both methods. */
static void gather_unsettled(matches *all, const paper_attempt a[2][PAPER_CAMERAS],
                             const paper_images *images, const paper_scene *scene,
                             const double X[3])
{
    paper_images exact = *images;
    double uv[2], true_uv[2], off;

    exact.digital = PAPER_PERFECT;
    paper_see_point(true_uv, &exact, scene, 1, X);
    uv[0] = floor(true_uv[0] + 0.5); /* it may be outside the image */
    uv[1] = floor(true_uv[1] + 0.5);
    for (int method = PUBLISHED; method <= NO_GUESS; method++) {
        const rigcal_transform pose[2] = {a[method][0].pose, a[method][1].pose};
        const int found = a[method][0].has_pose && a[method][1].has_pose;

        if (unsettled(&off, &images->camera, pose, uv, scene->cam_from_target, true_uv)) {
            sample_add(&all->unsettled[method],
                       found ? off * PAPER_IMAGE_INCH / images->camera.width : HUGE_VAL);
        }
    }
}

static void gather_matches(matches *all, const paper_attempt a[2][PAPER_CAMERAS],
                           const paper_images *images, const paper_scene *scene, int k)
{
    paper_rng rng = paper_stream(PAPER_MATCHING, k);
    paper_images exact = *images;

    exact.digital = PAPER_PERFECT;
    for (int i = 0; i < 2; i++) {
        double X[3], uv_a[2], uv_b[2], Sigma[2][36];
        matching m = {{{0}}, {0}, 0};

        paper_middle(X);
        for (int j = 0; j < 3; j++) {
            X[j] += paper_uniform(&rng, -PAPER_REACH, PAPER_REACH);
        }
        paper_see_point(uv_a, &exact, scene, 0, X);
        uv_a[0] = floor(uv_a[0] + 0.5); /* it may be outside the image */
        uv_a[1] = floor(uv_a[1] + 0.5);
        paper_see_point(uv_b, &exact, scene, 1, X);
        gather_unsettled(all, a, images, scene, X);
        if (!match(&m, a, images, uv_a, uv_b, Sigma)) {
            all->lost++;
            continue;
        }
        sample_add(&all->off[0], fabs(m.off[0]));
        sample_add(&all->off[1], fabs(m.off[1]));
        sample_add(&all->sigma, m.sigma);
        all->held += fabs(m.off[1]) <= 1.959964 * m.sigma;
    }
}

static void print_unsettled(FILE *file, matches *all, double depth, int width)
{
    for (int method = PUBLISHED; method <= NO_GUESS; method++) {
        fprintf(file, "%g,%d,%s,%d", depth, width, method_names[method],
                all->unsettled[method].n);
        sample_print(file, &all->unsettled[method]);
        fprintf(file, "\n");
    }
}

static void print_matches(FILE *file, matches *all, double depth, int width)
{
    for (int method = PUBLISHED; method <= NO_GUESS; method++) {
        fprintf(file, "%g,%d,%s,%d,%d", depth, width, method_names[method], all->sigma.n,
                all->lost);
        sample_print(file, &all->off[method]);
        if (method == NO_GUESS) {
            sample_print(file, &all->sigma);
            fprintf(file, ",%.4f\n", (double)all->held / all->sigma.n);
        } else {
            fprintf(file, ",,,,\n");
        }
    }
}

/* Writes the lines of the documented scene in image 1, cut off at its borders, in inches
 * from its middle, and their distances from the true lines. */
static void draw_settling(FILE *file, const paper_scene *scene, int width)
{
    const double middle = (width - 1) / 2.0, inch = PAPER_IMAGE_INCH / width;
    paper_images images, exact;
    paper_attempt a[2][PAPER_CAMERAS];

    paper_look(&images, scene, width, PAPER_DIGITAL);
    paper_look(&exact, scene, width, PAPER_PERFECT);
    attempts(a, &images, scene);
    for (int i = 0; i < 2; i++) {
        double uv[2], true_uv[2], true_match[2], line[3], ends[4], off;

        paper_see_point(uv, &images, scene, 1, matched[i]);
        paper_see_point(true_uv, &exact, scene, 1, matched[i]);
        paper_see_point(true_match, &exact, scene, 0, matched[i]);
        for (int k = PUBLISHED; k <= NO_GUESS + 1; k++) {
            const int truth = k > NO_GUESS;
            const rigcal_transform *const T = scene->cam_from_target;
            const rigcal_transform pose[2] = {truth ? T[0] : a[k][0].pose,
                                              truth ? T[1] : a[k][1].pose};
            const rigcal_transform back[2] = {pose[1], pose[0]};
            const double *const seen = truth ? true_uv : uv;

            paper_expect((truth || (a[k][0].has_pose && a[k][1].has_pose)) &&
                             line_of(line, &images.camera, back, seen) &&
                             rigcal_epiline_clip(ends, line, width, width) == RIGCAL_OK &&
                             unsettled(&off, &images.camera, pose, seen, T, true_uv),
                         "the documented scene has no matching line");
            fprintf(file, "%d,%d,%s,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f\n", width, i + 1,
                    truth ? "true" : method_names[k], (true_match[0] - middle) * inch,
                    (true_match[1] - middle) * inch, (ends[0] - middle) * inch,
                    (ends[1] - middle) * inch, (ends[2] - middle) * inch,
                    (ends[3] - middle) * inch, off * inch);
        }
    }
}

void figure_14_settling(void)
{
    FILE *const file = table_open("fig14_settling");
    paper_scene scene;

    fprintf(file, "width_px,point,method,match_u,match_v,u1,v1,u2,v2,"
                  "off_inch\n");
    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    for (int w = 0; w < PAPER_WIDTHS; w++) {
        draw_settling(file, &scene, paper_widths[w]);
    }
    table_close(file);
}

void figure_14_lines(void)
{
    static const int drawn[] = {32, 64, 128, 256};
    FILE *const file = table_open("fig14_lines");
    paper_scene scene;

    fprintf(file, "width_px,point,match_u,match_v,u,true_v,published_v,"
                  "no_guess_v,sigma_v\n");
    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    for (size_t i = 0; i < sizeof drawn / sizeof drawn[0]; i++) {
        draw_lines(file, &scene, drawn[i]);
    }
    table_close(file);
}

/* ---- figures 10 to 14 over the random placements ------------------------ */

/* How the errors of one camera compare with the bound: the sums of squares of turn and
 * move, each divided by its expectation. */
typedef struct {
    double turn, move;
    int n;
} over_bound;

static void compare(over_bound *sum, const paper_attempt *a, const rigcal_transform *truth,
                    const double Sigma[36])
{
    const double degrees = a->degrees * PAPER_DEGREE;
    const double moved = paper_length(a->pose.t, truth->t);

    if (a->outcome == PAPER_CORRECT) {
        sum->turn += degrees * degrees / (Sigma[0] + Sigma[7] + Sigma[14]);
        sum->move += moved * moved / (Sigma[21] + Sigma[28] + Sigma[35]);
        sum->n++;
    }
}

typedef struct {
    sample errors[METHODS][QUANTITIES];
    int missing[METHODS][QUANTITIES];
    over_bound over[METHODS]; /* PUBLISHED, NO_GUESS */
    matches matched;
} cell;

static void gather(cell *all, int method, const double values[QUANTITIES])
{
    for (int q = 0; q < QUANTITIES; q++) {
        sample_add(&all->errors[method][q], values[q]);
        all->missing[method][q] += !(values[q] < HUGE_VAL);
    }
}

/* Gathers errors drawn from the bound, as if a method had made them. */
static void gather_bound(cell *all, const double Sigma[PAPER_CAMERAS][36],
                         const paper_images *images, const paper_scene *scene,
                         paper_rng *rng)
{
    for (int draw = 0; draw < (int)PAPER_BOUND_DRAWS; draw++) {
        rigcal_transform pose[PAPER_CAMERAS];
        double values[QUANTITIES];

        for (int c = 0; c < PAPER_CAMERAS; c++) {
            double d[6];

            paper_expect(paper_draw(d, Sigma[c], rng), "a bound is singular");
            paper_move(&pose[c], &scene->cam_from_target[c], d);
        }
        fill(values, HUGE_VAL);
        pose_errors(values, pose, images, scene);
        shape_errors(values, pose, scene);
        values[MATCH_PAIR] = HUGE_VAL; /* its pixels would be different ones */
        gather(all, BOUND, values);
    }
}

/* Computes the errors of all methods; the last is the second with the shape known. */
static void all_errors(double values[METHODS][QUANTITIES],
                       const paper_attempt a[2][PAPER_CAMERAS], const paper_images *images,
                       const paper_scene *scene)
{
    errors_of(values[PUBLISHED], a[PUBLISHED], images, scene, 1);
    errors_of(values[NO_GUESS], a[NO_GUESS], images, scene, 0);
    fill(values[SHAPE], HUGE_VAL);
    if (a[NO_GUESS][0].has_pose && a[NO_GUESS][1].has_pose) {
        const rigcal_transform pose[2] = {a[NO_GUESS][0].pose, a[NO_GUESS][1].pose};

        shape_errors(values[SHAPE], pose, scene);
    }
}

static void gather_placements(cell *all, double depth, int width)
{
    for (int k = 0; k < (int)PAPER_PLACEMENTS; k++) {
        paper_rng rng = paper_stream(PAPER_DRAWING, k);
        paper_scene scene;
        paper_images images;
        paper_attempt a[2][PAPER_CAMERAS];
        double values[METHODS][QUANTITIES], Sigma[PAPER_CAMERAS][36];

        paper_scene_random(&scene, k, depth);
        paper_look(&images, &scene, width, PAPER_DIGITAL);
        attempts(a, &images, &scene);
        all_errors(values, (const paper_attempt(*)[PAPER_CAMERAS])a, &images, &scene);
        for (int m = PUBLISHED; m <= SHAPE; m++) {
            gather(all, m, values[m]);
        }
        gather_matches(&all->matched, (const paper_attempt(*)[PAPER_CAMERAS])a, &images,
                       &scene, k);
        for (int c = 0; c < PAPER_CAMERAS; c++) {
            const rigcal_transform *const truth = &scene.cam_from_target[c];

            paper_expect(paper_covariance(Sigma[c], truth, &images, c),
                         "a placement has no bound");
            compare(&all->over[PUBLISHED], &a[PUBLISHED][c], truth, Sigma[c]);
            compare(&all->over[NO_GUESS], &a[NO_GUESS][c], truth, Sigma[c]);
        }
        gather_bound(all, (const double(*)[36])Sigma, &images, &scene, &rng);
    }
}

static int has_method(int q, int method)
{
    const int of_points = q >= DEPTH_1 && q <= POSITION_2;

    return (method != SHAPE || of_points) &&
           (method != BOUND || (q != RESIDUAL && q != MATCH_PAIR));
}

static void print_cell(FILE *file, cell *all, const char *figure, double depth, int width,
                       double one[METHODS][QUANTITIES])
{
    for (int q = 0; q < QUANTITIES; q++) {
        for (int m = 0; m < METHODS; m++) {
            if (strcmp(quantities[q].figure, figure) != 0 || !has_method(q, m)) {
                continue;
            }
            fprintf(file, "%g,%d,%s,%s,%d,%d", depth, width, quantities[q].name,
                    method_names[m], all->errors[m][q].n, all->missing[m][q]);
            sample_print(file, &all->errors[m][q]);
            if (m == BOUND) {
                fprintf(file, ",\n");
            } else {
                fprintf(file, ",%.4g\n", one[m][q]);
            }
        }
    }
}

void figures_10_to_14(void)
{
    static const char *const names[4] = {"fig10", "fig11", "fig12", "fig13"};
    static cell all;
    const int tried = PAPER_CAMERAS * (int)PAPER_PLACEMENTS;
    FILE *file[4], *const over = table_open("over_bound"),
                          *const lines = table_open("fig14"),
                          *const off = table_open("fig14_unsettled");

    for (int f = 0; f < 4; f++) {
        file[f] = table_open(names[f]);
        fprintf(file[f], "depth_cm,width_px,quantity,method,n,missing,q25,"
                         "median,q75,documented\n");
    }
    fprintf(lines, "depth_cm,width_px,method,n,lost,off_px_q25,off_px_median,"
                   "off_px_q75,sigma_px_q25,sigma_px_median,sigma_px_q75,"
                   "within_95\n");
    fprintf(off, "depth_cm,width_px,method,n,off_inch_q25,off_inch_median,"
                 "off_inch_q75\n");
    fprintf(over, "depth_cm,width_px,method,tried,correct,rotation,translation\n");
    for (int d = 0; d < PAPER_DEPTHS; d++) {
        for (int w = 0; w < PAPER_WIDTHS; w += table_every) {
            paper_scene scene;
            paper_images images;
            paper_attempt a[2][PAPER_CAMERAS];
            double one[METHODS][QUANTITIES];

            memset(&all, 0, sizeof all);
            gather_placements(&all, paper_depths_cm[d], paper_widths[w]);
            paper_scene_documented(&scene, paper_depths_cm[d]);
            paper_look(&images, &scene, paper_widths[w], PAPER_DIGITAL);
            attempts(a, &images, &scene);
            all_errors(one, (const paper_attempt(*)[PAPER_CAMERAS])a, &images, &scene);
            for (int f = 0; f < 4; f++) {
                print_cell(file[f], &all, names[f], paper_depths_cm[d], paper_widths[w],
                           one);
            }
            for (int m = PUBLISHED; m <= NO_GUESS; m++) {
                const over_bound *const o = &all.over[m];

                fprintf(over, "%g,%d,%s,%d,%d,%.4g,%.4g\n", paper_depths_cm[d],
                        paper_widths[w], method_names[m], tried, o->n, sqrt(o->turn / o->n),
                        sqrt(o->move / o->n));
            }
            print_matches(lines, &all.matched, paper_depths_cm[d], paper_widths[w]);
            print_unsettled(off, &all.matched, paper_depths_cm[d], paper_widths[w]);
            fprintf(stderr, "  figures 10 to 14: %g cm, %d px\n", paper_depths_cm[d],
                    paper_widths[w]);
        }
    }
    for (int f = 0; f < 4; f++) {
        table_close(file[f]);
    }
    table_close(over);
    table_close(lines);
    table_close(off);
}
