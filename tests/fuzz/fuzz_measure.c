/* Points, matching lines, bands, spans and transfer, with any cameras, poses and pixels. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum { CAMERAS_MOST = 3, UNKNOWNS = 6 * (CAMERAS_MOST - 1), CURVE_MOST = 6 };

/* The input that every kind of call starts from. */
typedef struct {
    size_t n; /* cameras */
    rigcal_camera cameras[CAMERAS_MOST];
    rigcal_transform cams_from_rig[CAMERAS_MOST], b_from_a;
    rigcal_real uv[2 * CAMERAS_MOST], sigma_px, near_a, far_a, ray_a[3], ray_b[3];
} scene;

static void read_scene(scene *s, fuzz_bytes *bytes)
{
    size_t i;

    memset(s, 0, sizeof *s);
    s->n = 2 + (size_t)fuzz_below(bytes, CAMERAS_MOST - 1);
    for (i = 0; i < s->n; i++) {
        fuzz_camera(&s->cameras[i], bytes);
        fuzz_transform(&s->cams_from_rig[i], bytes);
    }
    fuzz_reals(s->uv, 2 * s->n, bytes);
    s->sigma_px = fuzz_real(bytes);
    s->near_a = fuzz_real(bytes);
    s->far_a = fuzz_real(bytes);
    fuzz_reals(s->ray_a, 3, bytes);
    fuzz_reals(s->ray_b, 3, bytes);
    if (rigcal_transform_between(&s->b_from_a, &s->cams_from_rig[1],
                                 &s->cams_from_rig[0]) != RIGCAL_OK) {
        s->b_from_a = s->cams_from_rig[1];
    }
}

/* ---- depths and lines --------------------------------------------------------- */

static void check_depths(const scene *s)
{
    rigcal_real depth_ab[2], miss, X[3], bound;
    rigcal_status status;

    MARK(depth_ab);
    MARK(miss);
    status = rigcal_depth_two_views(depth_ab, &miss, &s->b_from_a, s->ray_a, s->ray_b);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, depth_ab);
    PROMISE_UNTOUCHED(status, miss);
    if (status >= 0) {
        PROMISE(depth_ab[0] >= 0 && depth_ab[1] >= 0 && fuzz_all_finite(depth_ab, 2));
        PROMISE(miss >= 0 && fuzz_all_finite(&miss, 1));
    }
    MARK(X);
    status = rigcal_depth_aligned(X, s->sigma_px, s->ray_a, s->ray_b);
    PROMISE_UNTOUCHED(status, X);
    PROMISE(status < 0 || (fuzz_all_finite(X, 3) && X[2] >= 0));
    MARK(bound);
    status =
        rigcal_point_bound(&bound, &s->cams_from_rig[0], &s->cams_from_rig[1], s->ray_a);
    PROMISE_UNTOUCHED(status, bound);
    PROMISE(status < 0 || (bound >= 0 && fuzz_all_finite(&bound, 1)));
}

static int is_unit(const rigcal_real line[3])
{
    const double length2 =
        (double)line[0] * (double)line[0] + (double)line[1] * (double)line[1];

    return fabs(length2 - 1) < FUZZ_TOL(1e-12, 1e-5) && isfinite(line[2]);
}

static void check_line_px(const scene *s, const rigcal_real line[3])
{
    const rigcal_camera *camera = &s->cameras[1];
    rigcal_real ends[4], distance;
    rigcal_status status;

    MARK(ends);
    status = rigcal_epiline_clip(ends, line, camera->width, camera->height);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, ends);
    if (status >= 0) {
        int i;

        for (i = 0; i < 4; i++) {
            const double most = i % 2 == 0 ? camera->width - 0.5 : camera->height - 0.5;

            PROMISE(ends[i] >= -0.5 && (double)ends[i] <= most);
        }
    }
    MARK(distance);
    status = rigcal_epiline_distance(&distance, line, camera, s->uv + 2);
    PROMISE_UNTOUCHED(status, distance);
    PROMISE(status < 0 || fuzz_all_finite(&distance, 1));
}

