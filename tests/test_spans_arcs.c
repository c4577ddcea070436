/* spans: how a border is followed, arc by arc. The truth: angles in double, a search along
 * the line, derivatives by differences, and the rules of the step control. */
#include <math.h>
#include <string.h>

#include "rc_edge.h"
#include "rigcal_solvers.h"
#include "test_bands.h"

enum { NODES = RIGCAL_SPANS_NODES, LAST = NODES - 1, ARCS = 24 };
enum { START = 1, TRACE, DONE };

/* px: the largest fourth difference of an arc, and how far such an arc may be from the
 * border. */
#define BEND TOL(1e-3, 0.2)
#define ARC_TOL TOL(1e-3, 0.2)

/* 1: an angle or a stride. px: a place. Parts of it, if the border is far outside. */
#define SAME TOL(1e-9, 1e-3)

static rigcal_spans_solver solver, before;
static int is_promised; /* that no pixel is missed */

/* What was seen on the borders so far. */
static struct {
    int taken, halved, doubled, unseen, of_range, left_image, limited, out_of_arcs, empty;
} seen;

/* ---- places of the line ----------------------------------------------------- */

static double angle_of(const rigcal_real p[2])
{
    return atan2(D(p[1]), D(p[0]));
}

/* 1 if the place turns towards near. */
static double sign_of(const rigcal_spans_solver *s)
{
    return s->way == 0 ? -1 : 1;
}

/* The angle from the arc's first node to the end of the depth range. */
static double left_of(const rigcal_spans_solver *s)
{
    return sign_of(s) * (angle_of(s->ends[s->way]) - angle_of(s->at));
}

/* The place after this part of the stride. */
static double place_after(const rigcal_spans_solver *s, double part)
{
    return angle_of(s->at) + sign_of(s) * atan(part * D(s->stride));
}

static void direction_of(double m[3], const rigcal_edge *e, double place, double height)
{
    for (int k = 0; k < 3; k++) {
        m[k] = cos(place) * D(e->band.ray[k]) + sin(place) * D(e->band.towards[k]) +
               height * D(e->normal[k]);
    }
}

/* The border over a place, found from the edge as it was. The place is this
 * tangent ahead of one of length 1: its own length matters only near a fold. */
static rigcal_status border_at(double uv[2], const rigcal_edge *edge, double place,
                               double tangent)
{
    static rigcal_edge copy;
    const double length = hypot(1, tangent);
    const rigcal_real p[2] = {RC(length * cos(place)), RC(length * sin(place))};
    rigcal_real found[2] = {0, 0}, J[6];

    copy = *edge;
    const rigcal_status status = rc_edge_find(found, J, &copy, p);
    test_to_double(uv, found, 2);
    return status;
}

/* Distance from the axis in the normalised image, of node i. */
static double distance_of(const rigcal_spans_solver *s, double u, double v)
{
    const rigcal_camera *c = &s->edge.band.camera_b;

    return hypot((u - D(c->cx)) / D(c->fx), (v - D(c->cy)) / D(c->fy));
}

static double scale_of(double x)
{
    return fmax(1, fabs(x));
}

static void assert_pixel(const double expected[2], const rigcal_real u, rigcal_real v)
{
    const double tol = TOL(1e-3, 0.2) * scale_of(hypot(expected[0], expected[1]) / 1000);

    ASSERT_NEAR(expected[0], u, tol);
    ASSERT_NEAR(expected[1], v, tol);
}

/* ---- before the first arc ---------------------------------------------------- */

/* A point at this depth along the ray of a has the direction (depth + along, across). */
static void assert_range(const rigcal_band *band)
{
    const double along = D(band->along), across = D(band->across), far = D(band->far_a);

    ASSERT_NEAR(far > 0 ? atan2(across, far + along) : 0, angle_of(solver.ends[0]), SAME);
    ASSERT_NEAR(atan2(across, D(band->near_a) + along), angle_of(solver.ends[1]), SAME);
}

/* No place within the depth range is nearer to the axis than the first one. */
static void assert_start_is_nearest(const rigcal_band *band)
{
    const double low = angle_of(solver.ends[0]), high = angle_of(solver.ends[1]);
    const double at = angle_of(solver.start);
    double m[3];

    TEST_ASSERT_TRUE(at >= low - SAME && at <= high + SAME);
    direction_of(m, &solver.edge, at, 0);
    const double depth = m[2];

    for (int i = 0; i <= 100; i++) {
        direction_of(m, &solver.edge, low + i * (high - low) / 100, 0);
        TEST_ASSERT_TRUE(m[2] <= depth + TOL(1e-12, 1e-6));
    }
    (void)band;
}

