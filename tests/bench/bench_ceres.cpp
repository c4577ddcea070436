/* bench_ceres: rigcal_rig_adjust beside Ceres, on the same rigs (bench_rigs.h) from the
 * same starts in one process, one thread each. Built and run by rig.sh.
 *
 *   bench_ceres methods
 *       what there is
 *   bench_ceres compare C F N [REPEATS]
 *       runs all: exit status 1 unless they end in the same minimum with the same
 *       covariance of the cameras. Prints the least CPU time of REPEATS (default 1), a line
 *       a method
 *   bench_ceres solve C F N METHOD
 *       only solves, for callgrind: bench_call is what counts
 *
 * A method of Ceres is named by its derivatives, its residual blocks and its linear solver:
 * hand-written of a whole view, hand-written of a point, automatic of a point. Poses are a
 * rotation vector and t in both. What counts is from the making of the problem to the
 * poses; with "+cov" to the covariance of all cameras, cross terms included, which rigcal
 * always computes. Ceres has the lens without its rational terms. */
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

extern "C" {
#include "bench_rigs.h"
#include "test_fit.h"

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

static_assert(sizeof(rigcal_real) == sizeof(double), "Ceres computes in double");

/* Relative tolerances: of the sums of squares, and of the standard deviations. */
static const double SAME_SUM = 1e-8, SAME_DEVIATION = 1e-4;
/* Tolerance of the cameras' poses, in their own standard deviations. */
static const double SAME_POSE = 1e-2;

/* Ceres ends if a step lowers the sum by less than this part. rigcal ends if the expected
 * further decrease is less. */
static const double ENOUGH = 1e-10;

[[noreturn]] static void fail(const std::string &why)
{
    std::fprintf(stderr, "bench_ceres: %s\n", why.c_str());
    std::exit(2);
}

/* ---- residuals ----------------------------------------------------------- */

/* The pixel of a point p of the camera's frame. */
template <class T> static void project(T uv[2], const rigcal_camera &k, const T p[3])
{
    const T x = p[0] / p[2], y = p[1] / p[2], s = x * x + y * y;
    const T d = 1.0 + s * (k.k1 + s * (k.k2 + s * k.k3));

    uv[0] = k.fx * (x * d + 2.0 * k.p1 * x * y + k.p2 * (s + 2.0 * x * x)) + k.cx;
    uv[1] = k.fy * (y * d + k.p1 * (s + 2.0 * y * y) + 2.0 * k.p2 * x * y) + k.cy;
}

/* uv and its derivative J[6] by p, row by row. */
static void project_with(double uv[2], double J[6], const rigcal_camera &k,
                         const double p[3])
{
    const double z = 1 / p[2], x = p[0] * z, y = p[1] * z, s = x * x + y * y;
    const double d = 1 + s * (k.k1 + s * (k.k2 + s * k.k3));
    const double slope = 2 * (k.k1 + s * (2 * k.k2 + 3 * s * k.k3)); /* derivative of d by
                                                                        s, doubled */
    const double cross = x * y * slope + 2 * k.p1 * x + 2 * k.p2 * y;
    const double xx = d + x * x * slope + 2 * k.p1 * y + 6 * k.p2 * x;
    const double yy = d + y * y * slope + 6 * k.p1 * y + 2 * k.p2 * x;

    uv[0] = k.fx * (x * d + 2 * k.p1 * x * y + k.p2 * (s + 2 * x * x)) + k.cx;
    uv[1] = k.fy * (y * d + k.p1 * (s + 2 * y * y) + 2 * k.p2 * x * y) + k.cy;
    J[0] = k.fx * xx * z;
    J[1] = k.fx * cross * z;
    J[2] = -(J[0] * x + J[1] * y);
    J[3] = k.fy * cross * z;
    J[4] = k.fy * yy * z;
    J[5] = -(J[3] * x + J[4] * y);
}

/* A pose as Ceres has it, turned into matrices: exp(w + dw) = exp(L dw) exp(w). */
struct matrices {
    double R[9], L[9];

    explicit matrices(const double w[3], bool with_L)
    {
        const double square = test_dot(w, w), angle = std::sqrt(square);
        const bool is_small = angle < 1e-4;
        const double a = is_small ? 0.5 - square / 24 : (1 - std::cos(angle)) / square;
        const double b = is_small ? 1.0 / 6 : (angle - std::sin(angle)) / (square * angle);

        ceres::AngleAxisToRotationMatrix(w, ceres::RowMajorAdapter3x3(R));
        if (!with_L) {
            return;
        }
        const double W[9] = {0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0};
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const double one = (i == j) ? 1 : 0;
                const double twice = w[i] * w[j] - one * square;

                L[3 * i + j] = one + a * W[3 * i + j] + b * twice;
            }
        }
    }
};

