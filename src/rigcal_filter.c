#include "rc_filter.h"

#include "rc_joint.h"
#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* standard deviations of noise: wrong matches are spread evenly over this much on each
 * side. A search of some pixels about the line has 10 to 100. */
#define WRONG_SPREAD RC(50)

/* 1: 1 / sqrt(2 pi), the density of a normal variable at its mean. */
#define NORMAL_DENSITY RC(0.398942280401432678)

/* 1: the squared ratio of a row's second-order terms to its first-order terms, for a turn
 * of one radian. */
#define BEND RC(64)

/* part of a variance: a pivot is at least this. A smaller rest is rounding. */
#define PIVOT_LEAST (4 * RC_EPS)

/* rad: the largest turn of which the rest is kept. The neglected terms are then below
 * rounding. */
#define LEFT_TURN_MAX RC_TOL(1e-5, 1e-3)

/* ---- a factored covariance ---------------------------------------------------- */

/* room = U^T h, or += it, of six unknowns from `at` on: first the six columns of these
 * unknowns, then the columns beyond. */
static inline void put_part(rigcal_real room[], const rigcal_real UD[], size_t n, size_t at,
                            const rigcal_real h[6], int is_first)
{
    const rigcal_real h0 = h[0], h1 = h[1], h2 = h[2], h3 = h[3], h4 = h[4], h5 = h[5];
    const rigcal_real *u = &UD[rc_packed_at(at, at)];
    rigcal_real *f = &room[at], *const end = &room[n];
    f[0] = is_first ? h0 : f[0] + h0;
    u += at + 1;
    const rigcal_real f1 = h1 + u[0] * h0;
    f[1] = is_first ? f1 : f[1] + f1;
    u += at + 2;
    const rigcal_real f2 = h2 + u[0] * h0 + u[1] * h1;
    f[2] = is_first ? f2 : f[2] + f2;
    u += at + 3;
    const rigcal_real f3 = h3 + u[0] * h0 + u[1] * h1 + u[2] * h2;
    f[3] = is_first ? f3 : f[3] + f3;
    u += at + 4;
    const rigcal_real f4 = h4 + u[0] * h0 + u[1] * h1 + u[2] * h2 + u[3] * h3;
    f[4] = is_first ? f4 : f[4] + f4;
    u += at + 5;
    const rigcal_real f5 = h5 + u[0] * h0 + u[1] * h1 + u[2] * h2 + u[3] * h3 + u[4] * h4;
    f[5] = is_first ? f5 : f[5] + f5;
    u += at + 6;
    size_t to_next = at + 7;
    for (f += 6; f < end; f++) {
        const rigcal_real sum =
            u[0] * h0 + u[1] * h1 + u[2] * h2 + u[3] * h3 + u[4] * h4 + u[5] * h5;
        *f = is_first ? sum : *f + sum;
        u += to_next++;
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

/* f D f of the unknowns from `at` on, two at a time. f is in the room. */
static rigcal_real weigh(const rigcal_real room[], const rigcal_real UD[], size_t n,
                         size_t at)
{
    const rigcal_real *D = &UD[rc_packed_at(at, at)];
    rigcal_real sum = 0;
    for (size_t j = at; j < n; j += 2) {
        const rigcal_real f = room[j], g = room[j + 1];
        sum += D[0] * f * f + D[j + 2] * g * g;
        D += 2 * j + 5;
    }
    return sum;
}

rigcal_real rc_filter_seen(rigcal_real room[], const rigcal_real UD[], size_t n,
                           const rc_part *part)
{
    RIGCAL_ASSERT(n % 6 == 0);
    RIGCAL_ASSERT(part->at[0] >= 0 || part->at[1] >= 0);
    const int low = part->at[0] < 0 || (part->at[1] >= 0 && part->at[1] < part->at[0]);
    const size_t at = (size_t)part->at[low];
    const rigcal_real zero =
        part->h[low][0] - part->h[low][0]; /* the compiler must not know that it is 0: the C
                                              library's memset is slow */
    for (size_t j = 0; j < at; j++) {
        room[j] = zero;
    }
    put_part(room, UD, n, at, part->h[low], 1);
    if (part->at[!low] >= 0) {
        put_part(room, UD, n, (size_t)part->at[!low], part->h[!low], 0);
    }
    return weigh(room, UD, n, at);
}

/* One element u of a column: u -= by b. Returns b + v u, with u before the change. */
static inline rigcal_real exchange(rigcal_real *u, rigcal_real b, rigcal_real by,
                                   rigcal_real v)
{
    const rigcal_real before = *u;
    *u = before - by * b;
    return b + before * v;
}

/* Six columns at a time, from the k-th on. With single columns most instructions would read
 * and write memory. Each column has its own by and v. */
typedef struct {
    rigcal_real by[6], v[6];
} six_columns;

/* Begins one of the six: replaces D, at *diagonal, by its new value. alpha grows. */
static inline void begin_column(six_columns *six, int j, rigcal_real *diagonal,
                                rigcal_real f, rigcal_real *alpha, rigcal_real gain)
{
    const rigcal_real D = *diagonal, before = *alpha, v = D * f, part = gain * f;
    six->v[j] = v;
    six->by[j] = 0;
    if (v != 0) {
        const rigcal_real after = before + part * v;
        six->by[j] = part / before;
        *diagonal = D * (before / after);
        *alpha = after;
    }
}

static inline int is_any(const rigcal_real v[6])
{
    return v[0] != 0 || v[1] != 0 || v[2] != 0 || v[3] != 0 || v[4] != 0 || v[5] != 0;
}

/* Changes the k rows above the six columns' own. Their b is in the room. */
static inline void exchange_above(rigcal_real *u, size_t k, rigcal_real *room,
                                  const six_columns *six)
{
    const rigcal_real *const by = six->by, *const v = six->v;
    rigcal_real *const end = room + k, *u1 = u + k + 1, *u2 = u1 + k + 2;
    rigcal_real *u3 = u2 + k + 3, *u4 = u3 + k + 4, *u5 = u4 + k + 5;
    while (room < end) {
        rigcal_real b = exchange(u++, *room, by[0], v[0]);
        b = exchange(u1++, b, by[1], v[1]);
        b = exchange(u2++, b, by[2], v[2]);
        b = exchange(u3++, b, by[3], v[3]);
        b = exchange(u4++, b, by[4], v[4]);
        *room++ = exchange(u5++, b, by[5], v[5]);
    }
}

/* Changes the six columns' own rows. Their b begins as v. */
static inline void exchange_within(rigcal_real *u, size_t k, rigcal_real b[6],
                                   const six_columns *six)
{
    const rigcal_real *const by = six->by, *const v = six->v;
    rigcal_real b0 = v[0], b1 = v[1], b2 = v[2], b3 = v[3];
    u += k + 1; /* begins with the second column */
    b0 = exchange(&u[0], b0, by[1], v[1]);
    u += k + 2;
    b0 = exchange(&u[0], b0, by[2], v[2]);
    b1 = exchange(&u[1], b1, by[2], v[2]);
    u += k + 3;
    b0 = exchange(&u[0], b0, by[3], v[3]);
    b1 = exchange(&u[1], b1, by[3], v[3]);
    b2 = exchange(&u[2], b2, by[3], v[3]);
    u += k + 4;
    b0 = exchange(&u[0], b0, by[4], v[4]);
    b1 = exchange(&u[1], b1, by[4], v[4]);
    b2 = exchange(&u[2], b2, by[4], v[4]);
    b3 = exchange(&u[3], b3, by[4], v[4]);
    u += k + 5;
    b[0] = exchange(&u[0], b0, by[5], v[5]);
    b[1] = exchange(&u[1], b1, by[5], v[5]);
    b[2] = exchange(&u[2], b2, by[5], v[5]);
    b[3] = exchange(&u[3], b3, by[5], v[5]);
    b[4] = exchange(&u[4], v[4], by[5], v[5]);
    b[5] = v[5];
}

/* Bierman's update of D - gain / S v v^T, v = D U^T h. alpha grows from S - gain hPh to S.
 * If a row is much in doubt, gain is negative and P grows. */
void rc_filter_learn(rigcal_real UD[], rigcal_real room[], size_t n, rigcal_real hPh,
                     rigcal_real S, rigcal_real gain)
{
    RIGCAL_ASSERT(n % 6 == 0);
    rigcal_real alpha = S - gain * hPh;
    rigcal_real *column = UD;
    for (size_t k = 0; k < n; k += 6) {
        six_columns six;
        rigcal_real *const f = &room[k], *D = column + k;
        begin_column(&six, 0, D, f[0], &alpha, gain);
        D += k + 2;
        begin_column(&six, 1, D, f[1], &alpha, gain);
        D += k + 3;
        begin_column(&six, 2, D, f[2], &alpha, gain);
        D += k + 4;
        begin_column(&six, 3, D, f[3], &alpha, gain);
        D += k + 5;
        begin_column(&six, 4, D, f[4], &alpha, gain);
        D += k + 6;
        begin_column(&six, 5, D, f[5], &alpha, gain);
        if (is_any(six.v)) {
            exchange_above(column, k, room, &six);
            exchange_within(column + k, k, f, &six);
        } else {
            rc_vec3_copy(f, six.v);
            rc_vec3_copy(&f[3], &six.v[3]);
        }
        column += 6 * k + 21;
    }
}

/* It goes column by column, which is cheaper than rc_filter_element for each element. */
rigcal_real rc_filter_bend(const rigcal_real UD[], size_t n, size_t first,
                           rigcal_real reach)
{
    const rigcal_real *u = &UD[rc_packed_at(first, first)];
    rigcal_real turn = u[0], shift;
    u += first + 1;
    turn += u[1] * (1 + u[0] * u[0]);
    u += first + 2;
    turn += u[2] * (1 + u[0] * u[0] + u[1] * u[1]);
    u += first + 3;
    turn += u[3] * rc_vec3_dot(u, u);
    shift = u[3];
    u += first + 4;
    turn += u[4] * rc_vec3_dot(u, u);
    shift += u[4] * (1 + u[3] * u[3]);
    u += first + 5;
    turn += u[5] * rc_vec3_dot(u, u);
    shift += u[5] * (1 + u[3] * u[3] + u[4] * u[4]);
    for (size_t j = first + 6; j < n; j++) {
        u += j;
        turn += u[j - first] * rc_vec3_dot(u, u);
        shift += u[j - first] * rc_vec3_dot(&u[3], &u[3]);
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

/* to += columns k, k + 1 and k + 2, times three numbers. Each has n elements. */
static void add_three(rigcal_real *to, size_t n, const rigcal_real *from, size_t k,
                      const rigcal_real by[3])
{
    const rigcal_real *second = from + k + 1, *third = second + k + 2;
    const rigcal_real x = by[0], y = by[1], z = by[2];
    for (; n >= 2; n -= 2, to += 2, from += 2, second += 2, third += 2) {
        to[0] = to[0] + from[0] * x + second[0] * y + third[0] * z;
        to[1] = to[1] + from[1] * x + second[1] * y + third[1] * z;
    }
    if (n > 0) {
        *to = *to + *from * x + *second * y + *third * z;
    }
}

/* Column j += `by` times the contribution to P of the columns beyond j, which are still U
 * and D. */
static void add_beyond(rigcal_real UD[], size_t n, size_t j, rigcal_real by)
{
    rigcal_real *const to = &UD[rc_packed_at(j, 0)];
    const rigcal_real *column = to + j + 1;
    size_t k = j + 1;
    for (; k + 3 <= n; k += 3) {
        const rigcal_real *const second = column + k + 1, *const third = second + k + 2;
        const rigcal_real of[3] = {by * column[k] * column[j],
                                   by * second[k + 1] * second[j],
                                   by * third[k + 2] * third[j]};
        add_three(to, j + 1, column, k, of);
        column = third + k + 3;
    }
    for (; k < n; k++) {
        add_scaled(to, column, j + 1, by * column[k] * column[j]);
        column += k + 1;
    }
}

/* Column by column from the first: the columns to the right are still U and D. */
void rc_filter_multiply(rigcal_real UD[], size_t n)
{
    rigcal_real *to = UD;
    for (size_t j = 0; j < n; j++) {
        for (size_t i = 0; i < j; i++) {
            to[i] *= to[j];
        }
        add_beyond(UD, n, j, 1);
        to += j + 1;
    }
}

/* Column by column from the last: the columns to the right are U and D already. An unknown
 * of variance 0 is known exactly: its column is 0. Where only rounding is left of a
 * variance, the column is rounding too, and so is a covariance beyond what both variances
 * allow. Divided by a small variance, it would not be small. */
void rc_filter_factor(rigcal_real P[], size_t n)
{
    for (size_t j = n; j-- > 0;) {
        rigcal_real *const column = &P[rc_packed_at(j, 0)];
        const rigcal_real least = PIVOT_LEAST * column[j], *its_variance = P;
        add_beyond(P, n, j, -1);
        const int is_rounding = !(column[j] > least);
        column[j] = is_rounding ? least : column[j];
        /* A variance so small that its inverse overflows counts as 0. */
        const rigcal_real inverse = 1 / column[j];
        const rigcal_real by = rc_is_finite(inverse) ? inverse : 0;
        column[j] = (by > 0) ? column[j] : 0;
        for (size_t k = 0; k < j; its_variance += k + 2, k++) {
            const rigcal_real most = column[j] * *its_variance;
            const int is_none = is_rounding || column[k] * column[k] > most;
            column[k] = is_none ? 0 : column[k] * by;
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

/* Evaluates a row, and leaves U^T h in the room. */
static int tell(rc_news *news, rigcal_real *hPh, rigcal_real *nu, const rc_filter *f,
                const rc_part *part, const rc_row *row, rigcal_real wrong, int open)
{
    rigcal_real S = 1;
    *nu = row->r;
    for (int k = 0; k < 2; k++) {
        if (part->at[k] >= 0) {
            *nu -= rc_vec6_dot(part->h[k], &f->d[part->at[k]]);
        }
    }
    *hPh = rc_filter_seen(f->room, f->UD, f->n, part);
    for (int k = 0; k < 2; k++) {
        if ((open >> k & 1) && part->at[k] >= 0) {
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

/* room = 0. Here and below `zero` is nu - nu, which is 0 because nu is finite. If the
 * compiler knew that, it would call memset. A small C library clears byte by byte, which
 * takes 6 % of a monitor's frame. */
static void clear_room(const rc_filter *f, rigcal_real zero)
{
    for (size_t j = 0; j < f->n; j++) {
        f->room[j] = zero;
    }
}

/* d += by room; room = 0. */
static void take_room(const rc_filter *f, rigcal_real by, rigcal_real zero)
{
    rigcal_real *d = f->d, *room = f->room, *const end = &room[f->n];
    for (; room < end; d += 2, room += 2) {
        d[0] += room[0] * by;
        room[0] = zero;
        d[1] += room[1] * by;
        room[1] = zero;
    }
}

int rc_filter_ask(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong)
{
    rigcal_real hPh, nu;
    rc_part part;
    part_of(&part, f, a, b, row);
    const int is_told = tell(news, &hPh, &nu, f, &part, row, wrong, 0);
    clear_room(f, is_told ? nu - nu : 0);
    return is_told;
}

int rc_filter_row(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong, int open)
{
    rigcal_real hPh, nu;
    rc_part part;
    part_of(&part, f, a, b, row);
    if (!tell(news, &hPh, &nu, f, &part, row, wrong, open)) {
        clear_room(f, 0);
        return 0;
    }
    const rigcal_real S = news->sd * news->sd;
    rc_filter_learn(f->UD, f->room, f->n, hPh, S, news->doubt.gain);
    take_room(f, news->doubt.beta * nu / S, nu - nu);
    return 1;
}

/* ---- poses ------------------------------------------------------------------- */

/* The part of the turn w that rounding kept from R as it became R'. It is the turn that w
 * should have made, less the turn that it made: half the antisymmetric part of (R + w x R +
 * w x (w x R) / 2 - R') R'^T. This is exact to the third order in w, which is small. */
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

/* x / |x|, if |x| differs from 1 by rounding only. */
static inline void tidy_row(rigcal_real x[3])
{
    rc_vec3_scale(x, (3 - rc_vec3_dot(x, x)) / 2, x);
}

/* Like rc_rotation_tidy, for a matrix that differs from a rotation only by the rounding of
 * one step. */
static void tidy(rigcal_real R[9])
{
    tidy_row(&R[0]);
    rc_vec3_cross(&R[6], &R[0], &R[3]);
    tidy_row(&R[6]);
    rc_vec3_cross(&R[3], &R[6], &R[0]);
}

/* With the rest `left` of the turn, t is still to be turned too: so left x t is no rest of
 * the shift. */
void rc_filter_apply(const rc_filter *f, size_t body)
{
    const int32_t first = rc_filter_first(f, body);
    if (first < 0) {
        return;
    }
    rigcal_real *const d = &f->d[first];
    rigcal_transform *const pose = &f->poses[body];
    const rigcal_transform before = *pose;
    rigcal_real left[3] = {0, 0, 0}, dt[3], did[3];
    rc_transform_displace(pose, dt, d);
    tidy(pose->R);
    if (rc_vec3_max_abs(d) <= LEFT_TURN_MAX) {
        left_of_turn(left, d, before.R, pose->R);
    }
    rc_vec3_copy(d, left);
    rc_vec3_sub(did, pose->t, before.t);
    rc_vec3_sub(dt, dt, did);
    rc_vec3_cross(did, left, pose->t);
    rc_vec3_sub(&d[3], dt, did);
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

/* Of a block on the diagonal only the lower triangle is added. */
void rc_filter_add(const rc_filter *f, rigcal_real P[], size_t a, size_t b,
                   const rigcal_real M[36])
{
    const size_t i = (size_t)rc_filter_first(f, a), j = (size_t)rc_filter_first(f, b);
    for (size_t r = 0; r < 6; r++) {
        for (size_t c = 0; c < 6 && j + c <= i + r; c++) {
            P[rc_packed_at(i + r, j + c)] += M[6 * r + c];
        }
    }
}

/* For a body, Q is diagonal in its own axes. A move of the frame is one of all others. */
void rc_filter_spread(const rc_filter *f, rigcal_real P[], size_t body, rigcal_real q_rad,
                      rigcal_real q_t)
{
    if (body != f->frame) {
        const size_t first = (size_t)rc_filter_first(f, body);
        for (size_t i = first; i < first + 3; i++) {
            P[rc_packed_at(i, i)] += q_rad;
            P[rc_packed_at(i + 3, i + 3)] += q_t;
        }
        return;
    }
    for (size_t b = 0; b < f->n_bodies; b++) {
        rigcal_transform b_from_frame, c_from_frame;
        rc_transform_between(&b_from_frame, &f->poses[b], &f->poses[body]);
        for (size_t c = 0; c <= b; c++) {
            rigcal_real M[36];
            if (b == body || c == body) {
                continue;
            }
            rc_transform_between(&c_from_frame, &f->poses[c], &f->poses[body]);
            rc_transform_carry_equal(M, &b_from_frame, &c_from_frame, q_rad, q_t);
            rc_filter_add(f, P, b, c, M);
        }
    }
}

/* Carries an error of the frame to a body. */
static void carry_to(rigcal_real out[36], const rc_filter *f, size_t body)
{
    rigcal_transform body_from_frame;
    rc_transform_between(&body_from_frame, &f->poses[body], &f->poses[f->frame]);
    rc_transform_carry(out, &body_from_frame);
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
    if (body != f->frame) {
        rc_filter_add(f, P, body, body, Q);
        return;
    }
    for (size_t b = 0; b < f->n_bodies; b++) {
        for (size_t c = 0; c <= b; c++) {
            rigcal_real B[36], C[36], moved[36];
            if (b == body || c == body) {
                continue;
            }
            carry_to(B, f, b);
            carry_to(C, f, c);
            rc_filter_through(moved, B, Q, C);
            rc_filter_add(f, P, b, c, moved);
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

/* The block of two bodies from P, multiplied out. */
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
    rc_filter_add(f, P, body, body, own);
    rc_filter_add(f, P, body, body, Q);
    const int32_t from = rc_filter_first(f, other);
    for (size_t i = 0; i < 6 && from >= 0; i++) {
        f->d[first + i] = rc_vec6_dot(&by[6 * i], &f->d[from]);
    }
    for (size_t b = 0; b < f->n_bodies; b++) {
        const int32_t at = rc_filter_first(f, b);
        if (b == body || at < 0) {
            continue;
        }
        block_of(across, f, P, other, b);
        rc_clear(new_across, 36);
        rc_mat6_add_product(new_across, by, across, 0);
        for (size_t k = 0; k < 36; k++) {
            const size_t row = first + k / 6, column = (size_t)at + k % 6;
            P[rc_packed_of(row, column)] = new_across[k];
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
