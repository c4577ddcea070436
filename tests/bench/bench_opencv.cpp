/* bench_opencv: rigcal_pose_solve beside the pose solvers of OpenCV's calib3d, on the
 * same scenes in one process, as Markdown. Built and run by opencv.sh.
 *
 *   bench_opencv targets [SCENES] [NOISE]
 *       every target and number of points: accuracy, wrong answers, time
 *   bench_opencv noises [SCENES]
 *       some of them, for all noises
 *   bench_opencv three [SCENES] [NOISE]
 *       three points
 *   bench_opencv replay FAMILY N INDEX NOISE NEAREST FARTHEST
 *       one scene, as --list names it: its minima, and what everyone answered
 *   bench_opencv methods FAMILY N
 *       what there is for it
 *   bench_opencv solve FAMILY N METHOD COUNT
 *       only solves, for callgrind; prints the mean number of allocations
 *
 * NOISE is in pixels; 0: exact images rounded to whole pixels. --list names the scenes
 * that rigcal did not get right, on stderr. */
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iterator>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/ocl.hpp>

extern "C" {
#include "bench_minima.h"
#include "bench_scenes.h"

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void);
void tearDown(void);
}

void setUp(void)
{
}

void tearDown(void)
{
}

static_assert(sizeof(rigcal_real) == sizeof(double), "OpenCV computes in double");

[[noreturn]] static void fail(const std::string &why)
{
    std::fprintf(stderr, "bench_opencv: %s\n", why.c_str());
    std::exit(2);
}

/* ---- the heap's calls, counted ------------------------------------------- */

/* glibc's own functions, under the names that it keeps for this purpose. Functions defined
 * in the program replace those of every library; operator new and cv::fastMalloc call
 * them. */
extern "C" {
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
}

static long heap_calls;

extern "C" void *malloc(size_t size)
{
    heap_calls++;
    return __libc_malloc(size);
}

extern "C" void *calloc(size_t n, size_t size)
{
    heap_calls++;
    return __libc_calloc(n, size);
}

extern "C" void *realloc(void *old, size_t size)
{
    heap_calls++;
    return __libc_realloc(old, size);
}

extern "C" void *memalign(size_t alignment, size_t size)
{
    heap_calls++;
    return __libc_memalign(alignment, size);
}

extern "C" void *aligned_alloc(size_t alignment, size_t size)
{
    return memalign(alignment, size);
}

extern "C" int posix_memalign(void **out, size_t alignment, size_t size)
{
    void *const got = memalign(alignment, size);

    if (!got) {
        return 12; /* ENOMEM */
    }
    *out = got;
    return 0;
}

/* ---- one problem, as each side wants it ---------------------------------- */

enum { ANSWERS_MAX = 8 };

struct problem {
    bench_scene scene;
    std::vector<cv::Point3d> X;
    std::vector<cv::Point2d> uv;
    cv::Matx33d K;
    double R_start[9], t_start[3];
    rigcal_transform start;
    cv::Vec3d rvec_start, tvec_start;
};

/* The first answer is the one that the method considers the best. */
struct answers {
    int n;
    double R[ANSWERS_MAX][9], t[ANSWERS_MAX][3];
};

/* What a call returns. It is turned into `answers` after the clock was stopped. */
struct outcome {
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_poses;
    std::vector<cv::Vec3d> rvecs, tvecs;
    bool is_first; /* only the first of these counts */
};

static void rotation_of(double R[9], const cv::Vec3d &rvec)
{
    const double angle = cv::norm(rvec);

    if (angle > 0) {
        test_rotation_about(R, rvec.val, angle);
    } else {
        test_rotation(R, 0, 0, 0);
    }
}

static cv::Vec3d vector_of(const double R[9])
{
    cv::Vec3d rvec;

    cv::Rodrigues(cv::Matx33d(R), rvec);
    return rvec;
}