/* row[6]: derivative by w and t of a pose, if J is the derivative by the point y = R x +
 * t. */
static void chain(double row[6], const double J[3], const double Rx[3], const matrices &m)
{
    double turn[3];

    test_cross(turn, Rx, J);
    for (int k = 0; k < 3; k++) {
        row[k] = turn[0] * m.L[k] + turn[1] * m.L[3 + k] + turn[2] * m.L[6 + k];
        row[3 + k] = J[k];
    }
}

/* residual[2] of a point, and its rows by camera and by placement, each if it is wanted. */
static void point_by_hand(double residual[2], double *by_camera, double *by_placement,
                          const rigcal_camera &camera, const rigcal_observation &o,
                          const matrices &c, const double *t_c, const matrices &f,
                          const double *t_f)
{
    double RX[3], X_r[3], RX_r[3], X_c[3], uv[2], J[6];

    test_apply(RX, f.R, o.X_w, nullptr);
    for (int k = 0; k < 3; k++) {
        X_r[k] = RX[k] + t_f[k];
    }
    test_apply(RX_r, c.R, X_r, nullptr);
    for (int k = 0; k < 3; k++) {
        X_c[k] = RX_r[k] + t_c[k];
    }
    project_with(uv, J, camera, X_c);
    for (int i = 0; i < 2; i++) {
        const double *const row = &J[3 * i];
        double turned[3]; /* R_c^T row */

        residual[i] = uv[i] - o.uv[i];
        if (by_camera) {
            chain(by_camera + 6 * i, row, RX_r, c);
        }
        if (by_placement) {
            for (int k = 0; k < 3; k++) {
                turned[k] = row[0] * c.R[k] + row[1] * c.R[3 + k] + row[2] * c.R[6 + k];
            }
            chain(by_placement + 6 * i, turned, RX, f);
        }
    }
}

class view_by_hand : public ceres::CostFunction {
  public:
    explicit view_by_hand(const rigcal_view &view) : view_(view)
    {
        set_num_residuals(2 * (int)view.n);
        *mutable_parameter_block_sizes() = {6, 6};
    }

    bool Evaluate(double const *const *poses, double *residuals,
                  double **rows) const override
    {
        const matrices c(poses[0], rows != nullptr), f(poses[1], rows != nullptr);

        for (size_t i = 0; i < view_.n; i++) {
            point_by_hand(residuals + 2 * i, (rows && rows[0]) ? rows[0] + 12 * i : nullptr,
                          (rows && rows[1]) ? rows[1] + 12 * i : nullptr, *view_.camera,
                          view_.observations[i], c, poses[0] + 3, f, poses[1] + 3);
        }
        return true;
    }

  private:
    rigcal_view view_;
};

class one_by_hand : public ceres::SizedCostFunction<2, 6, 6> {
  public:
    one_by_hand(const rigcal_camera &camera, const rigcal_observation &o)
        : camera_(camera), o_(o)
    {
    }

    bool Evaluate(double const *const *poses, double *residuals,
                  double **rows) const override
    {
        const matrices c(poses[0], rows != nullptr), f(poses[1], rows != nullptr);

        point_by_hand(residuals, rows ? rows[0] : nullptr, rows ? rows[1] : nullptr,
                      camera_, o_, c, poses[0] + 3, f, poses[1] + 3);
        return true;
    }

  private:
    const rigcal_camera &camera_;
    const rigcal_observation &o_;
};

struct one_automatic {
    const rigcal_camera &camera;
    const rigcal_observation &o;