static void check_lines(const scene *s)
{
    rigcal_real line[3], ends[4], curve[2 * CURVE_MOST];
    rigcal_status status;
    size_t n_written;

    MARK(line);
    status = rigcal_epiline(line, &s->b_from_a, s->ray_a);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, line);
    PROMISE(status < 0 || is_unit(line));
    MARK(line);
    status = rigcal_epiline_px(line, &s->cameras[1], &s->b_from_a, s->ray_a);
    PROMISE_UNTOUCHED(status, line);
    PROMISE(status < 0 || is_unit(line));
    check_line_px(s, status < 0 ? s->ray_b : line);
    MARK(ends);
    status = rigcal_epiline_segment(ends, &s->cameras[1], &s->b_from_a, s->ray_a, s->near_a,
                                    s->far_a);
    PROMISE_UNTOUCHED(status, ends);
    PROMISE(status < 0 || fuzz_all_finite(ends, 4));
    MARK(curve);
    MARK(n_written);
    status = rigcal_epiline_curve(curve, CURVE_MOST, &n_written, &s->cameras[1],
                                  &s->b_from_a, s->ray_a, s->near_a, s->far_a);
    PROMISE_UNTOUCHED(status, curve);
    PROMISE_UNTOUCHED(status, n_written);
    if (status >= 0) {
        PROMISE(n_written >= 1 && n_written <= CURVE_MOST);
        PROMISE(fuzz_all_finite(curve, 2 * n_written));
    }
}

/* ---- points ------------------------------------------------------------------- */

/* A calibrated rig of these cameras: the first is held, the others have variances. */
typedef struct {
    rigcal_mounted_camera cameras[CAMERAS_MOST];
    int32_t group[CAMERAS_MOST];
    uint8_t held[CAMERAS_MOST];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(CAMERAS_MOST - 1)];
    rigcal_calibrated_rig rig;
    int has_covariance; /* Sigma is a covariance without correlations */
} calibrated;

static void make_calibrated(calibrated *c, const scene *s, fuzz_bytes *bytes)
{
    size_t i;

    memset(c, 0, sizeof *c);
    for (i = 0; i < s->n; i++) {
        c->cameras[i].camera = s->cameras[i];
        c->cameras[i].cam_from_rig = s->cams_from_rig[i];
        c->group[i] = fuzz_below(bytes, 8) == 7;
    }
    for (i = 0; i < UNKNOWNS; i++) {
        const rigcal_real variance = fuzz_real(bytes);

        c->Sigma[i * (i + 1) / 2 + i] = fuzz_is_empty(bytes) ? (rigcal_real)1e-8 : variance;
        c->has_covariance = i == 0 ? variance >= 0 : c->has_covariance && variance >= 0;
    }
    if (fuzz_below(bytes, 4) == 3) {
        fuzz_reals(c->Sigma, 20, bytes);
        c->has_covariance = 0;
    }
    c->held[0] = 1;
    c->rig.cameras = c->cameras;
    c->rig.group = c->group;
    c->rig.held = c->held;
    c->rig.capacity = CAMERAS_MOST;
    c->rig.Sigma = c->Sigma;
    c->rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(CAMERAS_MOST - 1);
    c->rig.n_cameras = s->n;
    c->rig.sigma_px = s->sigma_px;
}

static void check_triangulation(const scene *s)
{
    rigcal_point point;
    rigcal_status status;

    MARK(point);
    status = rigcal_point_triangulate(&point, s->cameras, s->cams_from_rig, s->uv, s->n,
                                      s->sigma_px);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, point);
    if (status >= 0) {
        PROMISE(fuzz_all_finite(point.X, 3));
        PROMISE(fuzz_is_covariance(point.Sigma, 3, FUZZ_TOL(1e-9, 1e-5)));
        PROMISE(point.rms_px >= 0 && fuzz_all_finite(&point.rms_px, 1));
    }
}

enum { WORK = RIGCAL_POINT_WORK(2 * CAMERAS_MOST) };