static void problem_make(problem &p, const bench_family *f, int n, long index,
                         const bench_view &view)
{
    bench_scene &s = p.scene;

    bench_scene_make(&s, f, n, index, &view);
    p.X.clear();
    p.uv.clear();
    for (int i = 0; i < n; i++) {
        const rigcal_observation &o = s.seen[i];

        p.X.emplace_back(o.X_w[0], o.X_w[1], o.X_w[2]);
        p.uv.emplace_back(o.uv[0], o.uv[1]);
    }
    p.K = cv::Matx33d(s.camera.fx, 0, s.camera.cx, 0, s.camera.fy, s.camera.cy, 0, 0, 1);
    bench_disturb(p.R_start, p.t_start, &s);
    p.start = test_transform(p.R_start, p.t_start);
    p.rvec_start = vector_of(p.R_start);
    p.tvec_start = cv::Vec3d(p.t_start);
}

static void answers_from(answers &a, const outcome &o)
{
    a.n = 0;
    for (size_t i = 0; i < o.n_poses; i++) {
        test_transform_parts(a.R[a.n], a.t[a.n], &o.poses[i].cam_from_world);
        a.n++;
    }
    for (size_t i = 0; i < o.rvecs.size() && a.n < ANSWERS_MAX; i++) {
        rotation_of(a.R[a.n], o.rvecs[i]);
        std::copy(o.tvecs[i].val, o.tvecs[i].val + 3, a.t[a.n]);
        double sum = 0;

        for (int k = 0; k < 3; k++) {
            sum += o.rvecs[i][k] + o.tvecs[i][k];
        }
        a.n += std::isfinite(sum);
    }
}

/* ---- the methods --------------------------------------------------------- */

/* Whether the method is defined for any targets of n points. */
static bool anywhere(const bench_family *, int n)
{
    return n >= 4;
}

static bool is_plane(const bench_family *f)
{
    return !(f->box[2] > 0);
}

static bool on_planes(const bench_family *f, int n)
{
    return n >= 4 && is_plane(f);
}

static bool on_tags(const bench_family *f, int n)
{
    return n == 4 && f->is_tag;
}

/* A linear start needs six points unless they are in a plane. */
static bool for_iterative(const bench_family *f, int n)
{
    return n >= (is_plane(f) ? 4 : 6);
}

static bool on_three(const bench_family *, int n)
{
    return n == 3;
}

static bool on_four(const bench_family *, int n)
{
    return n == 4;
}

static void run_rigcal(outcome &o, const problem &p, const rigcal_pose_options *options)
{
    const rigcal_view view{&p.scene.camera, p.scene.seen, nullptr, (size_t)p.scene.n};
    const rigcal_status status =
        rigcal_pose_solve(o.poses, RIGCAL_POSES_MAX, &o.n_poses, nullptr, &view, options);

    if (status < 0) {
        o.n_poses = 0;
    }
}

static void run_default(outcome &o, const problem &p)
{
    run_rigcal(o, p, nullptr);
}

/* The noise is stated: only then are minima of three points returned that do not fit
 * exactly. */
static void run_known(outcome &o, const problem &p)
{
    rigcal_pose_options options;

    (void)rigcal_pose_defaults(&options);
    options.sigma_px = p.scene.sigma;
    run_rigcal(o, p, &options);
}

static void run_warm(outcome &o, const problem &p)
{
    rigcal_pose_options options;

    (void)rigcal_pose_defaults(&options);
    options.use_start = 1;
    options.start = p.start;
    run_rigcal(o, p, &options);
}

template <int flags> static void run_one(outcome &o, const problem &p)
{
    o.rvecs.resize(1);
    o.tvecs.resize(1);
    if (!cv::solvePnP(p.X, p.uv, p.K, cv::noArray(), o.rvecs[0], o.tvecs[0], false,
                      flags)) {
        o.rvecs.clear();
    }
}

static double sum_of(const problem &p, const cv::Vec3d &rvec, const cv::Vec3d &tvec)
{
    double R[9], sum = 0;

    rotation_of(R, rvec);
    for (int i = 0; i < p.scene.n; i++) {
        double xy[2];

        test_project(xy, R, tvec.val, p.scene.seen[i].X_w);
        for (int k = 0; k < 2; k++) {
            const double off =
                (k ? p.K(1, 1) : p.K(0, 0)) * xy[k] + p.K(k, 2) - p.scene.seen[i].uv[k];

            sum += off * off;
        }
    }
    return sum;
}

