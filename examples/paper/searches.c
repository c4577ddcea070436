/* Where searches end: figures 3 to 9, the paper's counts, and the effects of the
 * procedure's choices. */
#include <math.h>
#include <string.h>

#include "figures.h"
#include "solve.h"
#include "table.h"

static const char *const outcome_names[PAPER_OUTCOMES] = {"none", "false", "correct"};

/* ---- guesses ------------------------------------------------------------ */

/* Node i, in the middle of its cell, of a grid with spacing `step` that begins at
 * `edge`. */
static double node(double edge, double step, int i)
{
    return edge + (i + 0.5) * step;
}

static void guess(paper_procedure *p, double yaw, double pitch, double roll)
{
    p->guess[0] = yaw * PAPER_DEGREE;
    p->guess[1] = pitch * PAPER_DEGREE;
    p->guess[2] = roll * PAPER_DEGREE;
}

/* Sets a guess whose pitch and roll are off the truth by these angles; yaw too. */
static void guess_near(paper_procedure *p, const paper_scene *scene, int c,
                       const double off_degrees[3])
{
    paper_true_angles(p->guess, scene, c);
    for (int k = 0; k < 3; k++) {
        p->guess[k] += off_degrees[k] * PAPER_DEGREE;
    }
}

typedef struct {
    int count[PAPER_OUTCOMES], behind, tried;
} tally;

static void count(tally *t, const paper_attempt *a)
{
    t->count[a->outcome]++;
    t->behind += a->behind;
    t->tried++;
}

/* ---- figures 3, 4, 8: from a grid of guesses -------------------------------
 *
 * Three points, four, and four with all pairs used to eliminate. */

/* Prints a row of the map as digits. */
static void print_row(FILE *file, paper_procedure *p, const paper_images *images,
                      const paper_scene *scene, int c, double yaw, double pitch)
{
    for (int j = 0; j < (int)(360 / PAPER_GRID_STEP); j++) {
        paper_attempt a;

        guess(p, yaw, pitch, node(-180, PAPER_GRID_STEP, j));
        paper_solve(&a, p, images, scene, c);
        fprintf(file, "%d", a.outcome);
    }
}

static void map_figure(const char *name, int first, int last, int digital)
{
    FILE *const file = table_open(name);
    paper_scene scene;
    paper_images images;

    fprintf(file, "camera,points,pairs_used,true_pitch_deg,true_roll_deg,no_guess,"
                  "pitch_deg,outcomes_over_roll\n");
    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    paper_look(&images, &scene, (int)PAPER_WIDTH, digital);
    for (int c = first; c <= last; c++) {
        paper_attempt a;
        double ypr[3];

        paper_true_angles(ypr, &scene, c);
        paper_solve_no_guess(&a, &images, &scene, c);
        for (int m = 0; m < 3; m++) {
            for (int i = 0; i < (int)(180 / PAPER_GRID_STEP); i++) {
                paper_procedure p = paper_published(m == 0 ? 3 : PAPER_POINTS);
                const double pitch = node(-90, PAPER_GRID_STEP, i);

                p.pairs_used = m < 2 ? 2 : 0;
                fprintf(file, "%d,%d,%d,%.4f,%.4f,%s,%g,", c + 1, p.n, p.pairs_used,
                        ypr[1] / PAPER_DEGREE, ypr[2] / PAPER_DEGREE,
                        outcome_names[a.outcome], pitch);
                print_row(file, &p, &images, &scene, c, 0, pitch);
                fprintf(file, "\n");
            }
        }
    }
    table_close(file);
}

void figure_3(void)
{
    map_figure("fig03", 0, 0, PAPER_PERFECT);
}

void figure_4(void)
{
    map_figure("fig04", 1, 1, PAPER_PERFECT);
}

void figure_8(void)
{
    map_figure("fig08", 0, 1, PAPER_DIGITAL);
}

/* ---- three points without a guess ------------------------------------------ */

