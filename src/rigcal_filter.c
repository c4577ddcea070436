#include "rc_filter.h"

#include "rc_joint.h"
#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* standard deviations of noise: wrong matches are even over as much to either side. A
 * search of some pixels about the line has 10 to 100. */
#define WRONG_SPREAD RC(50)

/* 1: 1 / sqrt(2 pi), the density of a normal variable at its mean. */
#define NORMAL_DENSITY RC(0.398942280401432678)

/* 1: second-order terms of a row over its own size by first order, squared, for turns by a
 * radian. */
#define BEND RC(64)

/* part of a variance: what is less of it is rounding. A pivot has at least as much. */
#define PIVOT_LEAST (4 * RC_EPS)

/* rad: for turns up to this what is left of one is kept; the terms that are not looked at
 * are beyond rounding then. */
#define LEFT_TURN_MAX RC_TOL(1e-5, 1e-3)

/* ---- a factored covariance ---------------------------------------------------- */

/* room += U^T h of six unknowns from `at` on: of columns within them, then of those beyond.
 * */
static void add_part(rigcal_real room[], const rigcal_real UD[], size_t n, size_t at,
                     const rigcal_real h[6])
{
    const rigcal_real h0 = h[0], h1 = h[1], h2 = h[2], h3 = h[3], h4 = h[4], h5 = h[5];
    const rigcal_real *u = &UD[rc_packed_at(at, at)];
    rigcal_real *const f = &room[at];
    f[0] += h0;
    u += at + 1;
    f[1] += h1 + u[0] * h0;
    u += at + 2;
    f[2] += h2 + u[0] * h0 + u[1] * h1;
    u += at + 3;
    f[3] += h3 + u[0] * h0 + u[1] * h1 + u[2] * h2;
    u += at + 4;
    f[4] += h4 + u[0] * h0 + u[1] * h1 + u[2] * h2 + u[3] * h3;
    u += at + 5;
    f[5] += h5 + u[0] * h0 + u[1] * h1 + u[2] * h2 + u[3] * h3 + u[4] * h4;
    u += at + 6;
    for (size_t j = at + 6; j < n; j++) {
        room[j] += u[0] * h0 + u[1] * h1 + u[2] * h2 + u[3] * h3 + u[4] * h4 + u[5] * h5;
        u += j + 1;
    }
}

/* to += by from */
static void add_scaled(rigcal_real *to, const rigcal_real *from, size_t n, rigcal_real by)
{
    for (; n >= 4; n -= 4, to += 4, from += 4) {
        to[0] += from[0] * by;
        to[1] += from[1] * by;
        to[2] += from[2] * by;
        to[3] += from[3] * by;
    }
    for (; n > 0; n--, to++, from++) {
        *to += *from * by;
    }
}

rigcal_real rc_filter_seen(rigcal_real room[], const rigcal_real UD[], size_t n,
                           const rc_part *part)
{
    const rigcal_real *diagonal = UD;
    const rigcal_real zero =
        part->h[0][0] - part->h[0][0]; /* a C library's memset is slow */
    rigcal_real hPh = 0;
    for (size_t j = 0; j < n; j += 6) {
        rigcal_real *const six = &room[j];
        six[0] = six[1] = six[2] = six[3] = six[4] = six[5] = zero;
    }
    for (int k = 0; k < 2; k++) {
        if (part->at[k] >= 0) {
            add_part(room, UD, n, (size_t)part->at[k], part->h[k]);
        }
    }
    for (size_t j = 0; j < n; j++) {
        hPh += *diagonal * room[j] * room[j];
        diagonal += j + 2;
    }
    return hPh;
}

/* u += by b and b += v u, of n elements: four at a time, so that most instructions count.
 * */
static void exchange(rigcal_real *u, rigcal_real *b, size_t n, rigcal_real by,
                     rigcal_real v)
{
    for (; n >= 4; n -= 4, u += 4, b += 4) {
        const rigcal_real u0 = u[0], u1 = u[1], u2 = u[2], u3 = u[3];
        const rigcal_real b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
        u[0] = u0 + by * b0;
        u[1] = u1 + by * b1;
        u[2] = u2 + by * b2;
        u[3] = u3 + by * b3;
        b[0] = b0 + u0 * v;
        b[1] = b1 + u1 * v;
        b[2] = b2 + u2 * v;
        b[3] = b3 + u3 * v;
    }
    for (; n > 0; n--, u++, b++) {
        const rigcal_real u0 = *u, b0 = *b;
        *u = u0 + by * b0;
        *b = b0 + u0 * v;
    }
}

/* Bierman's update, of D - gain / S v v^T, v = D U^T h: alpha grows from S - gain hPh to S.
 * Where a row is doubted much, gain is negative, and P grows. */