/* Moves the best answer to the front. */
static void choose(outcome &o, const problem &p)
{
    size_t best = 0;
    double least = HUGE_VAL;

    for (size_t i = 0; o.rvecs.size() > 1 && i < o.rvecs.size(); i++) {
        const double sum = sum_of(p, o.rvecs[i], o.tvecs[i]);

        best = sum < least ? i : best;
        least = std::min(least, sum);
    }
    if (best > 0) {
        std::swap(o.rvecs[0], o.rvecs[best]);
        std::swap(o.tvecs[0], o.tvecs[best]);
    }
}

template <int flags> static void run_all(outcome &o, const problem &p)
{
    (void)cv::solvePnPGeneric(p.X, p.uv, p.K, cv::noArray(), o.rvecs, o.tvecs, false,
                              (cv::SolvePnPMethod)flags);
    choose(o, p);
}

template <int flags> static void run_three(outcome &o, const problem &p)
{
    (void)cv::solveP3P(p.X, p.uv, p.K, cv::noArray(), o.rvecs, o.tvecs, flags);
}

/* Refines all answers. */
static void refine(outcome &o, const problem &p)
{
    for (size_t i = 0; i < o.rvecs.size(); i++) {
        cv::solvePnPRefineLM(p.X, p.uv, p.K, cv::noArray(), o.rvecs[i], o.tvecs[i]);
    }
    choose(o, p);
}

template <int flags> static void run_one_refined(outcome &o, const problem &p)
{
    run_one<flags>(o, p);
    refine(o, p);
}

template <int flags> static void run_all_refined(outcome &o, const problem &p)
{
    (void)cv::solvePnPGeneric(p.X, p.uv, p.K, cv::noArray(), o.rvecs, o.tvecs, false,
                              (cv::SolvePnPMethod)flags);
    refine(o, p);
}

static void run_iterative_warm(outcome &o, const problem &p)
{
    o.rvecs.assign(1, p.rvec_start);
    o.tvecs.assign(1, p.tvec_start);
    if (!cv::solvePnP(p.X, p.uv, p.K, cv::noArray(), o.rvecs[0], o.tvecs[0], true,
                      cv::SOLVEPNP_ITERATIVE)) {
        o.rvecs.clear();
    }
}

static void run_refine_warm(outcome &o, const problem &p)
{
    o.rvecs.assign(1, p.rvec_start);
    o.tvecs.assign(1, p.tvec_start);
    refine(o, p);
}

enum section { COLD, WARM, THREE };

struct method {
    const char *name;
    section where;
    bool several; /* whether it is meant to return the second pose too */
    bool is_ours;
    bool (*is_defined)(const bench_family *f, int n);
    void (*run)(outcome &o, const problem &p);
};

static const method methods[] = {
    {"rigcal", COLD, true, true, anywhere, run_default},
    {"ITERATIVE", COLD, false, false, for_iterative, run_one<cv::SOLVEPNP_ITERATIVE>},
    {"EPNP", COLD, false, false, anywhere, run_one<cv::SOLVEPNP_EPNP>},
    {"EPNP+LM", COLD, false, false, anywhere, run_one_refined<cv::SOLVEPNP_EPNP>},
    {"SQPNP", COLD, false, false, anywhere, run_all<cv::SOLVEPNP_SQPNP>},
    {"SQPNP+LM", COLD, false, false, anywhere, run_all_refined<cv::SOLVEPNP_SQPNP>},
    {"IPPE", COLD, true, false, on_planes, run_all<cv::SOLVEPNP_IPPE>},
    {"IPPE+LM", COLD, true, false, on_planes, run_all_refined<cv::SOLVEPNP_IPPE>},
    {"SQUARE", COLD, true, false, on_tags, run_all<cv::SOLVEPNP_IPPE_SQUARE>},
    {"SQUARE+LM", COLD, true, false, on_tags, run_all_refined<cv::SOLVEPNP_IPPE_SQUARE>},
    {"P3P", COLD, false, false, on_four, run_one<cv::SOLVEPNP_P3P>},
    {"AP3P", COLD, false, false, on_four, run_one<cv::SOLVEPNP_AP3P>},
    {"AP3P+LM", COLD, false, false, on_four, run_one_refined<cv::SOLVEPNP_AP3P>},
    {"rigcal warm", WARM, false, true, anywhere, run_warm},
    {"ITERATIVE warm", WARM, false, false, anywhere, run_iterative_warm},
    {"RefineLM warm", WARM, false, false, anywhere, run_refine_warm},
    {"rigcal 3", THREE, true, true, on_three, run_known},
    {"rigcal 3, noise not stated", THREE, true, false, on_three, run_default},
    {"P3P 3", THREE, true, false, on_three, run_three<cv::SOLVEPNP_P3P>},
    {"AP3P 3", THREE, true, false, on_three, run_three<cv::SOLVEPNP_AP3P>},
    {"SQPNP 3", THREE, true, false, on_three, run_all<cv::SOLVEPNP_SQPNP>},
};