/* Prints all poses in the documented scene, for the maps. */
static void three_documented(FILE *file, int digital)
{
    paper_scene scene;
    paper_images images;

    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    paper_look(&images, &scene, (int)PAPER_WIDTH, digital);
    for (int c = 0; c < PAPER_CAMERAS; c++) {
        rigcal_transform poses[RIGCAL_POSES_MAX];
        int right;
        const int n = paper_solve_three(poses, &right, &images, &scene, c);

        for (int i = 0; i < n; i++) {
            double ypr[3];

            paper_expect(rigcal_yaw_pitch_roll_from_rotation(ypr, poses[i].R) == RIGCAL_OK,
                         "a rotation has no angles");
            fprintf(file, "%d,%d,%.4f,%.4f,%s\n", digital, c + 1, ypr[1] / PAPER_DEGREE,
                    ypr[2] / PAPER_DEGREE,
                    outcome_names[i == right ? PAPER_CORRECT : PAPER_FALSE]);
        }
    }
}

/* Counts how often the truth is among the poses, and how many poses there are. */
static void three_random(FILE *file, int digital)
{
    int tried = 0, found = 0, poses_in_all = 0;

    for (int k = 0; k < (int)PAPER_PLACEMENTS; k++) {
        paper_scene scene;
        paper_images images;

        paper_scene_random(&scene, k, PAPER_DOCUMENTED_CM);
        paper_look(&images, &scene, (int)PAPER_WIDTH, digital);
        for (int c = 0; c < PAPER_CAMERAS; c++) {
            rigcal_transform poses[RIGCAL_POSES_MAX];
            int right;

            poses_in_all += paper_solve_three(poses, &right, &images, &scene, c);
            found += right >= 0;
            tried++;
        }
    }
    fprintf(file, "%d,%d,%d,%.2f\n", digital, tried, found, (double)poses_in_all / tried);
}

void figure_three(void)
{
    FILE *const file = table_open("three_points");
    FILE *const shares = table_open("three_points_random");

    fprintf(file, "digital,camera,pitch_deg,roll_deg,outcome\n");
    fprintf(shares, "digital,tried,correct,poses\n");
    for (int digital = PAPER_PERFECT; digital <= PAPER_DIGITAL; digital++) {
        three_documented(file, digital);
        three_random(shares, digital);
    }
    table_close(file);
    table_close(shares);
}

/* ---- figure 5: three angles against two --------------------------------- */

static const struct {
    const char *name;
    int angles, pairs_used;
} rivals[] = {{"two_angles", 2, 2}, {"two_angles_all", 2, 0}, {"three_angles", 3, 2}};

/* Searches in random placements, each from one random guess of pitch and roll. */
static void race(FILE *file, int rival, double yaw_off)
{
    static sample evals;
    tally t = {{0}, 0, 0};

    evals.n = 0;
    for (int k = 0; k < (int)PAPER_PLACEMENTS; k++) {
        paper_rng rng = paper_stream(PAPER_GUESSING, k);
        paper_scene scene;
        paper_images images;

        paper_scene_random(&scene, k, PAPER_DOCUMENTED_CM);
        paper_look(&images, &scene, (int)PAPER_WIDTH, PAPER_PERFECT);
        for (int c = 0; c < PAPER_CAMERAS; c++) {
            paper_procedure p = paper_published(PAPER_POINTS);
            const double pitch = paper_uniform(&rng, -90, 90);
            const double roll = paper_uniform(&rng, -180, 180);
            const double sign = paper_uniform(&rng, -1, 1) < 0 ? -1 : 1;
            double ypr[3];
            paper_attempt a;

            p.angles = rivals[rival].angles;
            p.pairs_used = rivals[rival].pairs_used;
            paper_true_angles(ypr, &scene, c);
            guess(&p, ypr[0] / PAPER_DEGREE + sign * yaw_off, pitch, roll);
            paper_solve(&a, &p, &images, &scene, c);
            count(&t, &a);
            sample_add(&evals, a.evals);
        }
    }
    fprintf(file, "%s,%g,%d,%d,%d", rivals[rival].name, yaw_off, t.tried,
            t.count[PAPER_CORRECT], t.count[PAPER_FALSE]);
    sample_print(file, &evals);
    fprintf(file, "\n");
}

