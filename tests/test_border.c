/* border: parameters beside cameras and placements, compared with one dense matrix of all
 * unknowns, from which the placements are eliminated by Gauss's method. */
#include <math.h>
#include <string.h>

#include "rc_border.h"
#include "test_rigs.h"

enum {
    CAMERAS = 4, /* the second is held */
    PLACEMENTS = 5,
    COLUMNS = 2 * CAMERAS + 3, /* two for each camera, and three for all cameras */
    ROWS = 10,                 /* measured numbers in a view */
    N = 6 * (CAMERAS - 1),
    ALL = N + COLUMNS + 6 * PLACEMENTS,
    Q_SIZE = 3 * CAMERAS + 6
};

/* The first column that Q stores in each row: those of one camera, and the last three. */
static const uint16_t FIRST[COLUMNS] = {0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 8};

/* Rows of J by cam_from_target, rows of D, and e. */
typedef struct {
    double J[ROWS][6], D[ROWS][COLUMNS], e[ROWS];
} measured;

/* All unknowns: cameras, columns, placements. M x = b. */
typedef struct {
    double M[ALL][ALL], b[ALL];
} dense;

static int first_unknown(int camera)
{
    return (camera == 1) ? -1 : (camera == 0) ? 0 : 6 * (camera - 1);
}

static int is_seen(int camera, int placement)
{
    return !(camera == 2 && placement == 1) && !(camera == 0 && placement == 3);
}

static void measure(measured *m, test_rng *rng, int camera)
{
    memset(m, 0, sizeof *m);
    for (int row = 0; row < ROWS; row++) {
        for (int k = 0; k < 6; k++) {
            m->J[row][k] = test_uniform(rng, -1, 1);
        }
        for (int k = 0; k < COLUMNS; k++) {
            if (k >= 2 * CAMERAS || k / 2 == camera) {
                m->D[row][k] = test_uniform(rng, -1, 1);
            }
        }
        m->e[row] = test_uniform(rng, -1, 1);
    }
}

/* The row of the dense problem for row `row` of a view. */
static void dense_row(double out[ALL], const measured *m, int row, int camera,
                      int placement, const rigcal_transform *C, const rigcal_transform *P)
{
    double R[9], t[3], t_p[3], a[3];
    const double *const J = m->J[row];

    test_transform_parts(R, t, C);
    test_transform_parts(NULL, t_p, P);
    test_apply(a, R, t_p, NULL);
    memset(out, 0, ALL * sizeof *out);
    if (first_unknown(camera) >= 0) { /* J A, A = (1 0; -[a]x 1) */
        double v[3];

        test_cross(v, a, &J[3]);
        for (int k = 0; k < 3; k++) {
            out[first_unknown(camera) + k] = J[k] + v[k];
            out[first_unknown(camera) + 3 + k] = J[3 + k];
        }
    }
    for (int k = 0; k < COLUMNS; k++) {
        out[N + k] = m->D[row][k];
    }
    for (int k = 0; k < 6; k++) { /* J B, B = (R 0; 0 R) */
        for (int i = 0; i < 3; i++) {
            out[N + COLUMNS + 6 * placement + k] += J[3 * (k / 3) + i] * R[3 * i + k % 3];
        }
    }
}

static void add_dense(dense *d, const double row[ALL], double e)
{
    for (int i = 0; i < ALL; i++) {
        for (int j = 0; j < ALL; j++) {
            d->M[i][j] += row[i] * row[j];
        }
        d->b[i] += row[i] * e;
    }
}

/* Eliminates the unknowns from `keep` on. */
static void eliminate(dense *d, int keep, int n)
{
    for (int p = n - 1; p >= keep; p--) {
        for (int i = 0; i < p; i++) {
            const double part = d->M[i][p] / d->M[p][p];

            for (int j = 0; j < p; j++) {
                d->M[i][j] -= part * d->M[p][j];
            }
            d->b[i] -= part * d->b[p];
        }
    }
}