    template <class T> bool operator()(const T *c, const T *f, T *residual) const
    {
        const T X[3] = {T(o.X_w[0]), T(o.X_w[1]), T(o.X_w[2])};
        T X_r[3], X_c[3], uv[2];

        ceres::AngleAxisRotatePoint(f, X, X_r);
        for (int k = 0; k < 3; k++) {
            X_r[k] += f[3 + k];
        }
        ceres::AngleAxisRotatePoint(c, X_r, X_c);
        for (int k = 0; k < 3; k++) {
            X_c[k] += c[3 + k];
        }
        project(uv, camera, X_c);
        residual[0] = uv[0] - o.uv[0];
        residual[1] = uv[1] - o.uv[1];
        return true;
    }
};

/* ---- the methods --------------------------------------------------------- */

enum blocks { RIGCAL, VIEW_BY_HAND, POINT_BY_HAND, POINT_AUTOMATIC };

struct method {
    std::string name;
    blocks what;
    ceres::LinearSolverType solver;
    bool with_covariance;
};

static std::vector<method> all_methods()
{
    static const struct {
        const char *name;
        blocks what;
    } kinds[] = {{"hand, views", VIEW_BY_HAND},
                 {"hand, points", POINT_BY_HAND},
                 {"automatic, points", POINT_AUTOMATIC}};
    std::vector<method> list = {{"rigcal", RIGCAL, ceres::DENSE_SCHUR, true}};

    for (const auto &kind : kinds) {
        for (bool is_dense : {true, false}) {
            for (bool with : {false, true}) {
                list.push_back(
                    {std::string(kind.name) + (is_dense ? ", dense" : ", sparse") +
                         (with ? " +cov" : ""),
                     kind.what, is_dense ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR, with});
            }
        }
    }
    return list;
}

struct answer {
    double sum;
    int evaluations;
    std::vector<double> poses;      /* 12 for each pose: R, t; cameras, then placements */
    std::vector<double> deviations; /* 6 for each camera except the first, for 1 px; or
                                       empty */
    std::vector<double> raw;        /* what Ceres wrote: 6 for each pose */
};

static void poses_from(std::vector<double> &out, const rigcal_transform *poses, int n)
{
    for (int i = 0; i < n; i++) {
        out.insert(out.end(), poses[i].R, poses[i].R + 9);
        out.insert(out.end(), poses[i].t, poses[i].t + 3);
    }
}

static answer run_rigcal(bench_rig &b)
{
    answer a{};
    rigcal_rig_fit fit;

    bench_rig_reset(&b);
    if (bench_adjust(&fit, &b) != RIGCAL_OK) {
        fail("rigcal does not adjust it");
    }
    a.sum = fit.sum;
    a.evaluations = fit.evals;
    return a;
}

static void add_blocks(ceres::Problem &problem, double *poses, blocks what,
                       const bench_rig &b)
{
    for (size_t i = 0; i < b.rig.n_views; i++) {
        const rigcal_rig_view &v = b.views[i];
        double *const c = poses + 6 * v.camera;
        double *const f = poses + 6 * (b.n_cameras + v.placement);

        if (what == VIEW_BY_HAND) {
            problem.AddResidualBlock(new view_by_hand(v.view), nullptr, c, f);
            continue;
        }
        for (size_t j = 0; j < v.view.n; j++) {
            const rigcal_observation &o = v.view.observations[j];
            ceres::CostFunction *cost;

            if (what == POINT_BY_HAND) {
                cost = new one_by_hand(*v.view.camera, o);
            } else {
                cost = new ceres::AutoDiffCostFunction<one_automatic, 2, 6, 6>(
                    new one_automatic{*v.view.camera, o});
            }
            problem.AddResidualBlock(cost, nullptr, c, f);
        }
    }
    problem.SetParameterBlockConstant(poses);
}

/* The standard deviations of (w, dt) from those of the parameters, by L. */
static void deviations_of(std::vector<double> &out, const double Sigma[36],
                          const double pose[6])
{
    const matrices m(pose, true);

    for (int i = 0; i < 6; i++) {
        double variance = 0;

        if (i >= 3) {
            variance = Sigma[7 * i];
        }
        for (int j = 0; i < 3 && j < 3; j++) {
            for (int k = 0; k < 3; k++) {
                variance += m.L[3 * i + j] * Sigma[6 * j + k] * m.L[3 * i + k];
            }
        }
        out.push_back(std::sqrt(variance));
    }
}

