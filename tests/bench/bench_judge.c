/* bench_judge: which views are named, on simulated rigs of boards of 20 points with 0.3 px
 * of noise, with what is wrong with their views.
 *
 *   bench_judge [RIGS]    the table, so many rigs a line (default 40) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "rigcal_solvers.h"
#include "test_boards.h"

static const double NOISE = 0.3;

typedef enum { NOTHING, REPLACED, REVERSED, SWAPPED, LATE } fault;

typedef struct {
    const char *what;
    fault fault;
    int cameras, places, seen;
    double share, pattern_px;
} campaign;

static const campaign CAMPAIGNS[] = {
    {"nothing wrong, 2 x 8", NOTHING, 2, 8, 2, 0, 0},
    {"nothing wrong, 4 x 10", NOTHING, 4, 10, 4, 0, 0},
    {"nothing wrong, 4 x 20, half seen", NOTHING, 4, 20, 2, 0, 0},
    {"nothing wrong, 6 x 24, a third seen", NOTHING, 6, 24, 2, 0, 0},
    {"the same, 4 x 10, patterns of 4 px", NOTHING, 4, 10, 4, 0, 4},
    {"the same, 4 x 10, patterns of 8 px", NOTHING, 4, 10, 4, 0, 8},
    {"10 % replaced, 4 x 10", REPLACED, 4, 10, 4, 0.1, 0},
    {"10 % replaced, 4 x 10, patterns of 4 px", REPLACED, 4, 10, 4, 0.1, 4},
    {"10 % replaced, 4 x 20, half seen", REPLACED, 4, 20, 2, 0.1, 0},
    {"10 % replaced, 6 x 24, a third seen", REPLACED, 6, 24, 2, 0.1, 0},
    {"25 % replaced, 4 x 10", REPLACED, 4, 10, 4, 0.25, 0},
    {"10 % reversed, 4 x 10", REVERSED, 4, 10, 4, 0.1, 0},
    {"two cameras swapped in 10 % of placements, 4 x 10", SWAPPED, 4, 10, 4, 0.1, 0},
    {"one camera a placement late, 4 x 10", LATE, 4, 10, 4, 0, 0},
    {"one camera a placement late, 3 x 10", LATE, 3, 10, 3, 0, 0},
    {"10 % replaced, 4 x 20, three of four see", REPLACED, 4, 20, 3, 0.1, 0},
    {"one camera a placement late, 4 x 10, patterns of 4 px", LATE, 4, 10, 4, 0, 4},
};
enum { N_CAMPAIGNS = sizeof CAMPAIGNS / sizeof CAMPAIGNS[0] };

static test_boards b;

static void spoil_view(const campaign *c, test_rng *rng, int v)
{
    const int camera = b.views[v].camera, place = b.views[v].placement;

    if (c->fault == REPLACED) {
        const int from = test_boards_view(&b, camera, (int)test_uniform(rng, 0, c->places));
        if (from >= 0 && from != v && !b.is_wrong[from]) {
            test_boards_replace(&b, v, from);
        }
    } else if (c->fault == REVERSED) {
        test_boards_reverse(&b, v);
    } else if (camera == 0) {
        const int one = test_boards_view(&b, place % c->cameras, place),
                  other = test_boards_view(&b, (place + 1) % c->cameras, place);
        if (one >= 0 && other >= 0) {
            test_boards_swap(&b, one, other);
        }
    }
}

static void spoil(const campaign *c, test_rng *rng)
{
    if (c->fault == LATE) {
        test_boards_late(&b, (int)test_uniform(rng, 0, c->cameras));
    }
    for (size_t v = 0; c->share > 0 && v < b.rig.n_views; v++) {
        if (!b.is_wrong[v] && test_uniform(rng, 0, 1) < c->share) {
            spoil_view(c, rng, (int)v);
        }
    }
}

typedef struct {
    int known_wrong, known_named, wrong, named;  /* views whose error can be known; all
                                                    views */
    int known_right, known_false, right, false_; /* right views, and the right views that
                                                    were named */
    int refused;                                 /* rigs */
    double error2, rigs, adjustments;
} tally;

static void count(tally *t)
{
    for (size_t v = 0; v < b.rig.n_views; v++) {
        const int is_named = b.judged[v].verdict == RIGCAL_VIEW_CONTRADICTS ||
                             b.judged[v].verdict == RIGCAL_VIEW_ONE_OF_TWO;
        int right = 0, wrong = 0;

        for (size_t u = 0; u < b.rig.n_views; u++) {
            if (b.views[u].placement == b.views[v].placement) {
                right += !b.is_wrong[u];
                wrong += b.is_wrong[u];
            }
        }
        const int is_known = right > 1 && right > wrong;
        t->wrong += b.is_wrong[v];
        t->named += b.is_wrong[v] && is_named;
        t->right += !b.is_wrong[v];
        t->false_ += !b.is_wrong[v] && is_named;
        t->known_wrong += is_known && b.is_wrong[v];
        t->known_named += is_known && b.is_wrong[v] && is_named;
        t->known_right += is_known && !b.is_wrong[v];
        t->known_false += is_known && !b.is_wrong[v] && is_named;
    }
}

static void run(const campaign *c, int number, int rigs)
{
    tally t = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};

    for (int trial = 0; trial < rigs; trial++) {
        test_rng rng = test_seed(10000 + 1000 * (uint64_t)number + (uint64_t)trial);

        test_boards_make(&b, &rng, c->cameras, c->places, c->seen, NOISE, c->pattern_px);
        spoil(c, &rng);
        test_boards_solve(&b);
        if (rigcal_rig_choose(&b.choice, NULL, &b.rig) < 0 ||
            rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out, &b.choice, &b.rig) <
                0) {
            t.refused++;
            continue;
        }
        count(&t);
        const double error = test_boards_error(&b, b.judgement.sigma_px);
        t.error2 += error * error;
        t.adjustments += b.judgement.adjustments;
        t.rigs++;
    }
    printf("| %s | %d of %d | %d of %d | %d of %d | %d of %d | %.2f | %.1f | %d |\n",
           c->what, t.known_named, t.known_wrong, t.named, t.wrong, t.known_false,
           t.known_right, t.false_, t.right, sqrt(t.error2 / t.rigs),
           t.adjustments / t.rigs, t.refused);
}

int main(int argc, char *argv[])
{
    const int rigs = argc > 1 ? atoi(argv[1]) : 40;

    if (argc > 2 || rigs < 1) {
        fputs("usage: bench_judge [RIGS]\n", stderr);
        return 2;
    }
    UNITY_BEGIN();
    if (!TEST_PROTECT()) {
        return 1;
    }
    puts("| rigs | wrong named, where it can be known | of all wrong | right named, where "
         "right outnumber wrong | of all right | error over bound | adjustments | rigs "
         "refused |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    for (int i = 0; i < N_CAMPAIGNS; i++) {
        run(&CAMPAIGNS[i], i, rigs);
    }
    return 0;
}

void setUp(void)
{
}

void tearDown(void)
{
}