static void assert_circle(const rigcal_camera *c)
{
    double most = 0;

    for (int i = 0; i < 4; i++) {
        most = fmax(most, distance_of(&solver, i % 2 * (c->width - 1.0),
                                      i / 2 * (c->height - 1.0)));
    }
    ASSERT_NEAR(1.05 * most, sqrt(D(solver.radius2)), SAME * most);
    ASSERT_NEAR(1.05 * most * D(c->fx) + 1, solver.radius, SAME * D(solver.radius));
}

/* ---- the step control --------------------------------------------------------- */

/* The next arc ends `wish` ahead, a tangent, at most 45 degrees ahead, or at the end of the
 * depth range. */
static void assert_aimed(double wish)
{
    const double left = left_of(&solver), planned = fmin(wish, 1);
    const double gap = left < TEST_PI / 2 ? tan(left) - planned : 1;

    TEST_ASSERT_EQUAL_INT32(1, solver.node);
    if (fabs(gap) > SAME) {
        TEST_ASSERT_EQUAL_INT32(gap < 0, solver.is_last);
    }
    ASSERT_NEAR(solver.is_last ? tan(left) : planned, solver.stride,
                TOL(1e-9, 1e-3) * fmax(planned, 1e-3));
    seen.limited += !solver.is_last && wish > 1;
}

/* The first arc of a border in one direction is as long as half the radius of the image, if
 * the pixel went on at its first speed. */
static void assert_way_begins(void)
{
    const double at = angle_of(solver.start), h = 1e-6;
    double m[2][3], uv[2][2], first[2];

    for (int i = 0; i < 2; i++) {
        direction_of(m[i], &solver.edge, at + (i == 0 ? -h : h), D(solver.start_height));
        test_project_px(uv[i], &solver.edge.band.camera_b, m[i]);
    }
    const double speed = hypot(uv[1][0] - uv[0][0], uv[1][1] - uv[0][1]) / (2 * h);

    if (is_promised) { /* else it may depend on the place that was found before */
        ASSERT_STATUS(RIGCAL_OK, border_at(first, &solver.edge, at, 0));
        assert_pixel(first, solver.u[0], solver.v[0]);
    }
    ASSERT_NEAR(D(solver.start_uv[0]), solver.u[0], 0);
    ASSERT_NEAR(D(solver.start_uv[1]), solver.v[0], 0);
    ASSERT_NEAR(at, angle_of(solver.at), SAME);
    ASSERT_NEAR(D(solver.radius) / 2, solver.length, SAME * D(solver.radius));
    TEST_ASSERT_EQUAL_INT32(0, solver.n_arcs);
    TEST_ASSERT_EQUAL_INT32(0, solver.is_closing);
    ASSERT_NEAR(D(solver.radius) / 2 / speed, solver.length / solver.start_speed,
                TOL(1e-5, 1e-2) * D(solver.radius) / speed);
    assert_aimed(D(solver.length) / D(solver.start_speed));
}

/* The border did not go on from its first place: that is an end of the depth range. */
static void assert_empty_way(int side, int way)
{
    const rigcal_border_end *const corner = &solver.corners[side][way];

    ASSERT_NEAR(angle_of(solver.ends[way]), angle_of(solver.start), SAME);
    TEST_ASSERT_EQUAL_INT32(1, corner->is_of_range);
    ASSERT_NEAR(solver.start_height, corner->height, 0);
    ASSERT_NEAR(solver.start_uv[0], corner->uv[0], 0);
    ASSERT_NEAR(solver.start_uv[1], corner->uv[1], 0);
    seen.empty++;
}

/* The first place of a border was found: it is followed towards far, then towards near. */
static void assert_first_way(void)
{
    if (solver.way != 0) {
        TEST_ASSERT_EQUAL_INT32(1, solver.way);
        assert_empty_way(solver.side, 0);
    }
}

/* Whether the unit ended the border in this direction. */
static int has_ended(void)
{
    return solver.side != before.side || solver.way != before.way || solver.phase != TRACE;
}