static void add_covariance(std::vector<double> &Sigmas, ceres::Problem &problem,
                           const double *poses, const bench_rig &b)
{
    ceres::Covariance::Options options;
    std::vector<std::pair<const double *, const double *>> pairs;

    options.num_threads = 1;
    for (int i = 1; i < b.n_cameras; i++) {
        for (int j = 1; j <= i; j++) {
            pairs.emplace_back(poses + 6 * i, poses + 6 * j);
        }
    }
    ceres::Covariance covariance(options);

    if (!covariance.Compute(pairs, &problem)) {
        fail("Ceres has no covariance");
    }
    Sigmas.resize(36 * (size_t)b.n_cameras);
    for (int i = 1; i < b.n_cameras; i++) {
        covariance.GetCovarianceBlock(poses + 6 * i, poses + 6 * i,
                                      &Sigmas[36 * (size_t)i]);
    }
}

static answer run_ceres(std::vector<double> &Sigmas, const method &m,
                        const std::vector<double> &starts, const bench_rig &b)
{
    answer a{};
    ceres::Problem problem;
    ceres::Solver::Options options;
    ceres::Solver::Summary summary;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();

    a.raw = starts;
    double *const poses = a.raw.data();

    add_blocks(problem, poses, m.what, b);
    for (int i = 0; i < b.n_cameras + b.n_placements; i++) {
        ordering->AddElementToGroup(poses + 6 * i, (i < b.n_cameras) ? 1 : 0);
    }
    options.linear_solver_ordering = ordering;
    options.linear_solver_type = m.solver;
    options.num_threads = 1;
    options.function_tolerance = ENOUGH;
    options.logging_type = ceres::SILENT;
    ceres::Solve(options, &problem, &summary);
    if (summary.termination_type != ceres::CONVERGENCE) {
        fail("Ceres does not converge: " + summary.message);
    }
    if (m.with_covariance) {
        add_covariance(Sigmas, problem, poses, b);
    }
    a.sum = 2 * summary.final_cost;
    a.evaluations = summary.num_residual_evaluations;
    return a;
}

/* What is counted. It is a function of its own so that callgrind can find it. */
extern "C" __attribute__((noinline)) void bench_call(answer *a, std::vector<double> *Sigmas,
                                                     const method *m,
                                                     const std::vector<double> *starts,
                                                     bench_rig *b)
{
    *a = (m->what == RIGCAL) ? run_rigcal(*b) : run_ceres(*Sigmas, *m, *starts, *b);
}

static std::vector<double> starts_of(const bench_rig &b)
{
    std::vector<double> starts;

    for (int i = 0; i < b.n_cameras + b.n_placements; i++) {
        const double *const R = b.starts[i].R;
        double w[3];

        ceres::RotationMatrixToAngleAxis(ceres::RowMajorAdapter3x3(R), w);
        starts.insert(starts.end(), w, w + 3);
        starts.insert(starts.end(), b.starts[i].t, b.starts[i].t + 3);
    }
    return starts;
}

/* Completes the answer after the clock was stopped. */
static void complete(answer &a, const std::vector<double> &Sigmas, const method &m,
                     const bench_rig &b)
{
    if (m.what == RIGCAL) {
        poses_from(a.poses, b.poses, b.n_cameras + b.n_placements);
        for (int c = 1; c < b.n_cameras; c++) {
            double Sigma[36];

            if (rigcal_rig_covariance(Sigma, &b.rig, 1, (size_t)c) != RIGCAL_OK) {
                fail("rigcal has no covariance");
            }
            for (int k = 0; k < 6; k++) {
                a.deviations.push_back(std::sqrt(Sigma[7 * k]));
            }
        }
        return;
    }
    for (int i = 0; i < b.n_cameras + b.n_placements; i++) {
        const double *const pose = &a.raw[6 * (size_t)i];
        const matrices m_i(pose, false);

        a.poses.insert(a.poses.end(), m_i.R, m_i.R + 9);
        a.poses.insert(a.poses.end(), pose + 3, pose + 6);
    }
    for (int c = 1; m.with_covariance && c < b.n_cameras; c++) {
        deviations_of(a.deviations, &Sigmas[36 * (size_t)c], &a.raw[6 * (size_t)c]);
    }
}

/* ---- whether they agree -------------------------------------------------- */

