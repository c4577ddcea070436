#include "test_fit.h"

#include <math.h>
#include <string.h>

static double middle_of(double middle[3], const test_data *data)
{
    double size = 0;

    middle[0] = middle[1] = middle[2] = 0;
    for (int i = 0; i < data->n; i++) {
        for (int k = 0; k < 3; k++) {
            middle[k] += D(data->observations[i].X_w[k]) / data->n;
        }
    }
    for (int i = 0; i < data->n; i++) {
        for (int k = 0; k < 3; k++) {
            const double x = D(data->observations[i].X_w[k]) - middle[k];

            size += x * x / data->n;
        }
    }
    return sqrt(size);
}

/* The 2 n errors over sigma, and their sum of squares. `t` is the place of the middle. */
static double errors_of(double e[], const test_data *data, const double middle[3],
                        const double R[9], const double t[3])
{
    double sum = 0;

    for (int i = 0; i < data->n; i++) {
        const double by = data->sigma ? 1 / D(data->sigma[i]) : 1;
        double x[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            x[k] = D(data->observations[i].X_w[k]) - middle[k];
        }
        test_apply(X_c, R, x, t);
        if (data->camera->lens == RIGCAL_LENS_BROWN && !(X_c[2] > 0)) {
            return 1e300;
        }
        test_project_px(uv, data->camera, X_c);
        for (int k = 0; k < 2; k++) {
            const double off = (D(data->observations[i].uv[k]) - uv[k]) * by;

            sum += off * off;
            if (e) {
                e[2 * i + k] = off;
            }
        }
    }
    return sum;
}

double test_sse(const test_data *data, const double R[9], const double t[3])
{
    static const double zero[3] = {0, 0, 0};

    return errors_of(NULL, data, zero, R, t);
}

void test_move(double R[9], double t[3], const double d[6])
{
    double turn[9], out[9];

    if (test_norm(d) > 0) {
        test_rotation_about(turn, d, test_norm(d));
        test_product(out, turn, R);
        memcpy(R, out, sizeof out);
    }
    for (int k = 0; k < 3; k++) {
        t[k] += d[3 + k];
    }
}

void test_difference(double d[6], const double R_from[9], const double t_from[3],
                     const double R_to[9], const double t_to[3])
{
    double back[9], turn[9], sine;

    test_transpose(back, R_from);
    test_product(turn, R_to, back);
    d[0] = (turn[7] - turn[5]) / 2;
    d[1] = (turn[2] - turn[6]) / 2;
    d[2] = (turn[3] - turn[1]) / 2;
    sine = test_norm(d);
    for (int k = 0; k < 3; k++) {
        d[k] *= sine > 0 ? test_angle_between(R_from, R_to) / sine : 1;
        d[3 + k] = t_to[k] - t_from[k];
    }
}

int test_solve(double x[], const double A[], const double b[], int n)
{
    double M[6][7];

    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            M[i][j] = A[n * i + j];
        }
        M[i][n] = b[i];
    }
    for (int c = 0; c < n; c++) {
        int best = c;

        for (int i = c + 1; i < n; i++) {
            best = fabs(M[i][c]) > fabs(M[best][c]) ? i : best;
        }
        if (!(fabs(M[best][c]) > 0)) {
            return 0;
        }
        for (int j = 0; j <= n; j++) {
            const double keep = M[c][j];

            M[c][j] = M[best][j];
            M[best][j] = keep;
        }
        for (int i = 0; i < n; i++) {
            const double f = i == c ? 0 : M[i][c] / M[c][c];

            for (int j = c; j <= n; j++) {
                M[i][j] -= f * M[c][j];
            }
        }
    }
    for (int i = 0; i < n; i++) {
        x[i] = M[i][n] / M[i][i];
    }
    return 1;
}

double test_squared_distance(const double d[], const double A[], int n)
{
    double x[6], sum = 0;

    TEST_ASSERT_TRUE_MESSAGE(test_solve(x, A, d, n), "singular covariance");
    for (int i = 0; i < n; i++) {
        sum += d[i] * x[i];
    }
    return sum;
}

/* J^T J and J^T e by central differences. The unit of moves is the target's size, so that
 * angles and moves have similar numbers. */
static void equations_of(double H[36], double g[6], const test_data *data,
                         const double middle[3], double size, const double R[9],
                         const double t[3])
{
    static double J[6][2 * TEST_SCENE_MAX];
    double e[2 * TEST_SCENE_MAX], plus[2 * TEST_SCENE_MAX], minus[2 * TEST_SCENE_MAX];
    const double h = 1e-5;

    (void)errors_of(e, data, middle, R, t);
    for (int k = 0; k < 6; k++) {
        double d[6] = {0, 0, 0, 0, 0, 0}, R2[9], t2[3];

        memcpy(R2, R, sizeof R2);
        memcpy(t2, t, sizeof t2);
        d[k] = k < 3 ? h : h * size;
        test_move(R2, t2, d);
        (void)errors_of(plus, data, middle, R2, t2);
        memcpy(R2, R, sizeof R2);
        memcpy(t2, t, sizeof t2);
        d[k] = -d[k];
        test_move(R2, t2, d);
        (void)errors_of(minus, data, middle, R2, t2);
        for (int i = 0; i < 2 * data->n; i++) {
            J[k][i] = (minus[i] - plus[i]) / (2 * h);
        }
    }
    for (int a = 0; a < 6; a++) {
        g[a] = 0;
        for (int i = 0; i < 2 * data->n; i++) {
            g[a] += J[a][i] * e[i];
        }
        for (int b = 0; b < 6; b++) {
            H[6 * a + b] = 0;
            for (int i = 0; i < 2 * data->n; i++) {
                H[6 * a + b] += J[a][i] * J[b][i];
            }
        }
    }
}