static void rival_map(FILE *file, int rival, double yaw_off)
{
    paper_scene scene;
    paper_images images;
    paper_procedure p = paper_published(PAPER_POINTS);
    double ypr[3];

    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    paper_look(&images, &scene, (int)PAPER_WIDTH, PAPER_PERFECT);
    p.angles = rivals[rival].angles;
    p.pairs_used = rivals[rival].pairs_used;
    paper_true_angles(ypr, &scene, 0);
    for (int i = 0; i < (int)(180 / PAPER_GRID_STEP); i++) {
        const double pitch = node(-90, PAPER_GRID_STEP, i);

        fprintf(file, "%s,%g,%.4f,%.4f,%g,", rivals[rival].name, yaw_off,
                ypr[1] / PAPER_DEGREE, ypr[2] / PAPER_DEGREE, pitch);
        print_row(file, &p, &images, &scene, 0, ypr[0] / PAPER_DEGREE + yaw_off, pitch);
        fprintf(file, "\n");
    }
}

void figure_5(void)
{
    static const double offs[] = {0,  5,  10,  15,  20,  30,  35,  45, 60,
                                  75, 90, 105, 120, 135, 150, 165, 180};
    enum { OFFS = sizeof offs / sizeof offs[0], THREE = 2 };
    FILE *const file = table_open("fig05"), *const map = table_open("fig05_map");

    fprintf(file, "method,yaw_error_deg,tried,correct,false,evals_q25,"
                  "evals_median,evals_q75\n");
    fprintf(map, "method,yaw_error_deg,true_pitch_deg,true_roll_deg,pitch_deg,"
                 "outcomes_over_roll\n");
    race(file, 0, 0);
    race(file, 1, 0);
    for (int k = 0; k < OFFS; k++) {
        race(file, THREE, offs[k]);
    }
    rival_map(map, 0, 0);
    rival_map(map, 1, 0);
    rival_map(map, THREE, PAPER_NEAR_YAW);
    rival_map(map, THREE, PAPER_FAR_YAW);
    table_close(file);
    table_close(map);
}

/* ---- figures 6, 9: shares of correct and false searches ------------------ */

#define SHARE_COLUMNS "depth_cm,width_px,points,method,scenes,tried,correct,false\n"

static void print_share(FILE *file, double depth, int width, int points, const char *method,
                        const char *scenes, const tally *t)
{
    fprintf(file, "%g,%d,%d,%s,%s,%d,%d,%d\n", depth, width, points, method, scenes,
            t->tried, t->count[PAPER_CORRECT], t->count[PAPER_FALSE]);
}

/* Searches for camera c from every guess of the coarse grid. */
static void sweep(tally *t, const paper_procedure *procedure, const paper_images *images,
                  const paper_scene *scene, int c)
{
    for (int i = 0; i < (int)(180 / PAPER_SWEEP_STEP); i++) {
        for (int j = 0; j < (int)(360 / PAPER_SWEEP_STEP); j++) {
            paper_procedure p = *procedure;
            paper_attempt a;

            guess(&p, 0, node(-90, PAPER_SWEEP_STEP, i), node(-180, PAPER_SWEEP_STEP, j));
            paper_solve(&a, &p, images, scene, c);
            count(t, &a);
        }
    }
}

/* Counts in the documented scene, as in the paper. */
static void share_documented(FILE *file, double depth, int width, int digital)
{
    paper_scene scene;
    paper_images images;
    paper_attempt a;
    tally own = {{0}, 0, 0};

    paper_scene_documented(&scene, depth);
    paper_look(&images, &scene, width, digital);
    for (int n = 3; n <= PAPER_POINTS; n++) {
        tally t = {{0}, 0, 0};

        for (int c = 0; c < PAPER_CAMERAS; c++) {
            const paper_procedure p = paper_published(n);

            sweep(&t, &p, &images, &scene, c);
        }
        print_share(file, depth, width, n, "published", "documented", &t);
    }
    for (int c = 0; c < PAPER_CAMERAS; c++) {
        paper_solve_no_guess(&a, &images, &scene, c);
        count(&own, &a);
    }
    print_share(file, depth, width, PAPER_POINTS, "no_guess", "documented", &own);
}