void rc_filter_learn(rigcal_real UD[], rigcal_real room[], size_t n, rigcal_real hPh,
                     rigcal_real S, rigcal_real gain)
{
    rigcal_real alpha = S - gain * hPh;
    rigcal_real *column = UD;
    for (size_t j = 0; j < n; j++) {
        const rigcal_real f = room[j], v = column[j] * f;
        const rigcal_real before = alpha, by = -gain * f / before;
        alpha += gain * f * v;
        column[j] *= before / alpha;
        room[j] = v;
        if (v != 0) {
            exchange(column, room, j, by, v);
        }
        column += j + 1;
    }
}

rigcal_real rc_filter_bend(const rigcal_real UD[], size_t n, size_t first,
                           rigcal_real reach)
{
    rigcal_real turn = 0, shift = 0;
    for (size_t k = first; k < first + 3; k++) {
        turn += rc_filter_element(UD, n, k, k);
        shift += rc_filter_element(UD, n, k + 3, k + 3);
    }
    return BEND * (turn + shift / (reach * reach));
}

void rc_filter_doubt(rc_doubt *doubt, rigcal_real nu, rigcal_real S, rigcal_real wrong)
{
    const rigcal_real z2 = nu * nu / S;
    const rigcal_real right = (1 - wrong) * NORMAL_DENSITY * rc_exp(-z2 / 2) / RC_SQRT(S);
    doubt->likelihood = right + wrong / (2 * WRONG_SPREAD);
    doubt->beta = (wrong > 0) ? right / doubt->likelihood : 1;
    doubt->gain = doubt->beta * (1 - (1 - doubt->beta) * z2);
}

rigcal_real rc_filter_element(const rigcal_real UD[], size_t n, size_t i, size_t j)
{
    const size_t low = i < j ? i : j, high = i < j ? j : i;
    rigcal_real sum = UD[rc_packed_at(high, high)];
    sum *= (low < high) ? UD[rc_packed_at(high, low)] : 1;
    for (size_t k = high + 1; k < n; k++) {
        const rigcal_real *const column = &UD[rc_packed_at(k, 0)];
        sum += column[low] * column[k] * column[high];
    }
    return sum;
}

/* Column by column: those to the right are still U and D. */
void rc_filter_multiply(rigcal_real UD[], size_t n)
{
    rigcal_real *to = UD;
    for (size_t j = 0; j < n; j++) {
        for (size_t i = 0; i < j; i++) {
            to[i] *= to[j];
        }
        const rigcal_real *column = to + j + 1;
        for (size_t k = j + 1; k < n; k++) {
            add_scaled(to, column, j + 1, column[k] * column[j]);
            column += k + 1;
        }
        to += j + 1;
    }
}

/* From the last column on. A variance of 0 is known exactly, and has no column. */
void rc_filter_factor(rigcal_real P[], size_t n)
{
    for (size_t j = n; j-- > 0;) {
        rigcal_real *const column = &P[rc_packed_at(j, 0)];
        const rigcal_real pivot = column[j];
        const rigcal_real by = pivot > 0 ? 1 / pivot : 0;
        rigcal_real *to = P;
        for (size_t k = 0; k < j; k++) {
            const rigcal_real u = column[k] * by, variance = to[k];
            add_scaled(to, column, k + 1, -u);
            to[k] = rc_max(to[k], PIVOT_LEAST * variance);
            to += k + 1;
        }
        for (size_t k = 0; k < j; k++) {
            column[k] *= by;
        }
    }
}

/* ---- rows -------------------------------------------------------------------- */

int rc_filter_has(const rc_filter *f, size_t body)
{
    return body < f->n_cameras || (f->placed >> (body - f->n_cameras) & 1) != 0;
}

int32_t rc_filter_first(const rc_filter *f, size_t body)
{
    return body == f->frame ? -1 : (int32_t)(6 * (body - (body > f->frame)));
}

static void part_of(rc_part *part, const rc_filter *f, size_t a, size_t b,
                    const rc_row *row)
{
    part->at[0] = rc_filter_first(f, a);
    part->at[1] = rc_filter_first(f, b);
    part->h[0] = row->h_a;
    part->h[1] = row->h_b;
}

/* Tells; leaves U^T h in the room. */
static int tell(rc_news *news, rigcal_real *hPh, rigcal_real *nu, const rc_filter *f,
                const rc_part *part, const rc_row *row, rigcal_real wrong, int is_open)
{
    rigcal_real S = 1;
    *nu = row->r;
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 6 && part->at[k] >= 0; i++) {
            *nu -= part->h[k][i] * f->d[part->at[k] + i];
        }
    }
    *hPh = rc_filter_seen(f->room, f->UD, f->n, part);
    for (int k = 0; k < 2 && is_open; k++) {
        if (part->at[k] >= 0) {
            S += *hPh * rc_filter_bend(f->UD, f->n, (size_t)part->at[k], row->reach);
        }
    }
    S += *hPh;
    if (!(S <= RC_MAX && rc_is_finite(*nu))) {
        return 0;
    }
    news->sd = RC_SQRT(S);
    news->z = *nu / news->sd;
    rc_filter_doubt(&news->doubt, *nu, S, wrong);
    return 1;
}