static void measure(const scene *s, fuzz_bytes *bytes)
{
    static rigcal_real work[WORK];
    const fuzz_budget of_steps = fuzz_budget_of(bytes);
    fuzz_budget budget = of_steps;
    calibrated rig;
    rigcal_sighting seen[CAMERAS_MOST];
    rigcal_sightings sightings;
    rigcal_point_gain gains[CAMERAS_MOST];
    rigcal_measured_point point, again;
    rigcal_point_solver solver;
    uint8_t used[CAMERAS_MOST], used_again[CAMERAS_MOST];
    rigcal_status status, stepped;
    size_t i;

    make_calibrated(&rig, s, bytes);
    memset(&sightings, 0, sizeof sightings);
    for (i = 0; i < s->n; i++) {
        memset(&seen[i], 0, sizeof seen[i]);
        seen[i].camera = (int32_t)i;
        seen[i].uv[0] = s->uv[2 * i];
        seen[i].uv[1] = s->uv[2 * i + 1];
    }
    sightings.rig = &rig.rig;
    sightings.seen = seen;
    sightings.n = s->n;
    sightings.keep_all = fuzz_below(bytes, 2);
    sightings.work = work;
    sightings.work_capacity = WORK;
    MARK(point);
    MARK(used);
    point.gains = gains;
    point.gains_capacity = CAMERAS_MOST;
    again = point;
    MARK(used_again);
    status = rigcal_point_measure(&point, used, &sightings);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    if (status < 0 || status == RIGCAL_DISCONNECTED) {
        PROMISE(memcmp(&point, &again, sizeof point) == 0);
        PROMISE(IS_MARKED(used));
    } else {
        PROMISE(fuzz_all_finite(point.X, 3) && point.chi2 >= 0);
        PROMISE(!rig.has_covariance ||
                fuzz_is_covariance(point.Sigma, 3, FUZZ_TOL(1e-6, 1e-3)));
        PROMISE(fuzz_is_covariance(point.Sigma_noise, 3, FUZZ_TOL(1e-6, 1e-3)));
        PROMISE(point.n_used >= 2 && point.n_used <= s->n);
    }
    stepped = rigcal_point_begin(&solver, &sightings);
    if (stepped < 0) {
        PROMISE(stepped == status);
        return;
    }
    do {
        stepped = rigcal_point_step(&solver, fuzz_budget_next(&budget));
    } while (stepped == RIGCAL_RUNNING);
    PROMISE(rigcal_point_result(&again, used_again, &solver) == status);
    PROMISE(memcmp(&again, &point, sizeof point) == 0);
    PROMISE(memcmp(used_again, used, sizeof used) == 0);
}

/* ---- bands -------------------------------------------------------------------- */

static rigcal_status make_band(rigcal_band *band, const scene *s, fuzz_bytes *bytes)
{
    rigcal_match_pair pair;
    rigcal_status status;
    int i;

    memset(&pair, 0, sizeof pair);
    pair.camera_a = &s->cameras[0];
    pair.camera_b = &s->cameras[1];
    pair.b_from_a = s->b_from_a;
    for (i = 0; i < 6; i++) {
        pair.Sigma[7 * i] = fuzz_real(bytes);
    }
    pair.sigma_a = pair.sigma_b = s->sigma_px;
    pair.k = 1 + (rigcal_real)fuzz_byte(bytes) / 64;
    pair.near_a = s->near_a;
    pair.far_a = s->far_a;
    MARK(*band);
    status = rigcal_band_make(band, &pair, s->uv);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, *band);
    return status;
}

static void check_band(const scene *s, fuzz_bytes *bytes)
{
    rigcal_band band;
    rigcal_band_point points[CURVE_MOST];
    rigcal_match match, matches[2];
    rigcal_real uv_b[6];
    rigcal_status status;
    size_t n_written, n_inside, i;
    int32_t at_fault;

    if (make_band(&band, s, bytes) < 0) {
        return;
    }
    PROMISE(band.across > 0 && band.epipole2 >= 0);
    MARK(points);
    MARK(n_written);
    status = rigcal_band_curve(points, CURVE_MOST, &n_written, &band);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, points);
    PROMISE_UNTOUCHED(status, n_written);
    for (i = 0; status >= 0 && i < n_written; i++) {
        PROMISE(fuzz_all_finite(points[i].uv, 2) && points[i].half_width >= 0);
    }
    fuzz_reals(uv_b, 6, bytes);
    MARK(match);
    status = rigcal_band_test(&match, &band, uv_b);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, match);
    PROMISE(status < 0 || (match.chi2 >= 0 && fuzz_all_finite(&match.chi2, 1)));
    MARK(matches);
    MARK(n_written);
    MARK(n_inside);
    status =
        rigcal_band_search(matches, 2, &n_written, &n_inside, &at_fault, &band, uv_b, 3);
    PROMISE(fuzz_is_status(status) && at_fault >= -1 && at_fault < 3);
    PROMISE_UNTOUCHED(status, matches);
    PROMISE_UNTOUCHED(status, n_inside);
    if (status >= 0) {
        PROMISE(n_inside <= 3 && n_written == (n_inside < 2 ? n_inside : 2));
        PROMISE(n_written < 2 || matches[0].score <= matches[1].score);
    }
}