/* Counts over the random placements, each from a random guess. */
static void share_random(FILE *file, double depth, int width, int digital)
{
    tally t[2] = {{{0}, 0, 0}, {{0}, 0, 0}}, own = {{0}, 0, 0};

    for (int k = 0; k < (int)PAPER_PLACEMENTS; k++) {
        paper_rng rng = paper_stream(PAPER_GUESSING, k);
        paper_scene scene;
        paper_images images;
        paper_attempt a;

        paper_scene_random(&scene, k, depth);
        paper_look(&images, &scene, width, digital);
        for (int c = 0; c < PAPER_CAMERAS; c++) {
            const double pitch = paper_uniform(&rng, -90, 90);
            const double roll = paper_uniform(&rng, -180, 180);

            for (int n = 3; n <= PAPER_POINTS; n++) {
                paper_procedure p = paper_published(n);

                guess(&p, 0, pitch, roll);
                paper_solve(&a, &p, &images, &scene, c);
                count(&t[n - 3], &a);
            }
            paper_solve_no_guess(&a, &images, &scene, c);
            count(&own, &a);
        }
    }
    print_share(file, depth, width, 3, "published", "random", &t[0]);
    print_share(file, depth, width, 4, "published", "random", &t[1]);
    print_share(file, depth, width, 4, "no_guess", "random", &own);
}

/* ---- figure 6: perfect images at any depth ------------------------------ */

static void print_depth(FILE *file, double depth, int points, const char *method,
                        sample *residual, sample *degrees, int tried)
{
    fprintf(file, "%g,%d,%s,%d,%d", depth, points, method, tried, residual->n);
    sample_print(file, residual);
    sample_print(file, degrees);
    fprintf(file, "\n");
}

void figure_6(void)
{
    const int many = (int)PAPER_NEAR_GUESSES;
    const double step = 2 * PAPER_NEAR_GUESS / many;
    FILE *const file = table_open("fig06");

    fprintf(file, "depth_cm,points,method,tried,correct,residual_q25,"
                  "residual_median,residual_q75,rotation_deg_q25,"
                  "rotation_deg_median,rotation_deg_q75\n");
    for (int d = 20; d <= 320; d += 20) {
        paper_scene scene;
        paper_images images;
        paper_attempt a;
        static sample residual, degrees;

        paper_scene_documented(&scene, d);
        paper_look(&images, &scene, (int)PAPER_WIDTH, PAPER_PERFECT);
        for (int n = 3; n <= PAPER_POINTS; n++) {
            tally t = {{0}, 0, 0};

            residual.n = degrees.n = 0;
            for (int i = 0; i < PAPER_CAMERAS * many * many; i++) {
                const int c = i / (many * many);
                const double off[3] = {0, node(-PAPER_NEAR_GUESS, step, i / many % many),
                                       node(-PAPER_NEAR_GUESS, step, i % many)};
                paper_procedure p = paper_published(n);

                guess_near(&p, &scene, c, off);
                paper_solve(&a, &p, &images, &scene, c);
                count(&t, &a);
                if (a.outcome == PAPER_CORRECT) {
                    sample_add(&residual, a.residual);
                    sample_add(&degrees, a.degrees);
                }
            }
            print_depth(file, d, n, "published", &residual, &degrees, t.tried);
        }
        residual.n = degrees.n = 0;
        for (int c = 0; c < PAPER_CAMERAS; c++) {
            paper_solve_no_guess(&a, &images, &scene, c);
            if (a.outcome == PAPER_CORRECT) {
                sample_add(&residual, a.residual);
                sample_add(&degrees, a.degrees);
            }
        }
        print_depth(file, d, PAPER_POINTS, "no_guess", &residual, &degrees, PAPER_CAMERAS);
    }
    table_close(file);
}

