/* score: compares the hypotheses of a pair of cameras with each other. The truth: every
 * comparison, one by one. */
#include <math.h>
#include <string.h>

#include "rc_graph.h"
#include "rc_score.h"
#include "test_tags.h"

enum { F = RC_SCORE_PLACEMENTS + 5, RUNGS = RIGCAL_CHOOSE_RUNGS };

TEST_TAGS(t, 2, F);
static rigcal_choose_solver s;
static rc_score_parts parts;

#define WANTS_RIG TEST_WANTS_RAM(2 * F * 1200)

/* Two cameras that saw F placements, their poses, and the information of these. Begins the
 * scores of the pair. */
static void begin(test_rng *rng, double share)
{
    t.distance = 20;
    t.share_seen = share;
    t.noise_px = 0.3;
    test_tags_random(&t, rng, 2, F);
    test_tags_solve(&t);
    memset(&s, 0, sizeof s);
    s.check.rig = &t.rig;
    s.choice = &t.choice;
    s.a = 0;
    s.b = 1;
    s.limit = RC(30 * 0.09);
    rc_score_parts_of(&parts, &t.rig);
    for (int f = 0, v = 0; f <= F; f++) {
        parts.first[f] = (rigcal_real)v;
        for (; v < (int)t.rig.n_views && t.own[v].placement == f; v++) {
            parts.camera[v] = (rigcal_real)t.own[v].camera;
            parts.told[v] = rc_view_information(&t.own[v]);
        }
    }
}

static double told_of(int placement)
{
    const size_t a = rc_score_view_of(&t.rig, &parts, 0, (size_t)placement);
    const size_t b = rc_score_view_of(&t.rig, &parts, 1, (size_t)placement);

    return (a < t.rig.n_views && b < t.rig.n_views)
               ? D(rc_information_of_both(parts.told[a], parts.told[b]))
               : 0;
}

static void test_the_list_has_the_placements_that_tell_most(void)
{
    test_rng rng = test_seed(571);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(12); trial++) {
        int is_listed[F] = {0}, shared = 0;
        double least = 1e30;

        begin(&rng, trial % 2 ? 0.7 : 1);
        for (int f = 0; f < F; f++) {
            shared += told_of(f) > 0;
        }
        TEST_ASSERT_EQUAL(shared > 0, rc_score_begin(&s, &parts));
        TEST_ASSERT_EQUAL(shared < RC_SCORE_PLACEMENTS ? shared : RC_SCORE_PLACEMENTS, s.n);
        for (size_t i = 0; i < s.n; i++) {
            const int f = (int)parts.list[i];

            TEST_ASSERT_EQUAL(0, is_listed[f]);
            is_listed[f] = 1;
            TEST_ASSERT_TRUE(told_of(f) <= least);
            least = told_of(f);
        }
        for (int f = 0; f < F; f++) {
            TEST_ASSERT_TRUE(is_listed[f] || told_of(f) <= least);
        }
    }
}

/* Placements that tell the same are listed in their order. */
static void test_of_equal_placements_the_first_is_listed_first(void)
{
    test_rng rng = test_seed(578);

    WANTS_RIG;
    begin(&rng, 1);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        parts.told[v] = 3;
    }
    TEST_ASSERT_TRUE(rc_score_begin(&s, &parts));
    TEST_ASSERT_EQUAL(RC_SCORE_PLACEMENTS, s.n);
    for (size_t i = 0; i < s.n; i++) {
        ASSERT_NEAR((double)i, parts.list[i], 0);
    }
}

/* Of hypotheses with equal scores the first is the best. */
static void test_of_equal_scores_the_first_is_the_best(void)
{
    test_rng rng = test_seed(579);
    int32_t number;

    WANTS_RIG;
    begin(&rng, 1);
    TEST_ASSERT_TRUE(rc_score_begin(&s, &parts));
    for (size_t best = 0; best < 12; best++) {
        for (size_t k = 0; k < RUNGS * 4 * s.n; k++) {
            parts.scores[k] = k / RUNGS < best ? 1 : 2;
        }
        ASSERT_NEAR(2, rc_score_best(&number, &s, &parts, 1), 0);
        TEST_ASSERT_EQUAL_INT32(4 * (int32_t)parts.list[best / 4] + (int32_t)(best % 4),
                                number);
    }
}

/* The cost of a placement for a hypothesis: the least over its combinations. */
static double cost_in(const rc_claim *it, size_t own, size_t placement)
{
    double least = 1e30;

    if (own == placement) {
        return D(it->extra);
    }
    for (size_t k = 0; k < 4; k++) {
        rc_claim other;

        ASSERT_STATUS(RIGCAL_OK, rc_score_claim(&other, &s, &parts, 4 * placement + k));
        if (other.view >= 0) { /* taken at the pivot of the one that comes later in the
                                  list */
            size_t at = 0;

            while ((size_t)parts.list[at] != own && (size_t)parts.list[at] != placement) {
                at++;
            }
            least = fmin(least, D(other.extra) + D((size_t)parts.list[at] == own
                                                       ? rc_claims_apart(&other, it)
                                                       : rc_claims_apart(it, &other)));
        }
    }
    return least;
}

