/* matching.c - finds each corner of one image in the other, by its band alone.
 *
 *   rigcal_matching DATA OUT
 *
 * Given: DATA, two cameras that saw a chessboard in several placements (data/FORMAT.md).
 * Asked: for each corner of the left image, which corner of the right image it is. The
 *        rig is calibrated without that placement, so nothing is known of its board.
 * Truth: corners of one number are the same corner.
 *
 * Writes OUT/corners.csv, one line a corner, and OUT/bands.csv, the bands of some corners
 * of one placement, for draw.py; and prints what is in examples/matching/README.md. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "../cli_input.h"

enum { PLACES_MAX = 16, POINTS_MAX = 100, VIEWS_MAX = 2 * PLACES_MAX, REPEATS = 200 };

/* The distances at which a board can be [m]. What is drawn: the placement, and one corner
 * in so many. */
static const rigcal_real NEAR_M = (rigcal_real)0.2, FAR_M = (rigcal_real)0.8;
enum { DRAWN_PLACE = 3, DRAWN_EACH = 7, CURVE = 60 };

typedef struct {
    rigcal_camera camera[2]; /* left, right */
    rigcal_observation seen[VIEWS_MAX][POINTS_MAX];
    rigcal_rig_view views[VIEWS_MAX]; /* for each placement: left, then right */
    rigcal_view_pose poses[VIEWS_MAX];
    size_t n_places;
} stereo;

static void stop_if(int is_wrong, const char *what)
{
    if (is_wrong) {
        cli_fail("%s", what);
    }
}

static void check(rigcal_status status)
{
    stop_if(status < 0, rigcal_status_text(status));
}

static void read_data(stereo *s, const char *folder)
{
    cli_cameras cameras;
    cli_observations all;

    cli_cameras_read(&cameras, cli_text("%s/cameras.csv", folder));
    cli_observations_read(&all, cli_text("%s/observations.csv", folder), &cameras, 1);
    s->n_places = all.frames.count;
    stop_if(cameras.names.count != 2 || s->n_places > PLACES_MAX, "two cameras are wanted");
    for (size_t i = 0; i < all.count; i++) { /* sorted by frame, point, camera */
        const cli_observation *const o = &all.list[i];
        rigcal_rig_view *const v = &s->views[2 * o->frame + o->camera];

        stop_if(v->view.n == POINTS_MAX, "too many corners");
        s->seen[2 * o->frame + o->camera][v->view.n++] = cli_seen(&all, o);
    }
    for (size_t v = 0; v < 2 * s->n_places; v++) {
        rigcal_pose pose[RIGCAL_POSES_MAX];
        size_t n;

        s->camera[v % 2] = cameras.camera[v % 2];
        s->views[v].view.camera = &s->camera[v % 2];
        s->views[v].view.observations = s->seen[v];
        s->views[v].camera = (int32_t)(v % 2);
        s->views[v].placement = (int32_t)(v / 2);
        check(rigcal_pose_solve(pose, RIGCAL_POSES_MAX, &n, NULL, &s->views[v].view, NULL));
        check(rigcal_view_pose_make(&s->poses[v], &s->views[v], &pose[0].cam_from_world));
    }
}

/* Calibrates the pair from all placements but one. */
static void calibrate_without(rigcal_match_pair *pair, stereo *s, size_t place)
{
    static rigcal_real work[RIGCAL_RIG_WORK(2, 2, PLACES_MAX)];
    rigcal_transform cams[2], places[PLACES_MAX];
    int32_t group[2];
    uint8_t left_out[VIEWS_MAX] = {0};
    rigcal_real sigma[2], freedom[2];
    rigcal_rig_fit fit;
    rigcal_rig rig = {cams,
                      2,
                      places,
                      s->n_places,
                      group,
                      2 * s->n_places,
                      s->views,
                      .view_poses = s->poses,
                      .left_out = left_out,
                      .work = work};

    rig.work_capacity = sizeof work / sizeof work[0];
    left_out[2 * place] = left_out[2 * place + 1] = 1;
    places[place] = s->poses[2 * place].cam_from_target; /* any pose will do: no view of it
                                                            is used */
    check(rigcal_rig_join(&rig, NULL));
    check(rigcal_rig_adjust(&fit, NULL, &rig));
    check(rigcal_rig_noise(sigma, freedom, &rig));
    memset(pair, 0, sizeof *pair);
    pair->camera_a = &s->camera[0];
    pair->camera_b = &s->camera[1];
    pair->sigma_a = sigma[0];
    pair->sigma_b = sigma[1];
    check(rigcal_match_k(&pair->k, (rigcal_real)0.99, RIGCAL_MATCH_SEARCH));
    check(rigcal_rig_pair(&pair->b_from_a, pair->Sigma, &rig,
                          fit.sigma_px * (rigcal_real)sqrt(fmax(1, fit.F)), 0, 1));
}

/* The counts of the search: corners; corners whose true match is in the band, and is the
 * best there; candidates without a band, in the band, in the band and the depth range;
 * seconds. */
typedef struct {
    size_t corners, held, best, held_in_range, best_in_range;
    size_t all, in_band, in_range;
    double seconds;
} tally;