enum { METHODS = sizeof methods / sizeof methods[0] };

/* What is measured. It is not inlined, so that callgrind can find it by its name. */
extern "C" __attribute__((noinline)) void bench_call(const method *m, outcome *o,
                                                     const problem *p)
{
    o->n_poses = 0;
    o->rvecs.clear();
    o->tvecs.clear();
    try {
        m->run(*o, *p);
    } catch (const cv::Exception &) {
        o->rvecs.clear();
    }
}

/* ---- a cell: one method on one kind of scene ----------------------------- */

struct cell {
    int none, wrong, right, with_second, second_missing;
    double squares[2];
    std::vector<double> ratios; /* time over rigcal's, one for each batch */
    /* scenes of three points in which the truth is missing */
    int truth_missing;
    double returned, missing;
};

/* A line of the tables. */
struct row {
    const bench_family *f;
    int n;
    bench_view view;
    int scenes;
    cell minimum; /* errors of the best minimum itself */
    cell cells[METHODS];
};

enum { BATCH = 50 };

struct batch {
    int n;
    problem problems[BATCH];
    outcome outcomes[METHODS][BATCH];
};

static void add_error(cell &c, const bench_scene &s, const double R[9], const double t[3])
{
    double deviation[6], squares[2];

    if (!bench_bound(deviation, &s)) {
        return;
    }
    bench_squares(squares, &s, deviation, R, t);
    c.right++;
    c.squares[0] += squares[0];
    c.squares[1] += squares[1];
}

static bool is_answered(bench_minima &m, int minimum, const answers &a)
{
    for (int i = 0; i < a.n; i++) {
        if (bench_minima_add(&m, a.R[i], a.t[i]) == minimum) {
            return true;
        }
    }
    return false;
}

/* Returns 0 if there is no answer, or if another minimum is better. A method that starts
 * near the truth is also right in the minimum in which the truth lies. */
static bool judge_first(cell &c, const answers &a, bench_minima &m, bool is_near)
{
    if (a.n == 0) {
        c.none++;
        return false;
    }
    const int first = bench_minima_add(&m, a.R[0], a.t[0]);

    if (first >= 0 && first == m.truth) {
        add_error(c, *m.scene, a.R[0], a.t[0]);
        if (is_near) {
            return true;
        }
    }
    if (!bench_is_best(&m, first, BENCH_SUM_TOL)) {
        c.wrong++;
        return false;
    }
    return true;
}

static void judge_second(cell &c, const answers &a, bench_minima &m)
{
    const int second = bench_minima_ranked(&m, 1);

    if (second >= 0) {
        c.with_second++;
        c.second_missing += !is_answered(m, second, a);
    }
}

/* Minima that fit three points to rounding are exact poses. Nothing shows which one is
 * right. */
#define EXACT_PX 1e-6

static bool judge_three(cell &c, const answers &a, bench_minima &m)
{
    c.none += a.n == 0;
    c.returned += a.n;
    for (int i = 0; i < m.n; i++) {
        if (m.list[i].sse < EXACT_PX * EXACT_PX) {
            c.missing += !is_answered(m, i, a);
        }
    }
    if (m.truth >= 0 && is_answered(m, m.truth, a)) {
        return true;
    }
    c.truth_missing++;
    return false;
}

