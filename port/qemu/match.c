/* match.c - what matching costs: count.c counts instructions between the marks, six
 * intervals a band, in the order of match.py's ROWS.
 *
 * Two Brown cameras at random; prints "band STATUS SPANS" for each band, then sizes. */
#include <stdio.h>
#include <string.h>

#include "marks.h"
#include "rigcal_solvers.h"

#ifndef BANDS
#define BANDS 400
#endif

enum { CANDIDATES = 20, WIDTH = 640, HEIGHT = 480, SPANS_MAX = 4 * HEIGHT };

static rigcal_camera camera_a, camera_b;
static rigcal_match_pair pair;
static rigcal_spans_solver solver;
static rigcal_span spans[SPANS_MAX];
static rigcal_ray rays[CANDIDATES];
static rigcal_match matches[CANDIDATES];

static void draw_camera(rigcal_camera *c)
{
    memset(c, 0, sizeof *c);
    c->width = WIDTH;
    c->height = HEIGHT;
    c->fx = c->fy = uniform(400, 900);
    c->cx = uniform(300, 340);
    c->cy = uniform(220, 260);
    c->k1 = uniform((rigcal_real)-0.15, (rigcal_real)0.1);
    c->k2 = uniform(0, (rigcal_real)0.03);
    c->p1 = uniform((rigcal_real)-1e-3, (rigcal_real)1e-3);
    c->p2 = uniform((rigcal_real)-1e-3, (rigcal_real)1e-3);
}

static void draw_pair(void)
{
    const rigcal_real turn = (rigcal_real)0.2;
    const rigcal_real ypr[3] = {uniform(-turn, turn), uniform(-turn, turn),
                                uniform(-turn, turn)};

    draw_camera(&camera_a);
    draw_camera(&camera_b);
    memset(&pair, 0, sizeof pair);
    pair.camera_a = &camera_a;
    pair.camera_b = &camera_b;
    (void)rigcal_rotation_from_yaw_pitch_roll(pair.b_from_a.R, ypr);
    for (int i = 0; i < 3; i++) {
        pair.b_from_a.t[i] = uniform((rigcal_real)-0.5, (rigcal_real)0.5);
        pair.Sigma[7 * i] = (rigcal_real)1e-6;
        pair.Sigma[7 * (i + 3)] = (rigcal_real)4e-6;
    }
    pair.sigma_a = pair.sigma_b = (rigcal_real)0.3;
    (void)rigcal_match_k(&pair.k, (rigcal_real)0.99, RIGCAL_MATCH_SEARCH);
    pair.near_a = 2;
}

static void draw_pixel(rigcal_real uv[2])
{
    uv[0] = uniform(0, WIDTH - 1);
    uv[1] = uniform(0, HEIGHT - 1);
}

static void count_band(void)
{
    rigcal_band band;
    rigcal_ray ray;
    rigcal_real a[2], b[2];
    size_t n = 0, n_inside, n_spans = 0;
    int32_t at_fault;

    draw_pair();
    draw_pixel(a);
    for (int i = 0; i < CANDIDATES; i++) {
        draw_pixel(b);
        (void)rigcal_ray_make(&rays[i], &camera_b, b);
    }
    jobs_begin();
    (void)rigcal_ray_make(&ray, &camera_a, a);
    jobs_end();
    jobs_begin();
    (void)rigcal_band_make_ray(&band, &pair, &ray);
    jobs_end();
    jobs_begin();
    (void)rigcal_band_make(&band, &pair, a);
    jobs_end();
    jobs_begin();
    (void)rigcal_ray_make(&ray, &camera_b, b);
    jobs_end();
    jobs_begin();
    (void)rigcal_band_search_rays(matches, CANDIDATES, &n, &n_inside, &at_fault, &band,
                                  rays, CANDIDATES);
    jobs_end();
    jobs_begin();
    const rigcal_status status =
        rigcal_spans_find(spans, SPANS_MAX, &n_spans, &solver, &band);
    jobs_end();
    printf("band %d %d\n", (int)status, (int)n_spans);
}

int main(void)
{
    for (int i = 0; i < BANDS; i++) {
        count_band();
    }
    printf("band %d ray %d spans %d\n", (int)sizeof(rigcal_band), (int)sizeof(rigcal_ray),
           (int)sizeof solver);
    return 0;
}