/* The largest error of a camera's pose, in its standard deviations. */
static double off_by(const answer &a, const answer &rigcal, const bench_rig &b)
{
    double most = 0;

    for (int c = 1; c < b.n_cameras; c++) {
        double d[6];
        const double *const here = &a.poses[12 * (size_t)c];
        const double *const there = &rigcal.poses[12 * (size_t)c];

        test_difference(d, there, there + 9, here, here + 9);
        for (int k = 0; k < 6; k++) {
            const double sigma =
                BENCH_RIG_NOISE_PX * rigcal.deviations[6 * (size_t)(c - 1) + (size_t)k];

            most = std::fmax(most, std::fabs(d[k]) / sigma);
        }
    }
    return most;
}

static bool is_same(const answer &a, const answer &rigcal, const method &m,
                    const bench_rig &b)
{
    const double sum = std::fabs(a.sum / rigcal.sum - 1), pose = off_by(a, rigcal, b);
    double deviation = 0;

    for (size_t k = 0; k < a.deviations.size(); k++) {
        deviation =
            std::fmax(deviation, std::fabs(a.deviations[k] / rigcal.deviations[k] - 1));
    }
    if (sum <= SAME_SUM && pose <= SAME_POSE && deviation <= SAME_DEVIATION) {
        return true;
    }
    std::fprintf(stderr,
                 "bench_ceres: %s: sum off by %.2g of it, a pose by %.2g sigma, a sigma by "
                 "%.2g of it\n",
                 m.name.c_str(), sum, pose, deviation);
    return false;
}

/* ---- the program --------------------------------------------------------- */

static double seconds_of(answer &a, const method &m, bench_rig &b, int repeats)
{
    const std::vector<double> starts = starts_of(b);
    std::vector<double> Sigmas;
    double least = INFINITY;

    for (int i = 0; i < repeats; i++) {
        const clock_t begin = clock();

        bench_call(&a, &Sigmas, &m, &starts, &b);
        least = std::fmin(least, (double)(clock() - begin) / CLOCKS_PER_SEC);
    }
    complete(a, Sigmas, m, b);
    return least;
}

static int compare(bench_rig &b, int repeats)
{
    const std::vector<method> list = all_methods();
    answer rigcal;
    bool are_same = true;

    for (const method &m : list) {
        answer a;
        const double seconds = seconds_of(a, m, b, repeats);

        if (m.what == RIGCAL) {
            rigcal = a;
        }
        are_same &= is_same(a, rigcal, m, b);
        std::printf("%s;%.6f;%d;%.12g\n", m.name.c_str(), seconds, a.evaluations, a.sum);
    }
    return are_same ? 0 : 1;
}

static int number(const std::string &text, int least, int most)
{
    char *end;
    const long n = std::strtol(text.c_str(), &end, 10);

    if (text.empty() || *end != '\0' || n < least || n > most) {
        fail(text + " is no number from " + std::to_string(least) + " to " +
             std::to_string(most));
    }
    return (int)n;
}

static const method &method_of(const std::vector<method> &list, const std::string &name)
{
    for (const method &m : list) {
        if (m.name == name) {
            return m;
        }
    }
    fail("there is no method " + name);
}

int main(int argc, char **argv)
{
    enum { CAMERAS_MAX = 64, MANY = 10000 };
    const std::vector<std::string> args(argv + 1, argv + argc);
    const std::string what = args.empty() ? "" : args[0];
    const std::vector<method> list = all_methods();
    bench_rig b;
    answer a;

    if (what == "methods" && args.size() == 1) {
        for (const method &m : list) {
            std::printf("%s\n", m.name.c_str());
        }
        return 0;
    }
    if (!((what == "compare" && (args.size() == 4 || args.size() == 5)) ||
          (what == "solve" && args.size() == 5))) {
        fail("usage: bench_ceres methods | compare C F N [REPEATS] | solve C F N METHOD");
    }
    bench_rig_make(&b, number(args[1], 2, CAMERAS_MAX), number(args[2], 1, MANY),
                   number(args[3], 4, MANY), BENCH_RIG_SEED);
    if (what == "compare") {
        return compare(b, (args.size() == 5) ? number(args[4], 1, MANY) : 1);
    }
    (void)seconds_of(a, method_of(list, args[4]), b, 1);
    bench_rig_free(&b);
    return 0;
}