/* The number of guesses, over all directions, that converge at each depth. */
void figure_6_share(void)
{
    FILE *const file = table_open("fig06_share");

    fprintf(file, SHARE_COLUMNS);
    for (int d = 20; d <= 320; d += 20 * table_every) {
        share_documented(file, d, (int)PAPER_WIDTH, PAPER_PERFECT);
        share_random(file, d, (int)PAPER_WIDTH, PAPER_PERFECT);
        fprintf(stderr, "  figure 6: %d cm\n", d);
    }
    table_close(file);
}

/* ---- figure 9: correct and false against resolution --------------------- */

void figure_9(void)
{
    FILE *const file = table_open("fig09");

    fprintf(file, SHARE_COLUMNS);
    for (int d = 0; d < PAPER_DEPTHS; d++) {
        for (int w = 0; w < PAPER_WIDTHS; w += table_every) {
            share_documented(file, paper_depths_cm[d], paper_widths[w], PAPER_DIGITAL);
            share_random(file, paper_depths_cm[d], paper_widths[w], PAPER_DIGITAL);
            fprintf(stderr, "  figure 9: %g cm, %d px\n", paper_depths_cm[d],
                    paper_widths[w]);
        }
    }
    table_close(file);
}

/* ---- the paper's counts ---------------------------------------------------
 *
 * Camera 1 of the documented scene, from as many guesses as the paper counts. */

enum { EVERYWHERE, NEAR, MAP, SPREADS };
static const char *const spread_names[SPREADS] = {"everywhere", "near", "map"};

/* The guess of yaw: none; near the truth; or as far from that as the paper's two guesses of
 * yaw are from each other. */
enum { NO_YAW, NEAR_YAW, APART_YAW };

/* 30 and 41 guesses are the sums of the paper's counts of figures 3 and 8. How many
 * guesses figure 5 had is lost: 47 is its largest count. */
static const struct {
    const char *figure;
    int digital, points, angles, yaw, guesses;
} counted[] = {
    {"3", PAPER_PERFECT, 3, 2, NO_YAW, 30},   {"3", PAPER_PERFECT, 4, 2, NO_YAW, 30},
    {"5", PAPER_PERFECT, 4, 3, NEAR_YAW, 47}, {"5", PAPER_PERFECT, 4, 3, APART_YAW, 47},
    {"5", PAPER_PERFECT, 4, 2, NO_YAW, 47},   {"8", PAPER_DIGITAL, 4, 2, NO_YAW, 41},
    {"8", PAPER_DIGITAL, 3, 2, NO_YAW, 41}};

/* Guess i of n, spread evenly over pitch and roll: all of them, those near the
 * truth, or the map's grid. Yaw is `yaw` off the truth. Pitches are evenly spaced;
 * rolls step by the golden ratio, so any n is spread evenly. Angles in degrees. */
static void spread(paper_procedure *p, int where, int i, int n, const double truth[3],
                   double yaw)
{
    const double along = 2 * (i + 0.5) / n - 1;
    const double across = 2 * fmod(0.5 + i * 0.6180339887498949, 1) - 1;
    const int columns = (int)(360 / PAPER_GRID_STEP);

    if (where == EVERYWHERE) {
        guess(p, truth[0] + yaw, 90 * along, 180 * across);
    } else if (where == NEAR) {
        guess(p, truth[0] + yaw, truth[1] + PAPER_COUNT_NEAR * along,
              truth[2] + PAPER_COUNT_NEAR * across);
    } else {
        guess(p, truth[0] + yaw, node(-90, PAPER_GRID_STEP, i / columns),
              node(-180, PAPER_GRID_STEP, i % columns));
    }
}