int rc_filter_ask(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong)
{
    rigcal_real hPh, nu;
    rc_part part;
    part_of(&part, f, a, b, row);
    return tell(news, &hPh, &nu, f, &part, row, wrong, 0);
}

int rc_filter_row(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong, int is_open)
{
    rigcal_real hPh, nu;
    rc_part part;
    part_of(&part, f, a, b, row);
    if (!tell(news, &hPh, &nu, f, &part, row, wrong, is_open)) {
        return 0;
    }
    const rigcal_real S = news->sd * news->sd;
    rc_filter_learn(f->UD, f->room, f->n, hPh, S, news->doubt.gain);
    add_scaled(f->d, f->room, f->n, news->doubt.beta * nu / S);
    return 1;
}

/* ---- poses ------------------------------------------------------------------- */

/* What a turn w should have done to R, less what it did, is a turn that is left: half the
 * antisymmetric part of (R + w x R + w x (w x R) / 2 - R') R'^T. The differences are exact,
 * but for orders that a small w does not have. */
static void left_of_turn(rigcal_real left[3], const rigcal_real w[3],
                         const rigcal_real before[9], const rigcal_real after[9])
{
    rc_clear(left, 3);
    for (int column = 0; column < 3; column++) {
        const rigcal_real r[3] = {before[column], before[3 + column], before[6 + column]};
        const rigcal_real s[3] = {after[column], after[3 + column], after[6 + column]};
        rigcal_real rest[3], twice[3], did[3], turn[3];
        rc_vec3_cross(rest, w, r);
        rc_vec3_cross(twice, w, rest);
        rc_vec3_add_scaled(rest, RC(0.5), twice);
        rc_vec3_sub(did, s, r);
        rc_vec3_sub(rest, rest, did);
        rc_vec3_cross(turn, s, rest);
        rc_vec3_add_scaled(left, RC(0.5), turn);
    }
}

void rc_filter_apply(const rc_filter *f, size_t body)
{
    const int32_t first = rc_filter_first(f, body);
    if (first < 0) {
        return;
    }
    rigcal_real *const d = &f->d[first];
    rigcal_transform *const pose = &f->poses[body];
    const rigcal_transform before = *pose;
    rc_transform_move(pose, d);
    rc_rotation_tidy(pose->R);
    rigcal_real left[3] = {0, 0, 0}, did[3];
    if (rc_vec3_max_abs(d) <= LEFT_TURN_MAX) {
        left_of_turn(left, d, before.R, pose->R);
    }
    rc_vec3_copy(d, left);
    rc_vec3_sub(did, pose->t, before.t);
    rc_vec3_sub(&d[3], &d[3], did);
}

void rc_filter_put(const rc_filter *f, size_t body, const rigcal_transform *pose)
{
    if (body != f->frame) {
        f->poses[body] = *pose;
        return;
    }
    rigcal_transform rig_from_frame, old_from_new;
    rc_transform_invert(&rig_from_frame, pose);
    rc_transform_compose(&old_from_new, &rig_from_frame, &f->poses[body]);
    for (size_t b = 0; b < f->n_bodies; b++) {
        if (b != body) {
            const rigcal_transform before = f->poses[b];
            rc_transform_compose(&f->poses[b], &before, &old_from_new);
            rc_rotation_tidy(f->poses[b].R);
        }
    }
}

/* ---- moves --------------------------------------------------------------------- */

/* P += M, 3 x 3 or 6 x 6 row by row, at row i and column j of packed P; of a block on the
 * diagonal the lower triangle. */
static void add_block(rigcal_real P[], size_t i, size_t j, const rigcal_real M[],
                      size_t size)
{
    for (size_t r = 0; r < size; r++) {
        for (size_t c = 0; c < size && j + c <= i + r; c++) {
            P[rc_packed_at(i + r, j + c)] += M[size * r + c];
        }
    }
}

/* Q of a body's own axes: diagonal. Of the frame R_b Q R_c^T of all others, block by block:
 * where Q is the same along all axes, that is R_b R_c^T. */