static void test_the_best_hypothesis_is_that_of_all_comparisons(void)
{
    test_rng rng = test_seed(572);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(3); trial++) {
        rigcal_real seen[RUNGS];
        int32_t seen_number[RUNGS];
        double best[RUNGS];
        rigcal_status status = RIGCAL_RUNNING;
        int steps = 0;

        begin(&rng, 0.6);
        for (size_t v = 0; v < t.rig.n_views; v += 3) { /* some views have one pose only */
            t.second[v].n = 0;
        }
        TEST_ASSERT_TRUE(rc_score_begin(&s, &parts));
        for (; status == RIGCAL_RUNNING; steps++) {
            status = rc_score_step(&s, &parts);
        }
        ASSERT_STATUS(RIGCAL_OK, status);
        TEST_ASSERT_EQUAL(s.n * (s.n + 1) / 2, steps);
        for (int k = 0; k < RUNGS; k++) {
            seen[k] = rc_score_best(&seen_number[k], &s, &parts, k);
            best[k] = -1e30;
        }
        for (size_t h = 0; h < 4 * s.n; h++) {
            const size_t own = (size_t)parts.list[h / 4];
            double score[RUNGS] = {0};
            int agree[RUNGS] = {0};
            rc_claim it;

            ASSERT_STATUS(RIGCAL_OK, rc_score_claim(&it, &s, &parts, 4 * own + h % 4));
            for (size_t i = 0; i < s.n && it.view >= 0; i++) {
                const double cost = cost_in(&it, own, (size_t)parts.list[i]);

                for (int k = 0; k < RUNGS; k++) {
                    const double limit = 30 * 0.09 * pow(4, k);

                    agree[k] += cost < limit;
                    score[k] +=
                        (cost < limit) - fmin(cost / limit, 1) / (RC_SCORE_PLACEMENTS + 1);
                }
            }
            for (int k = 0; k < RUNGS && it.view < 0; k++) { /* below all others */
                TEST_ASSERT_TRUE(D(parts.scores[RUNGS * h + (size_t)k]) <
                                 -RC_SCORE_PLACEMENTS);
            }
            for (int k = 0; k < RUNGS && it.view >= 0; k++) {
                TEST_ASSERT_EQUAL(agree[k], rc_score_agree(RC(score[k])));
                ASSERT_NEAR(score[k], parts.scores[RUNGS * h + (size_t)k], TOL(1e-9, 1e-2));
                if ((int32_t)(4 * own + h % 4) == seen_number[k]) {
                    ASSERT_NEAR(score[k], seen[k], TOL(1e-9, 1e-2));
                }
                best[k] = fmax(best[k], score[k]);
            }
        }
        for (int k = 0; k < RUNGS; k++) {
            ASSERT_NEAR(best[k], seen[k], TOL(1e-9, 1e-2));
        }
    }
}

static void test_how_many_agree_with_a_score(void)
{
    for (int agree = 0; agree <= RC_SCORE_PLACEMENTS; agree++) {
        TEST_ASSERT_EQUAL_INT32(agree, rc_score_agree(RC(agree)));
        TEST_ASSERT_EQUAL_INT32(
            agree,
            rc_score_agree(RC(agree - RC_SCORE_PLACEMENTS / (RC_SCORE_PLACEMENTS + 1.0))));
    }
}

/* From the rig: only placements that are known, or doubtful ones if they are enough. What a
 * view of the joined cameras fits worse is not charged to the new camera. */
static void test_hypotheses_from_the_rig(void)
{
    test_rng rng = test_seed(573);
    rc_claim claim;

    WANTS_RIG;
    begin(&rng, 1);
    s.a = -1;
    memset(&parts.cams[0], 0, sizeof parts.cams[0]);
    parts.cams[0].b_from_a = t.true_cams[0];
    for (int f = 0; f < F; f++) { /* by camera 0; three of them by its second pose */
        const size_t v = rc_score_view_of(&t.rig, &parts, 0, (size_t)f);

        parts.strength[f] = f < 3 ? RC_KNOWN : f < 7 ? RC_DOUBTFUL : RC_STALE;
        if (f < 3) {
            t.second[v] = t.own[v];
            t.second[v].sse += 7;
        }
        parts.placed[f] = (rigcal_real)(2 * v + (f < 3));
    }
    TEST_ASSERT_TRUE(rc_score_begin(&s, &parts));
    TEST_ASSERT_EQUAL(3, s.n);
    for (size_t k = 0; k < 3; k++) {
        TEST_ASSERT_TRUE(parts.list[k] < 3);
        ASSERT_STATUS(RIGCAL_OK, rc_score_claim(&claim, &s, &parts, 4 * k));
        ASSERT_NEAR(0, claim.extra, 0);
        ASSERT_STATUS(RIGCAL_OK, rc_score_claim(&claim, &s, &parts, 4 * k + 2));
        TEST_ASSERT_TRUE(claim.view < 0);
    }
    s.is_relaxed = 1;
    TEST_ASSERT_TRUE(rc_score_begin(&s, &parts));
    TEST_ASSERT_EQUAL(7, s.n);
}