/* The inverse of the first N rows and columns, packed. */
static void invert_cameras(rigcal_real S_inverse[], const dense *d)
{
    static double A[N][2 * N];

    memset(A, 0, sizeof A);
    for (int i = 0; i < N; i++) {
        memcpy(A[i], d->M[i], N * sizeof(double));
        A[i][N + i] = 1;
    }
    for (int p = 0; p < N; p++) {
        const double by = 1 / A[p][p];

        for (int j = 0; j < 2 * N; j++) {
            A[p][j] *= by;
        }
        for (int i = 0; i < N; i++) {
            const double part = (i == p) ? 0 : A[i][p];

            for (int j = 0; j < 2 * N; j++) {
                A[i][j] -= part * A[p][j];
            }
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++) {
            S_inverse[rc_packed_at((size_t)i, (size_t)j)] = RC(A[i][N + j]);
        }
    }
}

/* A border and its memory. */
typedef struct {
    rigcal_real T[COLUMNS * N], Z[6 * COLUMNS], Q[Q_SIZE], q[COLUMNS];
    rigcal_real W[36 * CAMERAS], slot[CAMERAS];
    rc_border b;
} memory;

static void set_up(memory *m)
{
    m->b.n = N;
    m->b.k = COLUMNS;
    m->b.T = m->T;
    m->b.Z = m->Z;
    m->b.Q = m->Q;
    m->b.q = m->q;
    m->b.first = FIRST;
    m->b.W = m->W;
    m->b.slot = m->slot;
}

/* Adds a view as a caller does. */
static void add_view(rc_border *b, const measured *m, int camera, const rc_chain *chain)
{
    static const int AT[6][6] = {{0, 1, 2, 6, 7, 8},      {1, 3, 4, 9, 10, 11},
                                 {2, 4, 5, 12, 13, 14},   {6, 9, 12, 15, 16, 17},
                                 {7, 10, 13, 16, 18, 19}, {8, 11, 14, 17, 19, 20}};
    rigcal_real g[6] = {0}, H[21] = {0}, E[COLUMNS][6];

    memset(E, 0, sizeof E);
    for (int row = 0; row < ROWS; row++) {
        for (int i = 0; i < 6; i++) {
            g[i] += RC(m->J[row][i] * m->e[row]);
            for (int j = i; j < 6; j++) {
                H[AT[i][j]] += RC(m->J[row][i] * m->J[row][j]);
            }
        }
        for (int k = 0; k < COLUMNS; k++) {
            for (int i = 0; i < 6; i++) {
                E[k][i] += RC(m->J[row][i] * m->D[row][k]);
            }
            for (int j = FIRST[k]; j <= k; j++) {
                b->Q[rc_border_at(b, (size_t)k, (size_t)j)] +=
                    RC(m->D[row][k] * m->D[row][j]);
            }
            b->q[k] += RC(m->D[row][k] * m->e[row]);
        }
    }
    rc_border_view(b, chain, RC(first_unknown(camera)), g, H);
    for (int k = 0; k < COLUMNS; k++) {
        if (k >= 2 * CAMERAS || k / 2 == camera) {
            rc_border_add(b, chain, (size_t)k, E[k]);
        }
    }
}

static void see_all(dense *d, rc_border *b, test_rng *rng)
{
    rigcal_transform C[CAMERAS];

    memset(d, 0, sizeof *d);
    for (int c = 0; c < CAMERAS; c++) {
        C[c] = test_random_transform(rng);
    }
    rc_border_begin(b);
    for (int f = 0; f < PLACEMENTS; f++) {
        const rigcal_transform P = test_random_transform(rng);

        if (f > 0) {
            rc_border_next(b);
        }
        for (int c = 0; c < CAMERAS; c++) {
            rc_chain chain;
            measured m;

            if (is_seen(c, f)) {
                measure(&m, rng, c);
                for (int row = 0; row < ROWS; row++) {
                    double whole[ALL];

                    dense_row(whole, &m, row, c, f, &C[c], &P);
                    add_dense(d, whole, m.e[row]);
                }
                rc_chain_of(&chain, &C[c], &P);
                add_view(b, &m, c, &chain);
            }
        }
        TEST_ASSERT_TRUE(rc_border_eliminate(b));
    }
}