/* The manual promises results only within these limits: half the width of a band is below
 * this part of a focal length; the lens is decentered by at most this, and shrinks no area
 * to less than this part of fx fy; no border of the image is farther from its centre than
 * this many focal lengths. */
enum { NARROW = 50 };
#define DECENTERED 0.05
#define SHRUNK 0.25
#define FOCALS 10

/* Whether no border of the image is farther from its centre than FOCALS focal lengths, and
 * the lens shrinks no area to SHRUNK, at 17 x 17 places. */
static int is_gentle(const rigcal_camera *camera)
{
    enum { STEPS = 16 };
    int i;

    for (i = 0; i < (STEPS + 1) * (STEPS + 1); i++) {
        const double u = (i % (STEPS + 1)) * (camera->width - 1.) / STEPS;
        const double v = i / (STEPS + 1) * (camera->height - 1.) / STEPS;
        const rigcal_real uv[2] = {(rigcal_real)u, (rigcal_real)v};
        rigcal_ray ray;
        double x, y, z;

        if (!(fabs(u - camera->cx) <= FOCALS * (double)camera->fx &&
              fabs(v - camera->cy) <= FOCALS * (double)camera->fy) ||
            rigcal_ray_make(&ray, camera, uv) != RIGCAL_OK) {
            return 0;
        }
        x = (double)ray.D[2] * ray.D[5] - (double)ray.D[4] * ray.D[3];
        y = (double)ray.D[4] * ray.D[1] - (double)ray.D[0] * ray.D[5];
        z = (double)ray.D[0] * ray.D[3] - (double)ray.D[2] * ray.D[1];
        if (!(sqrt(x * x + y * y + z * z) * SHRUNK * camera->fx * camera->fy < 1)) {
            return 0;
        }
    }
    return 1;
}

/* A pixel whose centre the test of a candidate accepts must be in a span of its row. */
static void check_pixel(const rigcal_band *band, rigcal_spans_solver *solver, int32_t u,
                        int32_t v)
{
    const rigcal_real uv[2] = {(rigcal_real)u, (rigcal_real)v};
    rigcal_span spans[RIGCAL_SPANS_ROW];
    rigcal_match match;
    size_t n, i;
    int is_covered = 0;

    PROMISE(rigcal_spans_row(spans, &n, solver, v) == RIGCAL_OK && n <= RIGCAL_SPANS_ROW);
    for (i = 0; i < n; i++) {
        PROMISE(spans[i].row == v && spans[i].first >= 0);
        PROMISE(spans[i].last >= spans[i].first && spans[i].last < band->camera_b.width);
        PROMISE(i == 0 || spans[i].first > spans[i - 1].last);
        is_covered = is_covered || (spans[i].first <= u && u <= spans[i].last);
    }
    const int is_missed =
        !is_covered && rigcal_band_test(&match, band, uv) == RIGCAL_OK && match.is_inside &&
        NARROW * match.half_width_px < band->camera_b.fx &&
        NARROW * match.half_width_px < band->camera_b.fy &&
        fabs((double)band->camera_b.p1) <= DECENTERED &&
        fabs((double)band->camera_b.p2) <= DECENTERED && is_gentle(&band->camera_b);
    PROMISE(!is_missed);
}

/* A unit near a fold of the lens may take a thousand times as long. The search is ended
 * there after this many units. */
enum { UNITS_OF_FOLDED = 100 };