/* A view with an information of 0 makes no claim. */
static void test_a_view_that_knows_nothing_is_degenerate(void)
{
    test_rng rng = test_seed(575);
    rc_claim claims[2];

    WANTS_RIG;
    begin(&rng, 1);
    ASSERT_STATUS(RIGCAL_OK, rc_candidates(claims, &s, 3));
    TEST_ASSERT_EQUAL_INT32(3, claims[0].view);
    memset(t.own[3].information, 0, sizeof t.own[3].information);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_candidates(claims, &s, 3));
}

/* The median of the variances that are known, 0 among them. It is at least that of 0.01 px.
 * A noise that is stated comes first. */
static void test_the_variance_is_the_median_of_those_known(void)
{
    static const struct {
        double told[6], median;
    } CASE[] = {{{4, -1, 1, 9, -1, -1}, 4},    {{4, 1, 9, 25, -1, -1}, 6.5},
                {{0, 0, 0, 4, 9, -1}, 1e-4},   {{0, 0, 9, 25, 4, -1}, 4},
                {{-1, -1, -1, -1, -1, -1}, 0}, {{-1, -1, -1, -1, -1, 7}, 7},
                {{2, 2, 2, 2, 2, 2}, 2},       {{1e-9, 1e-9, -1, -1, -1, -1}, 1e-4},
                {{0, 0, 4, 9, 16, 25}, 6.5},   {{100, 1, -1, -1, -1, -1}, 50.5},
                {{6, 5, 4, 3, 2, 1}, 3.5},     {{-5, -4, 3, -2, 2, 8}, 3}};
    test_rng rng = test_seed(576);

    WANTS_RIG;
    begin(&rng, 1);
    t.rig.n_views = 6;
    t.rig.sigma_px = 0;
    for (size_t k = 0; k < sizeof CASE / sizeof CASE[0]; k++) {
        test_to_real(parts.told, CASE[k].told, 6);
        ASSERT_NEAR(CASE[k].median, rc_score_variance(&t.rig, &parts),
                    TOL(1e-14, 1e-6) * (1 + CASE[k].median));
    }
    t.rig.sigma_px = 3;
    ASSERT_NEAR(9, rc_score_variance(&t.rig, &parts), 0);
}

static int fails_at;

static rigcal_status second_of(rigcal_view_pose *pose, size_t view, void *context)
{
    (void)view;
    (void)context;
    pose->n = 0;
    return fails_at-- == 0 ? RIGCAL_ERR_STATE : RIGCAL_OK;
}

/* Whichever call of the caller's source fails, of the row or of the column, its status ends
 * the step. */
static void test_a_source_that_fails_ends_the_step(void)
{
    test_rng rng = test_seed(577);

    WANTS_RIG;
    begin(&rng, 1);
    t.choice.second_poses = NULL;
    t.choice.second_source = second_of;
    for (int at = 0; at < 5; at++) {
        fails_at = -1;
        TEST_ASSERT_TRUE(rc_score_begin(&s, &parts));
        ASSERT_STATUS(RIGCAL_RUNNING, rc_score_step(&s, &parts)); /* row 0 by itself */
        TEST_ASSERT_EQUAL(1, s.row);
        fails_at = at; /* two views of the row, then two of the column */
        ASSERT_STATUS(at < 4 ? RIGCAL_ERR_STATE : RIGCAL_RUNNING,
                      rc_score_step(&s, &parts));
        TEST_ASSERT_EQUAL(at < 4 ? 0 : 1, s.column);
        if (at == 4) { /* the row is known by now, and by itself it needs no column */
            ASSERT_STATUS(RIGCAL_RUNNING, rc_score_step(&s, &parts));
            TEST_ASSERT_EQUAL(0, fails_at);
            TEST_ASSERT_EQUAL(2, s.row);
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_list_has_the_placements_that_tell_most);
    RUN_TEST(test_of_equal_placements_the_first_is_listed_first);
    RUN_TEST(test_of_equal_scores_the_first_is_the_best);
    RUN_TEST(test_the_best_hypothesis_is_that_of_all_comparisons);
    RUN_TEST(test_hypotheses_from_the_rig);
    RUN_TEST(test_how_many_agree_with_a_score);
    RUN_TEST(test_a_view_that_knows_nothing_is_degenerate);
    RUN_TEST(test_the_variance_is_the_median_of_those_known);
    RUN_TEST(test_a_source_that_fails_ends_the_step);
}
