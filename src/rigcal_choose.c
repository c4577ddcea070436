#include "rc_choose.h"

#include "rc_chain.h"

/* ---- claims -------------------------------------------------------------- */

int rc_claim_of_view(rc_claim *claim, const rigcal_view_pose *pose, rigcal_real first_sse,
                     int32_t view, int32_t candidate)
{
    rigcal_real full[36];
    if (!rc_sym6_invert(full, pose->information)) {
        return 0;
    }
    rc_sym6_pack(claim->Sigma, full);
    claim->b_from_a = pose->cam_from_target;
    rc_clear(claim->pivot, 3);
    claim->extra = rc_max(0, pose->sse - first_sse);
    claim->view = (rigcal_real)view;
    claim->candidate = (rigcal_real)candidate;
    return 1;
}

/* out += J S J^T with J = (1 0; [l]x 1): a turn w also shifts a point that is `l` away from
 * the pivot. S = (A B; B^T D) in blocks. M = B + A [l]x^T is the block across of the
 * result. Its second block is D + [l]x M + ([l]x B)^T. */
static void add_levered(rigcal_real out[21], const rigcal_real S[21],
                        const rigcal_real l[3])
{
    static const uint8_t FULL[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    const rigcal_real *const across = &S[RC_SYM6_ACROSS];
    rigcal_real M[9], below[3], beside[3];
    for (int row = 0; row < 3; row++) {
        const uint8_t *const at = &FULL[3 * row];
        const rigcal_real w[3] = {S[at[0]], S[at[1]], S[at[2]]};
        rc_vec3_cross(&M[3 * row], l, w);
        rc_vec3_add(&M[3 * row], &across[3 * row]);
    }
    for (int k = 0; k < 3; k++) {
        const rigcal_real x[3] = {M[k], M[3 + k], M[6 + k]};
        const rigcal_real y[3] = {across[k], across[3 + k], across[6 + k]};
        rigcal_real *const second = &out[RC_SYM6_SECOND];
        rc_vec3_cross(below, l, x);
        rc_vec3_cross(beside, l, y);
        for (int i = 0; i <= k; i++) {
            second[FULL[3 * i + k]] += below[i];
        }
        for (int i = k; i < 3; i++) {
            second[FULL[3 * k + i]] += beside[i];
        }
    }
    for (int k = 0; k < 21; k++) {
        out[k] +=
            (k >= RC_SYM6_ACROSS && k < RC_SYM6_SECOND) ? M[k - RC_SYM6_ACROSS] : S[k];
    }
}

/* out += B^T S B, B = (R 0; 0 R) */
static void add_turned(rigcal_real out[21], const rigcal_real R[9], const rigcal_real S[21])
{
    rc_chain chain;
    rigcal_real none[6] = {0, 0, 0, 0, 0, 0};
    chain.R_c = R;
    rc_chain_add_placement(none, out, &chain, none, S);
}

void rc_claim_place(rc_claim *placement, const rc_claim *view, const rc_claim *camera,
                    int with_camera)
{
    rigcal_transform rig_from_cam;
    rigcal_real sum[21], lever[3], arm[3];
    RIGCAL_ASSERT(placement != view && placement != camera);
    *placement = *view;
    rc_transform_invert(&rig_from_cam, &camera->b_from_a);
    rc_transform_compose(&placement->b_from_a, &rig_from_cam, &view->b_from_a);
    for (int k = 0; k < 21; k++) {
        sum[k] = view->Sigma[k];
    }
    if (with_camera) {
        rc_vec3_sub(arm, camera->pivot, placement->b_from_a.t);
        rc_mat3_mul_vec3(lever, camera->b_from_a.R, arm);
        add_levered(sum, camera->Sigma, lever);
    }
    rc_clear(placement->Sigma, 21);
    add_turned(placement->Sigma, camera->b_from_a.R, sum);
}

void rc_claim_between(rc_claim *b_from_a, const rc_claim *b, const rc_claim *a)
{
    rigcal_transform a_from_b, x_from_a;
    RIGCAL_ASSERT(b_from_a != b && b_from_a != a);
    *b_from_a = *b;
    rc_transform_invert(&x_from_a, &a->b_from_a);
    rc_transform_compose(&b_from_a->b_from_a, &b->b_from_a, &x_from_a);
    rc_transform_invert(&a_from_b, &b_from_a->b_from_a);
    add_turned(b_from_a->Sigma, a_from_b.R, a->Sigma);
    rc_vec3_copy(b_from_a->pivot, a->b_from_a.t);
    b_from_a->extra += a->extra;
}

/* The distance is taken at the pivot of p: both claims' turn, and their shift of this
 * point. Far from both pivots the shifts would be large and nearly the same. */
rigcal_real rc_claims_apart(const rc_claim *p, const rc_claim *q)
{
    const rigcal_transform *const P = &p->b_from_a, *const Q = &q->b_from_a;
    rigcal_real S[21], d[6], arm[3], lever[3], at[3];
    rc_sym6_factor L;
    rc_vec3_sub(arm, q->pivot, p->pivot);
    rc_mat3_mul_vec3(lever, Q->R, arm);
    for (int k = 0; k < 21; k++) {
        S[k] = p->Sigma[k];
    }
    add_levered(S, q->Sigma, lever);
    if (!rc_sym6_factor_of(&L, S, 0)) {
        return RC_MAX;
    }
    rc_deviation(d, Q, P);
    rc_transform_point(&d[3], Q, p->pivot);
    rc_transform_point(at, P, p->pivot);
    rc_vec3_sub(&d[3], &d[3], at);
    rc_sym6_forward(d, &L);
    return rc_vec3_dot(d, d) + rc_vec3_dot(&d[3], &d[3]);
}

/* ---- one placement ------------------------------------------------------- */

void rc_choose_support(rc_support *support, uint8_t choice[], const rc_claim claims[],
                       size_t n, size_t which, rigcal_real limit)
{
    const rc_claim *const it = &claims[which];
    RIGCAL_ASSERT(which < n);
    *support = (rc_support){0, it->Sigma[0] + it->Sigma[3] + it->Sigma[5], 0, 0};
    for (size_t i = 0; i < n; support->n++) {
        const size_t view = (size_t)claims[i].view;
        const int is_own = view == (size_t)it->view;
        rigcal_real least = limit;
        uint8_t takes = 2;
        for (; i < n && (size_t)claims[i].view == view; i++) {
            if (is_own && i != which) {
                continue;
            }
            const rigcal_real cost =
                claims[i].extra + ((i == which) ? 0 : rc_claims_apart(it, &claims[i]));
            if (cost < least) {
                least = cost;
                takes = (uint8_t)claims[i].candidate;
            }
        }
        support->cost += least;
        support->agree += (takes < 2);
        if (choice != NULL) {
            choice[view] = takes;
        }
    }
}

int rc_choose_is_better(const rc_support *support, const rc_support *than)
{
    if (support->agree != than->agree) {
        return support->agree > than->agree;
    }
    return support->cost < than->cost ||
           (!(support->cost > than->cost) && support->spread < than->spread);
}

size_t rc_choose_place(rc_support *support, uint8_t choice[], const rc_claim claims[],
                       size_t n, rigcal_real limit)
{
    size_t best = 0;
    rc_choose_support(support, NULL, claims, n, 0, limit);
    for (size_t i = 1; i < n; i++) {
        rc_support other;
        rc_choose_support(&other, NULL, claims, n, i, limit);
        if (rc_choose_is_better(&other, support)) {
            *support = other;
            best = i;
        }
    }
    rc_choose_support(support, choice, claims, n, best, limit);
    return best;
}