int test_fit(test_fitted *fitted, const test_data *data)
{
    double middle[3], shift[3], t[3], damping = 1e-4;
    const double size = middle_of(middle, data);
    int done = 0;

    test_apply(t, fitted->R, middle, fitted->t);
    fitted->sse = errors_of(NULL, data, middle, fitted->R, t);
    for (int step = 0; step < 200 && !done; step++) {
        double H[36], g[6];

        equations_of(H, g, data, middle, size, fitted->R, t);
        done = 1; /* unless this step gains something */
        for (int tries = 0; tries < 12; tries++) {
            double A[36], d[6], R2[9], t2[3], sse;

            memcpy(A, H, sizeof A);
            for (int k = 0; k < 6; k++) {
                A[7 * k] += damping * H[7 * k];
            }
            if (!test_solve(d, A, g, 6)) {
                return 0;
            }
            memcpy(R2, fitted->R, sizeof R2);
            memcpy(t2, t, sizeof t2);
            for (int k = 3; k < 6; k++) {
                d[k] *= size;
            }
            if (test_norm(d) < 1) {
                test_move(R2, t2, d);
                sse = errors_of(NULL, data, middle, R2, t2);
            } else {
                sse = 1e300;
            }
            if (sse < fitted->sse) {
                done = fitted->sse - sse <= 1e-14 * fitted->sse;
                memcpy(fitted->R, R2, sizeof R2);
                memcpy(t, t2, sizeof t2);
                fitted->sse = sse;
                damping *= 0.1;
                break;
            }
            damping = 10 * damping > 1e-7 ? 10 * damping : 1e-7;
        }
    }
    test_apply(shift, fitted->R, middle, NULL);
    for (int k = 0; k < 3; k++) {
        fitted->t[k] = t[k] - shift[k];
    }
    return done;
}

/* Powers of (trace C - C) converge to the direction of least extent. */
static void thin_direction(double normal[3], const test_data *data, const double middle[3])
{
    double C[9] = {0}, trace = 0;

    for (int i = 0; i < data->n; i++) {
        double x[3];

        for (int k = 0; k < 3; k++) {
            x[k] = D(data->observations[i].X_w[k]) - middle[k];
            trace += x[k] * x[k];
        }
        for (int k = 0; k < 9; k++) {
            C[k] -= x[k / 3] * x[k % 3];
        }
    }
    for (int k = 0; k < 9; k += 4) {
        C[k] += trace;
    }
    for (int i = 0; i < 12; i++) {
        double square[9], largest = 0;

        test_product(square, C, C);
        for (int k = 0; k < 9; k++) {
            largest = fabs(square[k]) > largest ? fabs(square[k]) : largest;
        }
        for (int k = 0; k < 9; k++) {
            C[k] = square[k] / largest;
        }
    }
    for (int k = 0; k < 3; k++) {
        normal[k] = C[k] + 0.618 * C[3 + k] + 0.382 * C[6 + k];
    }
    trace = test_norm(normal);
    for (int k = 0; k < 3; k++) {
        normal[k] /= trace;
    }
}

/* H = I - 2 v v^T mirrors the points in the plane that faces the camera. H R (I - 2 N N^T)
 * is a rotation that does the same to a target with the normal N. */
void test_mirror_tilt(test_fitted *mirrored, const test_data *data, const double R[9],
                      const double t[3])
{
    double middle[3], v[3], N[3], H[9], M[9], HR[9], shift[3];
    double length;

    (void)middle_of(middle, data);
    thin_direction(N, data, middle);
    test_apply(v, R, middle, t);
    length = test_norm(v);
    for (int k = 0; k < 9; k++) {
        const double one = k % 4 == 0;

        H[k] = one - 2 * v[k / 3] * v[k % 3] / (length * length);
        M[k] = one - 2 * N[k / 3] * N[k % 3];
    }
    test_product(HR, H, R);
    test_product(mirrored->R, HR, M);
    test_apply(shift, mirrored->R, middle, NULL);
    for (int k = 0; k < 3; k++) {
        mirrored->t[k] = v[k] - shift[k];
    }
    mirrored->sse = 0;
}

double test_lower(const double H[21], int i, int j)
{
    return H[i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i];
}

/* The blocks of w and of dt have the order xx, xy, xz, yy, yz, zz. The order of the blocks
 * is w, across, dt. */
double test_in_blocks(const rigcal_real H[21], int i, int j)
{
    static const int SYMMETRIC[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

    if (i < 3 && j < 3) {
        return D(H[SYMMETRIC[i][j]]);
    }
    if (i >= 3 && j >= 3) {
        return D(H[15 + SYMMETRIC[i - 3][j - 3]]);
    }
    return D((i < 3) ? H[6 + 3 * i + j - 3] : H[6 + 3 * j + i - 3]);
}