#define TOL_SUM TOL(1e-10, 2e-3)

static void test_the_border_is_that_of_the_whole_matrix(void)
{
    test_rng rng = test_seed(7001);

    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        static dense d;
        static memory m;

        set_up(&m);
        TEST_ASSERT_EQUAL_INT(Q_SIZE, rc_border_size(&m.b));
        see_all(&d, &m.b, &rng);
        eliminate(&d, N + COLUMNS, ALL);
        for (int k = 0; k < COLUMNS; k++) {
            ASSERT_ARRAY_NEAR(d.M[N + k], &m.T[N * k], N, TOL_SUM);
            ASSERT_NEAR(d.b[N + k], m.q[k], TOL_SUM);
            for (int j = FIRST[k]; j <= k; j++) {
                ASSERT_NEAR(d.M[N + k][N + j],
                            m.Q[rc_border_at(&m.b, (size_t)k, (size_t)j)], TOL_SUM);
            }
        }
    }
}

static void test_information_and_slope_are_without_the_cameras(void)
{
    test_rng rng = test_seed(7002);

    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        static dense d, by_cameras;
        static memory m;
        rigcal_real S_inverse[N * (N + 1) / 2], G[N], g[N];

        set_up(&m);
        see_all(&d, &m.b, &rng);
        eliminate(&d, N + COLUMNS, ALL);
        invert_cameras(S_inverse, &d);
        test_to_real(g, d.b, N);
        /* Eliminates the cameras last. */
        for (int i = 0; i < N + COLUMNS; i++) {
            const int to = (i < N) ? i + COLUMNS : i - N;

            for (int j = 0; j < N + COLUMNS; j++) {
                by_cameras.M[to][(j < N) ? j + COLUMNS : j - N] = d.M[i][j];
            }
            by_cameras.b[to] = d.b[i];
        }
        eliminate(&by_cameras, COLUMNS, N + COLUMNS);
        for (int k = 0; k < COLUMNS; k++) {
            rc_border_effect(G, &m.b, S_inverse, (size_t)k);
            ASSERT_NEAR(by_cameras.b[k], rc_border_slope(&m.b, (size_t)k, G, g),
                        10 * TOL_SUM);
            ASSERT_NEAR(D(m.q[k]), rc_border_slope(&m.b, (size_t)k, G, NULL), 0);
            for (int i = k; i < COLUMNS && FIRST[i] <= k; i++) {
                ASSERT_NEAR(by_cameras.M[i][k],
                            rc_border_information(&m.b, (size_t)i, (size_t)k, G),
                            10 * TOL_SUM);
            }
        }
    }
}

static void test_a_placement_that_is_not_known_adds_nothing(void)
{
    test_rng rng = test_seed(7003);
    static dense d;
    static memory m, before;
    rc_chain chain;
    rigcal_real g[6] = {1, 0, 0, 0, 0, 0}, H[21] = {1};
    const rigcal_transform C = test_random_transform(&rng), P = test_random_transform(&rng);

    set_up(&m);
    see_all(&d, &m.b, &rng);
    rc_border_next(&m.b);
    before = m;
    rc_chain_of(&chain, &C, &P);
    rc_border_view(&m.b, &chain, 0, g, H);
    TEST_ASSERT_FALSE(rc_border_eliminate(&m.b));
    TEST_ASSERT_EQUAL_MEMORY(before.T, m.T, sizeof m.T);
    TEST_ASSERT_EQUAL_MEMORY(before.Q, m.Q, sizeof m.Q);
    TEST_ASSERT_EQUAL_MEMORY(before.q, m.q, sizeof m.q);
}

static void test_without_columns_there_is_nothing(void)
{
    rc_border b;

    memset(&b, 0, sizeof b);
    TEST_ASSERT_EQUAL_size_t(0, rc_border_size(&b));
}

TEST_MAIN()
{
    RUN_TEST(test_without_columns_there_is_nothing);
    RUN_TEST(test_the_border_is_that_of_the_whole_matrix);
    RUN_TEST(test_information_and_slope_are_without_the_cameras);
    RUN_TEST(test_a_placement_that_is_not_known_adds_nothing);
}