void rc_filter_spread(const rc_filter *f, rigcal_real P[], size_t body, rigcal_real q_rad,
                      rigcal_real q_t)
{
    const int32_t first = rc_filter_first(f, body);
    for (size_t k = 0; k < 3 && first >= 0; k++) {
        const size_t i = (size_t)first + k;
        P[rc_packed_at(i, i)] += q_rad;
        P[rc_packed_at(i + 3, i + 3)] += q_t;
    }
    for (size_t b = 0; b < f->n_bodies && first < 0; b++) {
        for (size_t c = 0; c <= b; c++) {
            rigcal_real turn[9], shift[9];
            if (b == body || c == body) {
                continue;
            }
            rc_mat3_mul_t(turn, f->poses[b].R, f->poses[c].R);
            for (int k = 0; k < 9; k++) {
                shift[k] = q_t * turn[k];
                turn[k] *= q_rad;
            }
            const size_t i = (size_t)rc_filter_first(f, b);
            const size_t j = (size_t)rc_filter_first(f, c);
            add_block(P, i, j, turn, 3);
            add_block(P, i + 3, j + 3, shift, 3);
        }
    }
}

/* R_b R_f^T in both places of the diagonal. */
static void turn_of(rigcal_real out[36], const rc_filter *f, size_t body)
{
    rigcal_real R[9];
    rc_mat3_mul_t(R, f->poses[body].R, f->poses[f->frame].R);
    rc_clear(out, 36);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[6 * i + j] = out[6 * (i + 3) + j + 3] = R[3 * i + j];
        }
    }
}

void rc_filter_through(rigcal_real out[36], const rigcal_real A[36],
                       const rigcal_real B[36], const rigcal_real C[36])
{
    rigcal_real AB[36], Ct[36];
    rc_clear(AB, 36);
    rc_clear(out, 36);
    rc_mat6_add_product(AB, A, B, 0);
    for (int i = 0; i < 36; i++) {
        Ct[i] = C[6 * (i % 6) + i / 6];
    }
    rc_mat6_add_product(out, AB, Ct, 0);
}

void rc_filter_spread_by(const rc_filter *f, rigcal_real P[], size_t body,
                         const rigcal_real Q[36])
{
    const int32_t first = rc_filter_first(f, body);
    if (first >= 0) {
        add_block(P, (size_t)first, (size_t)first, Q, 6);
        return;
    }
    for (size_t b = 0; b < f->n_bodies; b++) {
        for (size_t c = 0; c <= b; c++) {
            rigcal_real B[36], C[36], moved[36];
            if (b == body || c == body) {
                continue;
            }
            turn_of(B, f, b);
            turn_of(C, f, c);
            rc_filter_through(moved, B, Q, C);
            add_block(P, (size_t)rc_filter_first(f, b), (size_t)rc_filter_first(f, c),
                      moved, 6);
        }
    }
}

void rc_filter_leave(const rc_filter *f, rigcal_real P[], size_t body)
{
    const size_t first = (size_t)rc_filter_first(f, body);
    for (size_t i = first; i < f->n; i++) {
        for (size_t j = 0; j <= i; j++) {
            if (i < first + 6 || (j >= first && j < first + 6)) {
                P[rc_packed_at(i, j)] = 0;
            }
        }
    }
    rc_clear(&f->d[first], 6);
}

/* Of two bodies, of P multiplied out. */
static void block_of(rigcal_real out[36], const rc_filter *f, const rigcal_real P[],
                     size_t a, size_t b)
{
    rc_joint_block(out, P, (rigcal_real)rc_filter_first(f, a),
                   (rigcal_real)rc_filter_first(f, b));
}

void rc_filter_come(const rc_filter *f, rigcal_real P[], size_t body, size_t other,
                    const rigcal_real by[36], const rigcal_real Q[36])
{
    const size_t first = (size_t)rc_filter_first(f, body);
    rigcal_real across[36], new_across[36], own[36];
    rc_filter_leave(f, P, body);
    block_of(across, f, P, other, other);
    rc_filter_through(own, by, across, by);
    add_block(P, first, first, own, 6);
    add_block(P, first, first, Q, 6);
    for (size_t b = 0; b < f->n_bodies; b++) {
        const int32_t at = rc_filter_first(f, b);
        if (b == body || at < 0) {
            continue;
        }
        block_of(across, f, P, other, b);
        rc_clear(new_across, 36);
        rc_mat6_add_product(new_across, by, across, 0);
        for (size_t i = 0; i < 6; i++) {
            for (size_t j = 0; j < 6; j++) {
                const size_t row = first + i, column = (size_t)at + j;
                P[row > column ? rc_packed_at(row, column) : rc_packed_at(column, row)] =
                    new_across[6 * i + j];
            }
        }
    }
}

void rc_filter_block(rigcal_real out[36], const rc_filter *f, size_t a, size_t b)
{
    const int32_t i = rc_filter_first(f, a), j = rc_filter_first(f, b);
    for (size_t k = 0; k < 36; k++) {
        out[k] = (i < 0 || j < 0)
                     ? 0
                     : rc_filter_element(f->UD, f->n, (size_t)i + k / 6, (size_t)j + k % 6);
    }
}
