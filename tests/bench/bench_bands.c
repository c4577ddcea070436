/* bench_bands: real matches. Calibrates the rig of each folder (data/FORMAT.md), leaves out
 * the views that contradict it, and counts the matches that the 99 % bands of all pairs of
 * cameras hold: points of one name in one frame. One line of a table a folder; exit status
 * 1 where a folder's bands hold less than 98 %.
 *
 *   bench_bands FOLDER...
 *
 * The noise is each camera's own (rigcal_rig_noise); the calibration's covariance is for
 * the noise of the rig times sqrt(F). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli_input.h"
#include "rigcal_solvers.h"

typedef struct {
    cli_cameras cameras;
    cli_observations all;
    size_t n_views;
    rigcal_rig_view *views;
    rigcal_view_pose *poses, *second;
    uint32_t **points; /* for each view, the names of its points */
    rigcal_rig rig;
    rigcal_rig_fit fit;
    rigcal_real *noise;
} set;

static void check(rigcal_status status, const char *what)
{
    if (status < 0) {
        cli_fail("%s: %s", what, rigcal_status_text(status));
    }
}

/* Adds a view: observations first to last, of one frame and one camera. */
static void add_view(set *s, const cli_observation *const list[], size_t n)
{
    const size_t v = s->n_views;
    rigcal_rig_view *const view = &s->views[v];
    rigcal_observation *const o = cli_alloc(n, sizeof *o);
    rigcal_pose pose[RIGCAL_POSES_MAX];
    size_t found;

    s->points[v] = cli_alloc(n, sizeof **s->points);
    for (size_t i = 0; i < n; i++) {
        o[i] = cli_seen(&s->all, list[i]);
        s->points[v][i] = (uint32_t)cli_point(&s->all, list[i]);
    }
    view->view.camera = &s->cameras.camera[list[0]->camera];
    view->view.observations = o;
    view->view.n = n;
    view->camera = (int32_t)list[0]->camera;
    view->placement = (int32_t)list[0]->frame;
    if (n < 4 ||
        rigcal_pose_solve(pose, RIGCAL_POSES_MAX, &found, NULL, &view->view, NULL) < 0 ||
        rigcal_view_pose_make(&s->poses[v], view, &pose[0].cam_from_world) != RIGCAL_OK) {
        return;
    }
    if (found > 1) {
        (void)rigcal_view_pose_make(&s->second[v], view, &pose[1].cam_from_world);
    }
    s->n_views++;
}

static void read_set(set *s, const char *folder)
{
    memset(s, 0, sizeof *s);
    cli_cameras_read(&s->cameras, cli_text("%s/cameras.csv", folder));
    cli_observations_read(&s->all, cli_text("%s/observations.csv", folder), &s->cameras, 1);
    const size_t most = s->all.frames.count * s->cameras.names.count;
    const cli_observation **const list = cli_alloc(s->all.count, sizeof *list);

    s->views = cli_alloc(most, sizeof *s->views);
    s->poses = cli_alloc(most, sizeof *s->poses);
    s->second = cli_alloc(most, sizeof *s->second);
    s->points = cli_alloc(most, sizeof *s->points);
    for (size_t i = 0, end; i < s->all.count; i = end) { /* frame by frame */
        for (end = i; end < s->all.count && s->all.list[end].frame == s->all.list[i].frame;
             end++) {
        }
        for (size_t c = 0; c < s->cameras.names.count; c++) {
            size_t n = 0;

            for (size_t k = i; k < end; k++) {
                if (s->all.list[k].camera == c) {
                    list[n++] = &s->all.list[k];
                }
            }
            if (n > 0) {
                add_view(s, list, n);
            }
        }
    }
}