/* Prints one row of the table: all guesses of one spread. */
static void count_guesses(FILE *file, int row, int where)
{
    const double off[3] = {0, PAPER_NEAR_YAW, PAPER_NEAR_YAW + PAPER_YAW_APART};
    const double yaw = off[counted[row].yaw];
    const int n = where == MAP ? (int)(180 / PAPER_GRID_STEP) * (int)(360 / PAPER_GRID_STEP)
                               : counted[row].guesses;
    paper_scene scene;
    paper_images images;
    double truth[3];
    tally t = {{0}, 0, 0};

    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    paper_look(&images, &scene, (int)PAPER_WIDTH, counted[row].digital);
    paper_true_angles(truth, &scene, 0);
    for (int k = 0; k < 3; k++) {
        truth[k] /= PAPER_DEGREE;
    }
    for (int i = 0; i < n; i++) {
        paper_procedure p = paper_published(counted[row].points);
        paper_attempt a;

        p.angles = counted[row].angles;
        spread(&p, where, i, n, truth, yaw);
        paper_solve(&a, &p, &images, &scene, 0);
        count(&t, &a);
    }
    fprintf(file, "%s,%d,%d,%d,%g,%s,%d,%d,%d,%d\n", counted[row].figure,
            counted[row].digital, counted[row].points, counted[row].angles, yaw,
            spread_names[where], t.tried, t.count[PAPER_CORRECT], t.count[PAPER_FALSE],
            t.behind);
}

/* Prints where camera 1's search from this guess ends. */
static void print_end(FILE *file, int points, double pitch, double roll)
{
    paper_procedure p = paper_published(points);
    paper_scene scene;
    paper_images images;
    paper_attempt a;
    double ypr[3];

    paper_scene_documented(&scene, PAPER_DOCUMENTED_CM);
    paper_look(&images, &scene, (int)PAPER_WIDTH, PAPER_PERFECT);
    guess(&p, 0, pitch, roll);
    paper_solve(&a, &p, &images, &scene, 0);
    fprintf(file, "%d,%g,%g,%s", points, pitch, roll,
            a.behind ? "behind" : outcome_names[a.outcome]);
    if (a.has_pose) {
        paper_expect(rigcal_yaw_pitch_roll_from_rotation(ypr, a.pose.R) == RIGCAL_OK,
                     "a rotation has no angles");
        fprintf(file, ",%.2f,%.2f\n", ypr[1] / PAPER_DEGREE, ypr[2] / PAPER_DEGREE);
    } else {
        fprintf(file, ",,\n");
    }
}

void figure_counts(void)
{
    FILE *const file = table_open("counts");
    FILE *const ends = table_open("ends");

    fprintf(file, "figure,digital,points,angles,yaw_error_deg,guesses,tried,"
                  "correct,false,behind\n");
    for (int i = 0; i < (int)(sizeof counted / sizeof counted[0]); i++) {
        for (int where = 0; where < SPREADS; where++) {
            count_guesses(file, i, where);
        }
    }
    fprintf(ends, "points,guess_pitch_deg,guess_roll_deg,outcome,end_pitch_deg,"
                  "end_roll_deg\n");
    print_end(ends, 3, PAPER_THEIR_PITCH, PAPER_THEIR_ROLL);
    print_end(ends, PAPER_POINTS, PAPER_THEIR_PITCH, PAPER_THEIR_ROLL);
    print_end(ends, 3, PAPER_OUR_PITCH, PAPER_THEIR_ROLL);
    table_close(file);
    table_close(ends);
}

/* ---- our own: what the choices of the procedure do ---------------------- */

static const struct {
    const char *name;
    int eliminated, pairs_used;
} choices[] = {{"yaw_2", RIGCAL_YAW, 2},     {"pitch_2", RIGCAL_PITCH, 2},
               {"roll_2", RIGCAL_ROLL, 2},   {"best_2", RIGCAL_BEST_CONDITIONED, 2},
               {"yaw_all", RIGCAL_YAW, 0},   {"pitch_all", RIGCAL_PITCH, 0},
               {"roll_all", RIGCAL_ROLL, 0}, {"best_all", RIGCAL_BEST_CONDITIONED, 0}};