/* Looks for corner i of the left image. */
static void look_for(tally *t, FILE *file, rigcal_match_pair *pair, const stereo *s,
                     size_t place, size_t i, const rigcal_ray rays[])
{
    const rigcal_view *const left = &s->views[2 * place].view;
    const size_t n = s->views[2 * place + 1].view.n;
    const rigcal_real *const uv = left->observations[i].uv;
    const rigcal_real *const uv_b = s->seen[2 * place + 1][i].uv;
    rigcal_match found[POINTS_MAX];
    size_t written, inside[2];
    int held[2] = {0, 0}, best[2];
    rigcal_band band;

    for (int ranged = 0; ranged < 2; ranged++) {
        pair->near_a = ranged ? NEAR_M : 0;
        pair->far_a = ranged ? FAR_M : 0;
        const clock_t start = clock();
        for (int repeat = 0; repeat < REPEATS; repeat++) {
            check(rigcal_band_make(&band, pair, uv));
            check(rigcal_band_search_rays(found, POINTS_MAX, &written, &inside[ranged],
                                          NULL, &band, rays, n));
        }
        t->seconds += (double)(clock() - start) / CLOCKS_PER_SEC / REPEATS / 2;
        for (size_t k = 0; k < written; k++) {
            held[ranged] |= found[k].index == (int32_t)i;
        }
        best[ranged] = written > 0 ? (int)found[0].index : -1;
    }
    t->corners++;
    t->all += n;
    t->in_band += inside[0];
    t->in_range += inside[1];
    t->held += (size_t)held[0];
    t->held_in_range += (size_t)held[1];
    t->best += best[0] == (int)i;
    t->best_in_range += best[1] == (int)i;
    fprintf(file, "%d,%d,%.4f,%.4f,%.4f,%.4f,%d,%d,%d,%d,%d\n", (int)place, (int)i,
            (double)uv[0], (double)uv[1], (double)uv_b[0], (double)uv_b[1], (int)n,
            (int)inside[0], (int)inside[1], best[0], best[1]);
}

/* Writes the band of one corner, to be drawn. */
static void write_band(FILE *file, rigcal_match_pair *pair, const stereo *s, size_t place,
                       size_t i)
{
    rigcal_band_point points[CURVE];
    rigcal_band band;
    size_t n;

    pair->near_a = NEAR_M;
    pair->far_a = FAR_M;
    check(rigcal_band_make(&band, pair, s->seen[2 * place][i].uv));
    check(rigcal_band_curve(points, CURVE, &n, &band));
    for (size_t k = 0; k < n; k++) {
        fprintf(file, "%d,%.4f,%.4f,%.6f,%.6f,%.4f,%.4f\n", (int)i, (double)points[k].uv[0],
                (double)points[k].uv[1], (double)points[k].across[0],
                (double)points[k].across[1], (double)points[k].half_width,
                (double)points[k].depth_a);
    }
}

static void print(const tally *t)
{
    const double n = (double)t->corners;

    printf("| looked at | candidates a corner | holds the match | the best is the match |\n"
           "| --- | ---: | ---: | ---: |\n"
           "| the whole image | %.1f | 100.0 %% | |\n"
           "| the band | %.1f | %.1f %% | %.1f %% |\n"
           "| the band from %.1f to %.1f m | %.1f | %.1f %% | %.1f %% |\n",
           (double)t->all / n, (double)t->in_band / n, 100 * (double)t->held / n,
           100 * (double)t->best / n, (double)NEAR_M, (double)FAR_M,
           (double)t->in_range / n, 100 * (double)t->held_in_range / n,
           100 * (double)t->best_in_range / n);
    fprintf(stderr, "%.2f microseconds a corner: its band, and its candidates.\n",
            1e6 * t->seconds / n);
}

int main(int argc, char *argv[])
{
    static stereo s;
    static rigcal_ray rays[POINTS_MAX];
    tally t = {0};

    stop_if(argc != 3, "usage: rigcal_matching DATA OUT");
    read_data(&s, argv[1]);
    FILE *const corners = fopen(cli_text("%s/corners.csv", argv[2]), "w");
    FILE *const bands = fopen(cli_text("%s/bands.csv", argv[2]), "w");
    stop_if(corners == NULL || bands == NULL, "the files in OUT cannot be written");
    fputs("place,corner,u,v,u_true,v_true,all,in_band,in_range,best,best_in_range\n",
          corners);
    fputs("corner,u,v,across_u,across_v,half_width,depth\n", bands);
    for (size_t place = 0; place < s.n_places; place++) {
        rigcal_match_pair pair;
        const size_t n = s.views[2 * place].view.n;

        calibrate_without(&pair, &s, place);
        for (size_t i = 0; i < n; i++) {
            check(rigcal_ray_make(&rays[i], &s.camera[1], s.seen[2 * place + 1][i].uv));
        }
        for (size_t i = 0; i < n; i++) {
            look_for(&t, corners, &pair, &s, place, i, rays);
            if (place == DRAWN_PLACE && i % DRAWN_EACH == 3) {
                write_band(bands, &pair, &s, place, i);
            }
        }
    }
    stop_if(fclose(corners) != 0 || fclose(bands) != 0, "the files in OUT are not whole");
    print(&t);
    return 0;
}