static void check_spans(const scene *s, fuzz_bytes *bytes)
{
    static rigcal_spans_solver solver, other;
    rigcal_band band;
    rigcal_status status;
    int32_t spent = 0;
    int i;

    if (make_band(&band, s, bytes) < 0) {
        return;
    }
    status = rigcal_spans_begin(&solver, &band);
    PROMISE(status == RIGCAL_OK && rigcal_spans_begin(&other, &band) == RIGCAL_OK);
    do {
        status = rigcal_spans_step(&solver, 1);
        PROMISE(status == RIGCAL_OK || status == RIGCAL_RUNNING ||
                status == RIGCAL_ERR_DEGENERATE);
        PROMISE(++spent <= RIGCAL_SPANS_UNITS);
        if (spent > UNITS_OF_FOLDED && !is_gentle(&band.camera_b)) {
            return;
        }
    } while (status == RIGCAL_RUNNING);
    PROMISE(rigcal_spans_step(&other, RIGCAL_SPANS_UNITS) == status);
    if (status != RIGCAL_OK) {
        return;
    }
    for (i = 0; i < 16; i++) {
        const int32_t u = (int32_t)(fuzz_word(bytes) % (uint32_t)band.camera_b.width);
        const int32_t v = (int32_t)(fuzz_word(bytes) % (uint32_t)band.camera_b.height);

        check_pixel(&band, i % 2 == 0 ? &solver : &other, u, v);
    }
}

/* ---- three cameras, an aligned pair -------------------------------------------- */

static void check_transfer(const scene *s, fuzz_bytes *bytes)
{
    const size_t abc[3] = {0, 1, s->n - 1};
    const rigcal_real sigma_ab[2] = {s->sigma_px, s->sigma_px};
    calibrated rig;
    rigcal_transfer transfer;
    rigcal_real chi2;
    rigcal_status status;

    make_calibrated(&rig, s, bytes);
    MARK(transfer);
    status = rigcal_transfer_make(&transfer, &rig.rig, abc, s->uv, s->uv + 2, sigma_ab);
    PROMISE(fuzz_is_status(status));
    if (status < 0 || status == RIGCAL_DISCONNECTED) {
        PROMISE(IS_MARKED(transfer));
        return;
    }
    PROMISE(fuzz_all_finite(transfer.uv, 2) && fuzz_all_finite(transfer.X, 3));
    PROMISE(transfer.Sigma_X[0] >= 0 && transfer.Sigma_X[4] >= 0 &&
            transfer.Sigma_X[8] >= 0);
    PROMISE(!rig.has_covariance ||
            fuzz_is_covariance(transfer.Sigma_X, 3, FUZZ_TOL(1e-6, 1e-3)));
    MARK(chi2);
    status = rigcal_transfer_test(&chi2, &transfer, s->sigma_px, s->uv + 4);
    PROMISE_UNTOUCHED(status, chi2);
    PROMISE(status < 0 || chi2 >= 0);
}

static void check_pair(const scene *s)
{
    rigcal_rectified rectified;
    rigcal_real k;
    rigcal_status status;

    MARK(rectified);
    status = rigcal_rectify(&rectified, &s->cameras[0], &s->cameras[1], &s->b_from_a);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, rectified);
    if (status >= 0) {
        PROMISE(fuzz_is_rotation(rectified.aligned_from_a, FUZZ_TOL(4e-6, 4e-3)));
        PROMISE(fuzz_is_rotation(rectified.aligned_from_b, FUZZ_TOL(4e-6, 4e-3)));
        PROMISE(rectified.baseline > 0);
        PROMISE(rigcal_camera_check(&rectified.camera) == RIGCAL_OK);
    }
    MARK(k);
    status = rigcal_match_k(&k, s->sigma_px, RIGCAL_MATCH_SEARCH);
    PROMISE_UNTOUCHED(status, k);
    PROMISE(status < 0 || (k > 0 && k < 6));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const int kind = fuzz_below(&bytes, 6);
    scene s;

    read_scene(&s, &bytes);
    switch (kind) {
    case 0:
        check_depths(&s);
        check_lines(&s);
        break;
    case 1:
        check_triangulation(&s);
        measure(&s, &bytes);
        break;
    case 2:
        check_band(&s, &bytes);
        break;
    case 3:
        check_spans(&s, &bytes);
        break;
    case 4:
        check_transfer(&s, &bytes);
        break;
    default:
        check_pair(&s);
        break;
    }
    return 0;
}