static void calibrate(set *s, const char *folder)
{
    const size_t n_cameras = s->cameras.names.count, n_frames = s->all.frames.count;
    const size_t room = rigcal_choose_work(n_cameras, n_frames, s->n_views) +
                        rigcal_judge_work(n_cameras, n_frames);
    rigcal_choice choice = {0};
    rigcal_judgement judgement;
    uint8_t *const left_out = cli_alloc(s->n_views, 1);
    rigcal_judged_view *const judged = cli_alloc(s->n_views, sizeof *judged);
    rigcal_rig *const rig = &s->rig;

    rig->cams_from_rig = cli_alloc(n_cameras, sizeof *rig->cams_from_rig);
    rig->n_cameras = n_cameras;
    rig->rig_from_placements = cli_alloc(n_frames, sizeof *rig->rig_from_placements);
    rig->n_placements = n_frames;
    rig->group = cli_alloc(n_cameras, sizeof *rig->group);
    rig->n_views = s->n_views;
    rig->views = s->views;
    rig->view_poses = s->poses;
    rig->work = cli_alloc(room, sizeof *rig->work);
    rig->work_capacity = room;
    choice.takes = cli_alloc(s->n_views, 1);
    choice.second_poses = s->second;
    check(rigcal_rig_choose(&choice, NULL, rig), folder);
    rig->left_out = left_out;
    check(rigcal_rig_judge(&judgement, NULL, judged, left_out, &choice, rig), folder);
    s->fit = judgement.fit;
    s->noise = cli_alloc(2 * n_cameras, sizeof *s->noise);
    check(rigcal_rig_noise(s->noise, s->noise + n_cameras, rig), folder);
}

typedef struct {
    size_t all, held, refused;
    double width;
} tally;

static void match_views(tally *t, const set *s, const rigcal_match_pair *pair, size_t a,
                        size_t b)
{
    const rigcal_view *const left = &s->views[a].view, *const right = &s->views[b].view;

    for (size_t i = 0; i < left->n; i++) {
        for (size_t k = 0; k < right->n; k++) {
            rigcal_band band;
            rigcal_match match;

            if (s->points[a][i] != s->points[b][k]) {
                continue;
            }
            t->all++;
            if (rigcal_band_make(&band, pair, left->observations[i].uv) != RIGCAL_OK ||
                rigcal_band_test(&match, &band, right->observations[k].uv) != RIGCAL_OK) {
                t->refused++;
                continue;
            }
            t->held += (size_t)match.is_inside;
            t->width += 2 * (double)match.half_width_px;
        }
    }
}

static void match_pair(tally *t, const set *s, size_t a, size_t b)
{
    const rigcal_real sigma =
        s->fit.sigma_px * (rigcal_real)sqrt(fmax(1, (double)s->fit.F));
    rigcal_match_pair pair;

    memset(&pair, 0, sizeof pair);
    pair.camera_a = &s->cameras.camera[a];
    pair.camera_b = &s->cameras.camera[b];
    pair.sigma_a = s->noise[a];
    pair.sigma_b = s->noise[b];
    check(rigcal_match_k(&pair.k, (rigcal_real)0.99, RIGCAL_MATCH_SEARCH), "k");
    if (rigcal_rig_pair(&pair.b_from_a, pair.Sigma, &s->rig, sigma, a, b) != RIGCAL_OK) {
        return;
    }
    for (size_t v = 0; v < s->n_views; v++) {
        for (size_t w = 0; w < s->n_views; w++) {
            if (s->views[v].placement == s->views[w].placement && !s->rig.left_out[v] &&
                !s->rig.left_out[w] && s->views[v].camera == (int32_t)a &&
                s->views[w].camera == (int32_t)b) {
                match_views(t, s, &pair, v, w);
            }
        }
    }
}

int main(int argc, char *argv[])
{
    int good = 1;

    puts("| set | cameras | matches | in the 99 % band | mean width | sqrt(F) | refused |\n"
         "| --- | ---: | ---: | ---: | ---: | ---: | ---: |");
    for (int i = 1; i < argc; i++) {
        const char *const name = strrchr(argv[i], '/');
        set s;
        tally t = {0, 0, 0, 0};

        read_set(&s, argv[i]);
        calibrate(&s, argv[i]);
        for (size_t a = 0; a < s.cameras.names.count; a++) {
            for (size_t b = 0; b < s.cameras.names.count; b++) {
                if (a != b) {
                    match_pair(&t, &s, a, b);
                }
            }
        }
        printf("| %s | %d | %d | %.2f %% | %.1f px | %.1f | %d |\n",
               name ? name + 1 : argv[i], (int)s.cameras.names.count, (int)t.all,
               100 * (double)t.held / (double)t.all, t.width / (double)t.all,
               sqrt((double)s.fit.F), (int)t.refused);
        fflush(stdout);
        good &= t.all > 0 && (double)t.held >= 0.98 * (double)t.all;
    }
    return good ? 0 : 1;
}