static bool is_used(const method &m, const row &r)
{
    return (r.n == 3) == (m.where == THREE) && m.is_defined(r.f, r.n);
}

/* The minima of all answers are collected before the first answer is judged. */
static void judge_scene(row &r, const batch &b, int scene, long index, bool list)
{
    const bench_scene &s = b.problems[scene].scene;
    static answers found[METHODS];
    bench_minima m;

    bench_minima_begin(&m, &s);
    for (int k = 0; k < METHODS; k++) {
        found[k].n = 0;
        if (is_used(methods[k], r)) {
            answers_from(found[k], b.outcomes[k][scene]);
        }
        for (int i = 0; i < found[k].n; i++) {
            (void)bench_minima_add(&m, found[k].R[i], found[k].t[i]);
        }
    }
    if (m.truth >= 0 && bench_is_best(&m, m.truth, BENCH_SUM_TOL)) {
        add_error(r.minimum, s, m.list[m.truth].R, m.list[m.truth].t);
    }
    for (int k = 0; k < METHODS; k++) {
        if (is_used(methods[k], r)) {
            cell &c = r.cells[k];
            const bool well = r.n == 3
                                  ? judge_three(c, found[k], m)
                                  : judge_first(c, found[k], m, methods[k].where == WARM);

            if (r.n > 3 && methods[k].several) {
                judge_second(c, found[k], m);
            }
            if (!well && list && methods[k].is_ours) {
                std::fprintf(stderr, "%s %d %ld %g %g %g: %s\n", r.f->name, r.n, index,
                             r.view.sigma, r.view.nearest, r.view.farthest,
                             methods[k].name);
            }
        }
    }
}

/* Processor seconds of this thread alone, so that other load of the machine does not
 * count. */