/* The border ended at this place, in this pixel. */
static void assert_end(double place, double u, double v, int is_of_range)
{
    const rigcal_border_end *corner = &solver.corners[before.side][before.way];
    const double end[2] = {u, v};

    assert_pixel(end, corner->uv[0], corner->uv[1]);
    TEST_ASSERT_EQUAL_INT32(is_of_range, corner->is_of_range);
    if (is_of_range) {
        ASSERT_NEAR(angle_of(before.ends[before.way]), place, SAME);
        seen.of_range++;
    }
    if (solver.phase == TRACE) {
        TEST_ASSERT_EQUAL_INT32(1, solver.way);
        assert_way_begins();
    } else if (before.way == 0) {
        assert_empty_way(before.side, 1);
    }
}

/* The value of the polynomial through five nodes, at t of 0 to 4: Lagrange's form. */
static double value_of(const double x[NODES], double t)
{
    double sum = 0;

    for (int i = 0; i < NODES; i++) {
        double product = x[i];

        for (int j = 0; j < NODES; j++) {
            product *= j == i ? 1 : (t - j) / (i - j);
        }
        sum += product;
    }
    return sum;
}

static void assert_arc_is_on_border(const double u[NODES], const double v[NODES])
{
    for (double t = 0.5; t < LAST; t += 1) {
        double uv[2];

        const double place = place_after(&before, t / LAST);

        if (border_at(uv, &solver.edge, place, 0) == RIGCAL_OK) {
            ASSERT_NEAR(uv[0], value_of(u, t), ARC_TOL);
            ASSERT_NEAR(uv[1], value_of(v, t), ARC_TOL);
        }
    }
}

static double fourth_difference(const double x[NODES])
{
    double d[NODES];

    memcpy(d, x, sizeof d);
    for (int order = LAST; order > 0; order--) {
        for (int i = 0; i < order; i++) {
            d[i] = d[i + 1] - d[i];
        }
    }
    return fabs(d[0]);
}

/* An arc was taken that does not end the border: the next one begins where it ended. */
static void assert_next_arc(double place, double bend, const double u[NODES],
                            const double v[NODES])
{
    double length = D(before.length), stride = D(before.stride);

    if (!before.is_closing) {
        const double chord = 4 * hypot(u[4] - u[3], v[4] - v[3]);

        length *= bend * 16 < BEND ? 2 : 1;
        seen.doubled += bend * 16 < BEND;
        stride *= length / fmax(chord, 0.01 * length);
    }
    ASSERT_NEAR(length, solver.length, SAME * length);
    TEST_ASSERT_EQUAL_INT32(before.n_arcs + 1, solver.n_arcs);
    ASSERT_NEAR(place, angle_of(solver.at), SAME);
    ASSERT_NEAR(1, hypot(D(solver.at[0]), D(solver.at[1])), TOL(1e-14, 1e-6));
    ASSERT_NEAR(u[4], solver.u[0], 0);
    ASSERT_NEAR(v[4], solver.v[0], 0);
    assert_aimed(stride);
}

/* The last node of an arc was found. */
static void assert_arc(void)
{
    const double place = place_after(&before, 1);
    const rigcal_border_end *corner = &solver.corners[before.side][before.way];
    const int is_over = solver.phase == DONE; /* and the nodes are used otherwise */
    double u[NODES], v[NODES];

    test_to_double(u, before.u, NODES);
    test_to_double(v, before.v, NODES);
    u[LAST] = D(is_over ? corner->uv[0] : solver.u[LAST]);
    v[LAST] = D(is_over ? corner->uv[1] : solver.v[LAST]);
    const double bend = fmax(fourth_difference(u), fourth_difference(v));
    const double far[2] = {distance_of(&solver, u[3], v[3]),
                           distance_of(&solver, u[4], v[4])};
    const int leaves = far[0] > sqrt(D(solver.radius2)) && far[1] > far[0];

    const double rounding = TOL(2e-15, 1e-6) * (fabs(u[LAST]) + fabs(v[LAST]) + 1000);

    if (fabs(bend - BEND) < rounding || fabs(bend - BEND / 16) < rounding) {
        return;
    }
    if (bend > BEND && D(before.length) > 0.01 * D(before.radius) && before.n_arcs < ARCS) {
        TEST_ASSERT_FALSE(has_ended());
        ASSERT_NEAR(D(before.length) / 2, solver.length, SAME);
        TEST_ASSERT_EQUAL_INT32(before.n_arcs, solver.n_arcs);
        assert_aimed(D(before.stride) / 2);
        seen.halved++;
        return;
    }
    if (bend <= BEND && is_promised) {
        assert_arc_is_on_border(u, v);
    }
    seen.taken++;
    if (before.is_last || leaves || before.n_arcs + 1 >= 2 * ARCS) {
        seen.left_image += leaves && !before.is_last;
        seen.out_of_arcs += !leaves && !before.is_last;
        TEST_ASSERT_TRUE(has_ended());
        assert_end(place, u[LAST], v[LAST], before.is_last);
    } else if (has_ended()) { /* the end of the range is where the arc ends */
        ASSERT_NEAR(angle_of(before.ends[before.way]), place, SAME);
    } else {
        assert_next_arc(place, bend, u, v);
    }
}