/* The rotation error, divided by the bound's sigma of all three axes. */
static double over_sigma(const paper_attempt *a, const double Sigma[36])
{
    return a->has_pose ? a->degrees * PAPER_DEGREE / sqrt(Sigma[0] + Sigma[7] + Sigma[14])
                       : HUGE_VAL;
}

typedef struct {
    paper_scene scene;
    paper_images images;
    double Sigma[36], guess[3];
} trial;

static void make_trial(trial *t, int k)
{
    paper_rng rng = paper_stream(PAPER_GUESSING, k);

    paper_scene_random(&t->scene, k, PAPER_DOCUMENTED_CM);
    paper_look(&t->images, &t->scene, (int)PAPER_WIDTH, PAPER_DIGITAL);
    paper_expect(paper_covariance(t->Sigma, &t->scene.cam_from_target[0], &t->images, 0),
                 "a placement has no bound");
    t->guess[0] = paper_uniform(&rng, -180, 180);
    t->guess[1] = paper_uniform(&rng, -90, 90);
    t->guess[2] = paper_uniform(&rng, -180, 180);
}

void figure_choices(void)
{
    FILE *const file = table_open("choices");

    fprintf(file, "choice,placements,correct_from_anywhere,false_from_anywhere,"
                  "over_sigma_q25,over_sigma_median,over_sigma_q75,condition_q25,"
                  "condition_median,condition_q75\n");
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; i++) {
        static sample errors, conditions;
        tally anywhere = {{0}, 0, 0};

        errors.n = conditions.n = 0;
        for (int k = 0; k < (int)PAPER_PLACEMENTS; k++) {
            paper_procedure p = paper_published(PAPER_POINTS);
            paper_attempt a;
            trial t;

            make_trial(&t, k);
            p.eliminated = choices[i].eliminated;
            p.pairs_used = choices[i].pairs_used;
            guess(&p, t.guess[0], t.guess[1], t.guess[2]);
            paper_solve(&a, &p, &t.images, &t.scene, 0);
            count(&anywhere, &a);
            p.use_guess = 0;
            paper_solve(&a, &p, &t.images, &t.scene, 0);
            sample_add(&errors, over_sigma(&a, t.Sigma));
            sample_add(&conditions, a.has_pose ? a.condition : HUGE_VAL);
        }
        fprintf(file, "%s,%d,%d,%d", choices[i].name, anywhere.tried,
                anywhere.count[PAPER_CORRECT], anywhere.count[PAPER_FALSE]);
        sample_print(file, &errors);
        sample_print(file, &conditions);
        fprintf(file, "\n");
    }
    table_close(file);
}

/* Tries all fifteen choices of two pairs among six, sorted by cond(A) into two bins a
 * decade. */
void figure_conditions(void)
{
    enum { BINS = 10, PAIRS = 6 };
    static sample bins[BINS];
    FILE *const file = table_open("conditions");

    memset(bins, 0, sizeof bins);
    for (int k = 0; k < (int)PAPER_PLACEMENTS / 2; k++) {
        trial t;

        make_trial(&t, k);
        for (int i = 0; i < PAIRS; i++) {
            for (int j = i + 1; j < PAIRS; j++) {
                paper_procedure p = paper_published(PAPER_POINTS);
                paper_attempt a;
                int bin;

                p.first[0] = i;
                p.first[1] = j;
                p.use_guess = 0;
                paper_solve(&a, &p, &t.images, &t.scene, 0);
                if (a.condition >= 1) {
                    bin = (int)(2 * log10(a.condition));
                    sample_add(&bins[bin < BINS ? bin : BINS - 1], over_sigma(&a, t.Sigma));
                }
            }
        }
    }
    fprintf(file, "condition_from,condition_to,n,over_sigma_q25,"
                  "over_sigma_median,over_sigma_q75\n");
    for (int b = 0; b < BINS; b++) {
        fprintf(file, "%.3g,%.3g,%d", pow(10, b / 2.0), pow(10, (b + 1) / 2.0), bins[b].n);
        sample_print(file, &bins[b]);
        fprintf(file, "\n");
    }
    table_close(file);
}