static double seconds()
{
    timespec now;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Runs each method over the whole batch, one after the other. */
static void measure(row &r, batch &b)
{
    double took[METHODS] = {0}, base = 0;

    for (int k = 0; k < METHODS; k++) {
        if (!is_used(methods[k], r)) {
            continue;
        }
        const double begin = seconds();

        for (int i = 0; i < b.n; i++) {
            bench_call(&methods[k], &b.outcomes[k][i], &b.problems[i]);
        }
        took[k] = seconds() - begin;
        if (base == 0) {
            base = took[k];
        }
        r.cells[k].ratios.push_back(took[k] / base);
    }
}

static void fill_batch(batch &b, const row &r, long from, int n)
{
    b.n = n;
    for (int i = 0; i < n; i++) {
        problem_make(b.problems[i], r.f, r.n, from + i, r.view);
    }
}

static void run_row(row &r, bool list)
{
    static batch b;
    row unused = r;

    fill_batch(b, r, 0, std::min<int>(BATCH, r.scenes));
    measure(unused, b); /* for what is done only once, and for the caches */
    for (long from = 0; from < r.scenes; from += BATCH) {
        fill_batch(b, r, from, (int)std::min<long>(BATCH, r.scenes - from));
        measure(r, b);
        for (int i = 0; i < b.n; i++) {
            judge_scene(r, b, i, from + i, list);
        }
    }
}

/* ---- tables -------------------------------------------------------------- */

static double median(std::vector<double> v)
{
    if (v.empty()) {
        return 0;
    }
    std::sort(v.begin(), v.end());
    return (v[(v.size() - 1) / 2] + v[v.size() / 2]) / 2;
}

static void print_number(double x)
{
    std::printf(x < 9.995 ? "%.2f" : x < 99.95 ? "%.1f" : "%.0f", x);
}

typedef void (*cell_printer)(const row &r, const cell &c);

static void print_error(const row &, const cell &c)
{
    if (c.right == 0) {
        std::printf("-");
        return;
    }
    print_number(std::sqrt(c.squares[0] / c.right));
    std::printf(", ");
    print_number(std::sqrt(c.squares[1] / c.right));
}

static void print_wrong(const row &, const cell &c)
{
    if (c.none > 0) {
        std::printf("%d + %d", c.none, c.wrong);
    } else {
        std::printf("%d", c.wrong);
    }
}

static void print_warm(const row &r, const cell &c)
{
    print_wrong(r, c);
    std::printf("; ");
    print_error(r, c);
    std::printf("; ");
    print_number(median(c.ratios));
}

static void print_second(const row &, const cell &c)
{
    std::printf("%d", c.second_missing);
}

static void print_time(const row &, const cell &c)
{
    print_number(median(c.ratios));
}

static void print_noise(const bench_view &view)
{
    if (view.sigma > 0) {
        std::printf("%g px", view.sigma);
    } else {
        std::printf("whole px");
    }
}

static std::vector<int> columns(const std::vector<row> &rows,
                                bool (*wanted)(const method &))
{
    std::vector<int> chosen;

    for (int k = 0; k < METHODS; k++) {
        const bool used = std::any_of(rows.begin(), rows.end(),
                                      [k](const row &r) { return is_used(methods[k], r); });

        if (used && wanted(methods[k])) {
            chosen.push_back(k);
        }
    }
    return chosen;
}

/* with_view: noise and distance are columns. with_minimum: the errors of the minimum are,
 * too. */
static void print_table(const char *title, const std::vector<row> &rows,
                        bool (*wanted)(const method &), cell_printer print, bool with_view,
                        bool with_minimum)
{
    const std::vector<int> chosen = columns(rows, wanted);

    std::printf("\n%s:\n\n| target | points |", title);
    std::printf("%s%s", with_view ? " noise | sizes away |" : "",
                with_minimum ? " minimum |" : "");
    for (int k : chosen) {
        std::printf(" %s |", methods[k].name);
    }
    std::printf("\n| --- | ---: |%s%s", with_view ? " ---: | ---: |" : "",
                with_minimum ? " ---: |" : "");
    for (size_t i = 0; i < chosen.size(); i++) {
        std::printf(" ---: |");
    }
    for (const row &r : rows) {
        std::printf("\n| %s | %d |", r.f->name, r.n);
        if (with_view) {
            std::printf(" ");
            print_noise(r.view);
            std::printf(" | %g..%g |", r.view.nearest, r.view.farthest);
        }
        if (with_minimum) {
            std::printf(" ");
            print(r, r.minimum);
            std::printf(" |");
        }
        for (int k : chosen) {
            std::printf(" ");
            if (is_used(methods[k], r)) {
                print(r, r.cells[k]);
            }
            std::printf(" |");
        }
    }
    std::printf("\n");
    std::fflush(stdout);
}

static bool is_cold(const method &m)
{
    return m.where == COLD;
}

static bool is_warm(const method &m)
{
    return m.where == WARM;
}

static bool is_three(const method &m)
{
    return m.where == THREE;
}

static bool is_several(const method &m)
{
    return m.several;
}

static row row_of(const bench_family *f, int n, const bench_view &view, int scenes)
{
    row r{};

    r.f = f;
    r.n = n;
    r.view = view;
    r.scenes = scenes;
    return r;
}

/* Selects some of the rows. */
static std::vector<row> those(const std::vector<row> &rows, bool (*wanted)(const row &))
{
    std::vector<row> chosen;

    std::copy_if(rows.begin(), rows.end(), std::back_inserter(chosen), wanted);
    return chosen;
}

static bool is_flat(const row &r)
{
    return is_plane(r.f);
}

static bool is_short(const row &r)
{
    return r.n == 4 || r.n == 8 || r.n == 50;
}

static void print_accuracy(const std::vector<row> &rows, bool with_view)
{
    print_table("Wrong, or none + wrong", rows, is_cold, print_wrong, with_view, false);
    print_table("Error over bound, rotation, translation", rows, is_cold, print_error,
                with_view, true);
}

static void explain(int scenes)
{
    std::printf("rigcal %d.%d.%d, %s; OpenCV %s. %d scenes a line.\n", RIGCAL_VERSION_MAJOR,
                RIGCAL_VERSION_MINOR, RIGCAL_VERSION_PATCH, BENCH_BUILD,
                cv::getVersionString().c_str(), scenes);
}

static void bench_targets(int scenes, double sigma, bool list)
{
    static const int counts[] = {4, 6, 8, 12, 20, 50};
    const bench_view view = {3, 30, sigma};
    std::vector<row> rows;

    explain(scenes);
    std::printf("Noise: ");
    print_noise(view);
    std::printf(", %g to %g sizes away.\n", view.nearest, view.farthest);
    for (const bench_family &f : bench_families) {
        for (int n : counts) {
            if (bench_has(&f, n)) {
                rows.push_back(row_of(&f, n, view, scenes));
                run_row(rows.back(), list);
            }
        }
    }
    print_accuracy(rows, false);
    print_table("Second not returned", those(rows, is_flat), is_several, print_second,
                false, false);
    print_table("Time over rigcal's", those(rows, is_short), is_cold, print_time, false,
                false);
    print_table("From a start 2 degrees and 2 % off: wrong; error over bound; time "
                "over that of rigcal without it",
                those(rows, is_short), is_warm, print_warm, false, false);
}

static void bench_noises(int scenes, bool list)
{
    static const bench_view views[] = {
        {3, 10, 0.1}, {3, 10, 0.5}, {3, 10, 2}, {3, 10, 0}, {10, 30, 0.5}};
    std::vector<row> rows;

    explain(scenes);
    for (const bench_family &f : bench_families) {
        for (const bench_view &view : views) {
            rows.push_back(row_of(&f, f.is_tag ? 4 : 8, view, scenes));
            run_row(rows.back(), list);
        }
    }
    print_accuracy(rows, true);
}

static void print_three(const row &r, const cell &c)
{
    std::printf("%d, %d, ", c.none, c.truth_missing);
    print_number(c.missing / r.scenes);
    std::printf(", ");
    print_number(c.returned / r.scenes);
}

static void bench_three(int scenes, double sigma, bool list)
{
    const bench_view view = {3, 30, sigma};
    std::vector<row> rows;

    explain(scenes);
    for (const bench_family &f : bench_families) {
        if (bench_has(&f, 3) && !is_plane(&f)) {
            rows.push_back(row_of(&f, 3, view, scenes));
            run_row(rows.back(), list);
        }
    }
    print_table("No answer, the true one missing, others missing a scene, "
                "returned a scene",
                rows, is_three, print_three, false, false);
    print_table("Time over rigcal's", rows, is_three, print_time, false, false);
}

/* ---- one scene ----------------------------------------------------------- */

static void bench_replay(const bench_family *f, int n, long index, const bench_view &view)
{
    static batch b;
    row r = row_of(f, n, view, 1);
    bench_minima m;

    fill_batch(b, r, index, 1);
    measure(r, b);
    const bench_scene &s = b.problems[0].scene;

    bench_minima_begin(&m, &s);
    for (int k = 0; k < METHODS; k++) {
        answers a;

        if (!is_used(methods[k], r)) {
            continue;
        }
        answers_from(a, b.outcomes[k][0]);
        std::printf("%s: %d\n", methods[k].name, a.n);
        for (int i = 0; i < a.n; i++) {
            const test_data data = {&s.camera, s.seen, nullptr, s.n};

            std::printf("  sum %.9g, in minimum %d\n", test_sse(&data, a.R[i], a.t[i]),
                        bench_minima_add(&m, a.R[i], a.t[i]));
        }
    }
    for (int i = 0; i < m.n; i++) {
        std::printf("minimum %d: sum %.9g, %.3f degrees from the truth%s\n", i,
                    m.list[i].sse, test_angle_between(m.list[i].R, s.R) / BENCH_DEGREE,
                    i == m.truth ? ", which lies in it" : "");
    }
}

static void bench_methods(const bench_family *f, int n)
{
    const row r = row_of(f, n, bench_view{3, 30, 0.5}, 1);

    for (const method &m : methods) {
        if (is_used(m, r)) {
            std::printf("%s\n", m.name);
        }
    }
}

static void bench_solve(const bench_family *f, int n, const method *m, int count)
{
    const row r = row_of(f, n, bench_view{3, 30, 0.5}, 1);
    problem p;
    outcome o{};
    long allocations = 0;

    if (!is_used(*m, r)) {
        fail("the method is not defined there");
    }
    for (long i = 0; i < count; i++) {
        problem_make(p, f, n, i, r.view);
        if (i == 0) {
            m->run(o, p); /* for what is done only once */
        }
        const long before = heap_calls;

        bench_call(m, &o, &p);
        allocations += heap_calls - before;
    }
    std::printf("%.0f\n", (double)allocations / count);
}

/* ---- the program --------------------------------------------------------- */

[[noreturn]] static void usage()
{
    fail("usage: bench_opencv targets [SCENES] [NOISE] | noises [SCENES] | "
         "three [SCENES] [NOISE], each with [--list] | "
         "replay FAMILY N INDEX NOISE NEAREST FARTHEST | methods FAMILY N | "
         "solve FAMILY N METHOD COUNT");
}

static int whole_number(const std::string &text, int least, int most)
{
    char *end;
    const long number = std::strtol(text.c_str(), &end, 10);

    if (text.empty() || *end != '\0' || number < least || number > most) {
        fail(text + " is no number from " + std::to_string(least) + " to " +
             std::to_string(most));
    }
    return (int)number;
}

static double noise_of(const std::string &text)
{
    char *end;
    const double sigma = std::strtod(text.c_str(), &end);

    if (text.empty() || *end != '\0' || !(sigma >= 0 && sigma <= 100)) {
        fail("NOISE must be from 0 to 100");
    }
    return sigma;
}

/* A distance at which no target reaches behind the camera. */
static double distance_of(const std::string &text)
{
    return whole_number(text, 2, 1000);
}

static const bench_family *family_of(const std::string &name)
{
    const bench_family *const f = bench_family_of(name.c_str());

    if (!f) {
        fail("there is no family " + name);
    }
    return f;
}

static const method *method_of(const std::string &name)
{
    for (const method &m : methods) {
        if (name == m.name) {
            return &m;
        }
    }
    fail("there is no method " + name);
}

static int silent(int, const char *, const char *, const char *, int, void *)
{
    return 0;
}

int main(int argc, char **argv)
{
    enum { SCENES = 500, SCENES_MAX = 1000000 };
    std::vector<std::string> args(argv + 1, argv + argc);
    const auto listed = std::find(args.begin(), args.end(), "--list");
    const bool list = listed != args.end();

    if (list) {
        args.erase(listed);
    }
    if (args.empty()) {
        usage();
    }
    const auto scenes = [&args] {
        return args.size() > 1 ? whole_number(args[1], 1, SCENES_MAX) : (int)SCENES;
    };
    const auto noise = [&args] { return args.size() > 2 ? noise_of(args[2]) : 0.5; };

    cv::setNumThreads(1);
    cv::ocl::setUseOpenCL(false);
    cv::redirectError(silent);
    if (args[0] == "targets" && args.size() <= 3) {
        bench_targets(scenes(), noise(), list);
    } else if (args[0] == "noises" && args.size() <= 2) {
        bench_noises(scenes(), list);
    } else if (args[0] == "three" && args.size() <= 3) {
        bench_three(scenes(), noise(), list);
    } else if (args[0] == "replay" && args.size() == 7) {
        bench_replay(
            family_of(args[1]), whole_number(args[2], 3, TEST_SCENE_MAX),
            whole_number(args[3], 0, SCENES_MAX),
            bench_view{distance_of(args[5]), distance_of(args[6]), noise_of(args[4])});
    } else if (args[0] == "methods" && args.size() == 3) {
        bench_methods(family_of(args[1]), whole_number(args[2], 3, TEST_SCENE_MAX));
    } else if (args[0] == "solve" && args.size() == 5) {
        bench_solve(family_of(args[1]), whole_number(args[2], 3, TEST_SCENE_MAX),
                    method_of(args[3]), whole_number(args[4], 1, SCENES_MAX));
    } else {
        usage();
    }
    return 0;
}