/* One unit of a border under way. */
static void assert_node(void)
{
    const double tangent = D(before.node) / LAST * D(before.stride);
    const double place = place_after(&before, D(before.node) / LAST);
    double uv[2];
    const rigcal_status status = border_at(uv, &before.edge, place, tangent);

    if (status != RIGCAL_OK) {
        seen.unseen++;
        if (D(before.length) / 2 <= TOL(0.02, 0.1)) {
            TEST_ASSERT_TRUE(has_ended());
            return;
        }
        TEST_ASSERT_FALSE(has_ended());
        TEST_ASSERT_EQUAL_INT32(1, solver.is_closing);
        ASSERT_NEAR(D(before.length) / 2, solver.length, SAME);
        assert_aimed(D(before.stride) / 2);
        return;
    }
    if (is_promised && solver.phase != DONE) {
        assert_pixel(uv, solver.u[before.node], solver.v[before.node]);
    }
    if (before.node < LAST) {
        TEST_ASSERT_EQUAL_INT32(before.node + 1, solver.node);
        TEST_ASSERT_FALSE(has_ended());
    } else {
        assert_arc();
    }
}

/* Follows both borders, and checks each unit. Returns the units, or 0 if the band has no
 * two borders. */
static int watch(const rigcal_band *band)
{
    int units = 0;

    if (rigcal_spans_begin(&solver, band) != RIGCAL_OK) {
        return 0;
    }
    assert_range(band);
    assert_start_is_nearest(band);
    assert_circle(&band->camera_b);
    while (solver.phase != DONE) {
        before = solver;
        (void)rigcal_spans_step(&solver, 1);
        units++;
        if (before.phase == TRACE) {
            assert_node();
        } else if (solver.phase == TRACE) {
            TEST_ASSERT_EQUAL_INT32(before.side, solver.side);
            assert_first_way();
            assert_way_begins();
        }
    }
    return units;
}

/* ---- the spans in the end ------------------------------------------------------ */

/* Whether a pixel of the image is in the band: 1, 0, or -1 if rounding decides. */
static int is_in(const test_bands *scene, const test_ray *a, int32_t u, int32_t v)
{
    const rigcal_real uv[2] = {RC(u), RC(v)};
    test_ray ray;
    test_band_truth truth;

    if (!test_ray_of(&ray, &scene->b, uv)) {
        return -1;
    }
    test_band_look(&truth, scene, a, &ray);
    return truth.margin < TOL(1e-6, 2e-2) ? -1 : truth.is_inside;
}

static int is_found(const rigcal_span spans[], size_t n, int32_t u)
{
    for (size_t k = 0; k < n; k++) {
        if (spans[k].first <= u && u <= spans[k].last) {
            return 1;
        }
    }
    return 0;
}

/* A pixel of the band must be in a span. A pixel in a span must be of the band, or the next
 * one is. */
static void assert_pixel_of_row(const test_bands *scene, const test_ray *a,
                                const rigcal_span spans[], size_t n, int32_t u, int32_t v)
{
    if (u < 0 || u >= scene->b.width) {
        return;
    }
    if (!is_found(spans, n, u)) {
        TEST_ASSERT_TRUE_MESSAGE(is_in(scene, a, u, v) < 1, "missed");
        return;
    }
    TEST_ASSERT_TRUE_MESSAGE(is_in(scene, a, u, v) != 0 || is_in(scene, a, u - 1, v) != 0 ||
                                 is_in(scene, a, u + 1, v) != 0,
                             "more than a pixel too many");
}

/* Rows of the image: pixels at both ends of each span, at the ends of the row, and some
 * others. */
static void assert_rows(const test_bands *scene, test_rng *rng)
{
    enum { ROWS = 12, OTHERS = 4 };
    test_ray a;

    TEST_ASSERT_TRUE(test_ray_of(&a, &scene->a, scene->uv_a));
    for (int i = 0; i < ROWS; i++) {
        const int32_t height = scene->b.height, width = scene->b.width;
        const int32_t v = i < 2 ? i * (height - 1) : (int32_t)test_uniform(rng, 0, height);
        rigcal_span spans[RIGCAL_SPANS_ROW];
        size_t n;

        ASSERT_STATUS(RIGCAL_OK, rigcal_spans_row(spans, &n, &solver, v));
        for (size_t k = 0; k < n; k++) {
            for (int32_t more = -1; more <= 1; more++) {
                assert_pixel_of_row(scene, &a, spans, n, spans[k].first + more, v);
                assert_pixel_of_row(scene, &a, spans, n, spans[k].last + more, v);
            }
        }
        for (int k = 0; k < OTHERS + 2; k++) {
            const int32_t u =
                k < 2 ? k * (width - 1) : (int32_t)test_uniform(rng, 0, width);

            assert_pixel_of_row(scene, &a, spans, n, u, v);
        }
    }
}

/* ---- bands --------------------------------------------------------------------- */

static void watch_bands(int kind, uint64_t seed, double size, double half)
{
    test_rng rng = test_seed(seed);
    test_bands scene;
    rigcal_band band;

    test_bands_random(&scene, &rng, kind, size);
    is_promised = half <= 0 || kind == TEST_PINHOLE || kind == TEST_FISHEYE;
    if (half > 0) {
        scene.pair.sigma_b =
            RC(test_uniform(&rng, 0.01, half) * D(scene.b.fx) / D(scene.pair.k));
    }
    if (rigcal_band_make(&band, &scene.pair, scene.uv_a) == RIGCAL_OK) {
        if (watch(&band) > 0 && is_promised && solver.status == RIGCAL_OK) {
            assert_rows(&scene, &rng);
        }
    }
}

static void test_a_border_is_followed_by_arcs_within_the_tolerance(void)
{
    memset(&seen, 0, sizeof seen);
    for (int i = 0; i < TEST_TRIALS(200); i++) {
        watch_bands(i % TEST_LENS_KINDS, 5100 + (uint64_t)i, i % 3 == 0 ? 96 : 2000, 0);
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 ||
                     (seen.taken > 500 && seen.halved > 20 && seen.doubled > 20));
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 ||
                     (seen.of_range > 20 && seen.left_image > 20 && seen.empty > 20));
}

static void test_borders_of_wide_bands_are_followed_too(void)
{
    memset(&seen, 0, sizeof seen);
    for (int i = 0; i < TEST_TRIALS(100); i++) {
        watch_bands(i % TEST_LENS_KINDS, 5400 + (uint64_t)i, 1000, 0.5);
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (seen.taken > 100 && seen.unseen > 0));
}

static void test_borders_of_a_lens_that_nearly_folds_are_followed_too(void)
{
    memset(&seen, 0, sizeof seen);
    is_promised = 0;
    for (int i = 0; i < TEST_TRIALS(150); i++) {
        test_rng rng = test_seed(5600 + (uint64_t)i);
        test_bands scene;
        rigcal_band band;

        test_bands_wild(&scene, &rng, 1500);
        if (rigcal_band_make(&band, &scene.pair, scene.uv_a) == RIGCAL_OK) {
            (void)watch(&band);
        }
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (seen.limited > 0 && seen.out_of_arcs > 0));
}

/* An end of the depth range crosses such an image in a curve. An error of a hundredth of
 * the angle between two pixels of a small image is a pixel here. */
static void test_bands_of_a_large_image_are_as_accurate(void)
{
    if (RIGCAL_USE_FLOAT) {
        return; /* pixels of such an image are only right to some hundredths */
    }
    memset(&seen, 0, sizeof seen);
    for (int i = 0; i < TEST_TRIALS(120); i++) {
        watch_bands(i % 3 == 0 ? TEST_PINHOLE : TEST_FISHEYE, 5900 + (uint64_t)i, 40000,
                    0.5);
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || seen.of_range > 20);
}

/* The same pinhole twice, moved across its axis in 24 directions. The line passes the axis
 * at any distance, and the band is up to half of `reach` wide on each side: its borders
 * leave the image at other places and are joined outside it. Points 1 away are `reach` px
 * from where they are infinitely far. The focal length is `times` that. */
static void look_in_all_directions(int trials, double times)
{
    enum { DIRECTIONS = 24 };
    static const double range[][2] = {{0.1, 0}, {1.5, 0}, {1, 3}};
    test_rng rng = test_seed(5800);

    is_promised = 1;
    for (int i = 0; i < trials; i++) {
        const double turn = (i % DIRECTIONS + 0.3) * 2 * TEST_PI / DIRECTIONS;
        const double t[3] = {cos(turn) / times, sin(turn) / times, 0};
        const double aside = test_uniform(&rng, -75, 75),
                     along = test_uniform(&rng, -60, 60);
        const int of_range = i / DIRECTIONS % 3;
        const double reach = 20 << i / DIRECTIONS / 3 % 4; /* px */
        test_bands scene;
        rigcal_band band;

        memset(&scene, 0, sizeof scene);
        test_bands_beside(&scene.pair, &scene.b, reach * test_uniform(&rng, 0.02, 0.248),
                          2);
        scene.b.fx = scene.b.fy = RC(times * reach);
        scene.a = scene.b;
        scene.pair.b_from_a = test_transform(NULL, t);
        scene.pair.near_a = RC(range[of_range][0]);
        scene.pair.far_a = RC(range[of_range][1]);
        scene.uv_a[0] = RC(40 + along * t[0] * times - aside * t[1] * times);
        scene.uv_a[1] = RC(30 + along * t[1] * times + aside * t[0] * times);
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, scene.uv_a));
        TEST_ASSERT_TRUE(watch(&band) > 0);
        ASSERT_STATUS(RIGCAL_OK, (rigcal_status)solver.status);
        assert_rows(&scene, &rng);
    }
}

static void test_bands_in_all_directions_are_joined_outside_the_image(void)
{
    look_in_all_directions(TEST_TRIALS(24 * 36), 1);
}

/* The image of a long lens is a small part of its plane. */
static void test_bands_of_a_long_lens_are_joined_outside_the_image(void)
{
    look_in_all_directions(TEST_TRIALS(24 * 36), 20);
}

/* Camera b is 1 to the right of a. Both have 8 x 6 pixels and a focal length of 0.8: the
 * border moves by less than a pixel for a radian. */
static void test_a_focal_length_may_be_less_than_a_pixel(void)
{
    static const rigcal_real uv_a[2] = {4, 3};
    rigcal_camera camera;
    rigcal_match_pair pair;
    rigcal_span spans[8];
    rigcal_band band;
    size_t n;

    test_bands_beside(&pair, &camera, 0.1, 2);
    pair.near_a = RC(0.15); /* column 4 - 0.8 / 0.15, outside */
    camera.width = 8;
    camera.height = 6;
    camera.fx = camera.fy = RC(0.8);
    camera.cx = 4;
    camera.cy = 3;
    is_promised = 1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &pair, uv_a));
    TEST_ASSERT_TRUE(watch(&band) > 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_result(spans, 8, &n, &solver));
    TEST_ASSERT_EQUAL_UINT64(1, n);
    TEST_ASSERT_EQUAL_INT32(3, spans[0].row);
    TEST_ASSERT_EQUAL_INT32(0, spans[0].first);
    TEST_ASSERT_EQUAL_INT32(4, spans[0].last);
}

TEST_MAIN()
{
    RUN_TEST(test_a_border_is_followed_by_arcs_within_the_tolerance);
    RUN_TEST(test_borders_of_wide_bands_are_followed_too);
    RUN_TEST(test_bands_in_all_directions_are_joined_outside_the_image);
    RUN_TEST(test_bands_of_a_long_lens_are_joined_outside_the_image);
    RUN_TEST(test_bands_of_a_large_image_are_as_accurate);
    RUN_TEST(test_a_focal_length_may_be_less_than_a_pixel);
    RUN_TEST(test_borders_of_a_lens_that_nearly_folds_are_followed_too);
}
