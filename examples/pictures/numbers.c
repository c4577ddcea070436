/* numbers.c - the numbers that the pictures of the documents are drawn from.
 *
 *   rigcal_pictures OUT
 *
 * Writes into the folder OUT:
 *   sphere.csv, seeds.csv   the cost of every direction of the optical axis, and where the
 *                           search looks (EQUATIONS.md A)
 *   optima.csv              the two poses of a flat target, and its corners in the image
 *   links.csv, views.csv    a rig of five cameras: who shares what
 *   cameras.csv, boards.csv, matches.csv
 *                           a rig for `rigcal calibrate` and `rigcal monitor`, of which one
 *                           camera is turned
 *
 * The search's cost is not in the public headers, so this program is linked with the
 * library's own ones. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "rc_camera.h"
#include "rc_direction.h"

static const double PI = 3.14159265358979323846;
static const rigcal_camera LENS = {
    .width = 640, .height = 480, .fx = 800, .fy = 800, .cx = 319.5, .cy = 239.5};

static void stop_if(int is_wrong, const char *what)
{
    if (is_wrong) {
        fprintf(stderr, "rigcal_pictures: %s\n", what);
        exit(1);
    }
}

static void check(rigcal_status status)
{
    stop_if(status < 0, rigcal_status_text(status));
}

static FILE *file(const char *folder, const char *name, const char *head)
{
    char path[1024];
    const int n = snprintf(path, sizeof path, "%s/%s.csv", folder, name);

    stop_if(n < 0 || (size_t)n >= sizeof path, "the name of the folder is too long");
    FILE *const f = fopen(path, "w");
    stop_if(f == NULL, "a file cannot be written");
    fprintf(f, "%s\n", head);
    return f;
}

static void done(FILE *f)
{
    stop_if(fclose(f) != 0, "a file cannot be written");
}

/* SplitMix64; -1 .. 1 */
static double random_of(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;

    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / (double)((uint64_t)1 << 52) - 1;
}

/* Nearly normal, of standard deviation 1: a sum of twelve. */
static double normal(uint64_t *state)
{
    double sum = 0;

    for (int i = 0; i < 12; i++) {
        sum += random_of(state) / 2;
    }
    return sum;
}

/* R = Ry(turn) Rx(nod), the point `at` of the world ahead at z = depth. */
static rigcal_transform looking(double turn, double nod, const double at[3], double depth)
{
    const double c = cos(turn), s = sin(turn), d = cos(nod), e = sin(nod);
    rigcal_transform T = {{c, s * e, s * d, 0, d, -e, -s, c * e, c * d}, {0, 0, depth}};

    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            T.t[i] -= T.R[3 * i + j] * at[j];
        }
    }
    return T;
}

static void project(rigcal_real uv[2], const rigcal_transform *cam_from_world,
                    const rigcal_real X[3])
{
    rigcal_real X_c[3];

    rigcal_transform_point(X_c, cam_from_world, X);
    check(rigcal_camera_project(uv, &LENS, X_c));
}

/* ---- a flat target: the sphere of directions, and two poses ------------------------ */

enum { CORNERS = 4, GRID = 60, SEEDS = 24 };

/* A rotation whose third row is the unit ray of the middle of the image of the target. */
static void virtual_axes(rigcal_real V[9], const rigcal_real middle[2])
{
    rigcal_real *const z = &V[6], *const x = V, *const y = &V[3];

    check(rigcal_camera_ray(z, &LENS, middle));
    const rigcal_real across = RC_SQRT(z[0] * z[0] + z[2] * z[2]);
    x[0] = z[2] / across;
    x[1] = 0;
    x[2] = -z[0] / across;
    y[0] = z[1] * x[2] - z[2] * x[1];
    y[1] = z[2] * x[0] - z[0] * x[2];
    y[2] = z[0] * x[1] - z[1] * x[0];
}

static void moments_of(rigcal_moments *sums, const rigcal_real V[9],
                       const rigcal_observation seen[CORNERS])
{
    rc_moments_begin(sums); /* the corners' mean is the origin already */
    for (int i = 0; i < CORNERS; i++) {
        rigcal_real ray[3], v[3] = {0, 0, 0};

        check(rigcal_camera_ray(ray, &LENS, seen[i].uv));
        for (int k = 0; k < 9; k++) {
            v[k / 3] += V[k] * ray[k % 3];
        }
        rc_moments_add(sums, 1, seen[i].X_w, (rigcal_real[2]){v[0] / v[2], v[1] / v[2]});
    }
    stop_if(!rc_moments_finish(sums), "the target has no extent");
}

/* Writes sphere.csv: for both halves of the sphere a square grid over (x, y) of the
 * direction. Outside the circle it has the value at the circle. */
static void write_sphere(const char *folder, const rigcal_moments *sums)
{
    FILE *f = file(folder, "sphere", "half,row,column,cost");

    for (int cell = 0; cell < 2 * (GRID + 1) * (GRID + 1); cell++) {
        const int half = cell / ((GRID + 1) * (GRID + 1));
        const int row = cell / (GRID + 1) % (GRID + 1), column = cell % (GRID + 1);
        double x = 2.1 * column / GRID - 1.05, y = 2.1 * row / GRID - 1.05;
        const double r = sqrt(x * x + y * y);

        if (r > 1) {
            x /= r;
            y /= r;
        }
        const double z = sqrt(fmax(0, 1 - x * x - y * y));
        const rigcal_real m3[3] = {x, y, half == 0 ? -z : z};
        fprintf(f, "%d,%d,%d,%.5g\n", half, row, column, rc_direction_cost(sums, m3));
    }
    done(f);

    f = file(folder, "seeds", "x,y,z,cost");
    for (int i = 0; i < SEEDS; i++) { /* the lattice of rigcal_seeds.c */
        const double z = 1 - (2 * i + 1) / (double)SEEDS, r = sqrt(1 - z * z);
        const double azimuth = i * PI * (3 - sqrt(5.0));
        const rigcal_real m3[3] = {r * cos(azimuth), r * sin(azimuth), z};

        fprintf(f, "%.6f,%.6f,%.6f,%.5g\n", m3[0], m3[1], m3[2],
                rc_direction_cost(sums, m3));
    }
    done(f);
}

static void write_flat(const char *folder)
{
    const double middle[3] = {0, 0, 0};
    const rigcal_transform truth = looking(PI / 180 * 28, PI / 180 * 24, middle, 9);
    const rigcal_real error[CORNERS][2] = {{.4, -.2}, {-.3, .3}, {.2, .4}, {-.2, -.3}};
    rigcal_observation seen[CORNERS] = {
        {{-.5, -.5, 0}, {0}}, {{.5, -.5, 0}, {0}}, {{.5, .5, 0}, {0}}, {{-.5, .5, 0}, {0}}};
    rigcal_view view = {.camera = &LENS, .observations = seen, .n = CORNERS};
    rigcal_real uv_middle[2] = {0, 0}, V[9];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_moments sums;
    size_t n;

    for (int i = 0; i < CORNERS; i++) {
        project(seen[i].uv, &truth, seen[i].X_w);
        for (int k = 0; k < 2; k++) {
            seen[i].uv[k] += error[i][k];
            uv_middle[k] += seen[i].uv[k] / CORNERS;
        }
    }
    check(rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &view, NULL));
    stop_if(n != 2, "the flat target has not two poses");
    virtual_axes(V, uv_middle);
    moments_of(&sums, V, seen);
    write_sphere(folder, &sums);

    FILE *const f =
        file(folder, "optima",
             "pose,corner,rms_px,probability,m_x,m_y,m_z,X,Y,Z,u,v,u_seen,v_seen");
    for (size_t p = 0; p < n; p++) {
        const rigcal_transform *const T = &poses[p].cam_from_world;
        rigcal_real m[3] = {0, 0, 0}; /* the virtual camera's axis, seen from the target */

        for (int k = 0; k < 9; k++) {
            m[k % 3] += T->R[k] * V[6 + k / 3];
        }
        for (int i = 0; i < CORNERS; i++) {
            rigcal_real X_c[3], uv[2];

            rigcal_transform_point(X_c, T, seen[i].X_w);
            project(uv, T, seen[i].X_w);
            fprintf(f,
                    "%d,%d,%.4f,%.4f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.4f,%.4f,%.4f,%.4f\n",
                    (int)p, i, poses[p].rms_px, poses[p].probability, m[0], m[1], m[2],
                    X_c[0], X_c[1], X_c[2], uv[0], uv[1], seen[i].uv[0], seen[i].uv[1]);
        }
    }
    done(f);
}

/* ---- a rig of five cameras: who shares what ---------------------------------------- */

enum { CAMERAS = 5, PLACES = 6, BOARD = 12 };

static const char SEES[PLACES][CAMERAS + 1] = {"11000", "11100", "01100",
                                               "00110", "00110", "00001"};

static void make_board(rigcal_observation seen[BOARD], const rigcal_transform *cam_from_rig,
                       const rigcal_transform *rig_from_board, uint64_t *noise)
{
    for (int i = 0; i < BOARD; i++) {
        const rigcal_real X[3] = {0.15 * (i % 4) - 0.225, 0.15 * (i / 4) - 0.15,
                                  0}; // NOLINT
        rigcal_real X_r[3];

        rigcal_transform_point(X_r, rig_from_board, X);
        project(seen[i].uv, cam_from_rig, X_r);
        for (int k = 0; k < 3; k++) {
            seen[i].X_w[k] = X[k];
        }
        for (int k = 0; k < 2; k++) {
            seen[i].uv[k] += 0.3 * normal(noise);
        }
    }
}

static void write_graph(const char *folder)
{
    static rigcal_observation seen[CAMERAS * PLACES][BOARD];
    static rigcal_real work[RIGCAL_RIG_WORK(CAMERAS, CAMERAS, PLACES)];
    rigcal_rig_view views[CAMERAS * PLACES];
    rigcal_view_pose poses[CAMERAS * PLACES];
    rigcal_transform cams[CAMERAS], boards[PLACES];
    rigcal_link links[RIGCAL_LINKS(CAMERAS)];
    rigcal_advice advice[CAMERAS];
    rigcal_weakest weakest;
    int32_t group[CAMERAS], n_groups, at_fault;
    size_t n_views = 0, n_advice = 0;
    uint64_t noise = 1;
    rigcal_rig_fit fit;

    FILE *const f = file(folder, "views", "camera,placement");
    for (int p = 0; p < PLACES; p++) {
        for (int c = 0; c < CAMERAS; c++) {
            if (SEES[p][c] != '1') {
                continue;
            }
            const double at[3] = {0, 0, 2.5};
            const rigcal_transform cam = looking(0.3 * (c - 2), 0, at, 2.5);
            rigcal_transform board = looking(0.5 * sin(p), 0.4 * cos(2.0 * p), at, 0);
            rigcal_rig_view *const v = &views[n_views];
            rigcal_pose pose;
            size_t n;

            for (int k = 0; k < 3; k++) {
                board.t[k] = at[k];
            }
            make_board(seen[n_views], &cam, &board, &noise);
            *v = (rigcal_rig_view){{&LENS, seen[n_views], NULL, BOARD}, c, p, 0};
            check(rigcal_pose_solve(&pose, 1, &n, NULL, &v->view, NULL));
            check(rigcal_view_pose_make(&poses[n_views], v, &pose.cam_from_world));
            fprintf(f, "%d,%d\n", c, p);
            n_views++;
        }
    }
    done(f);

    rigcal_rig rig = {cams,         CAMERAS,
                      boards,       PLACES,
                      group,        n_views,
                      views,        .view_poses = poses,
                      .work = work, .work_capacity = sizeof work / sizeof work[0]};
    check(rigcal_rig_links(links, RIGCAL_LINKS(CAMERAS), &n_groups, &at_fault, &rig));
    check(rigcal_rig_advise(advice, CAMERAS, &n_advice, links, &rig));
    check(rigcal_rig_join(&rig, &at_fault));
    check(rigcal_rig_adjust(&fit, &at_fault, &rig));
    check(rigcal_rig_weakest(&weakest, &rig, 0.3));

    FILE *const g = file(folder, "links", "kind,a,b,shared,sigma_deg");
    for (int b = 0; b < CAMERAS; b++) {
        fprintf(g, "group,%d,%d,,\n", b, (int)group[b]);
        for (int a = 0; a < b; a++) {
            const rigcal_link *const link = &links[RIGCAL_LINK(a, b)];

            if (link->n_shared > 0) {
                fprintf(g, "link,%d,%d,%d,%.4f\n", a, b, (int)link->n_shared,
                        0.3 * 180 / PI / sqrt(link->information));
            }
        }
    }
    for (size_t i = 0; i < n_advice; i++) {
        fprintf(g, "advice,%d,%d,,\n", (int)advice[i].a, (int)advice[i].b);
    }
    fprintf(g, "weakest,%d,%d,,%.4f\n", (int)weakest.camera, (int)weakest.other,
            180 / PI * weakest.rotation);
    done(g);
}

/* ---- a rig that is bumped ------------------------------------------------------------ */

enum { WATCHED = 3, WATCHED_BOARDS = 10, FRAMES = 360, BUMP = 150, MATCHES = 20, FPS = 15 };
static const double TURNED_DEG = 0.2; /* of camera b, about its vertical */

static rigcal_transform watched(int camera, double turned_deg)
{
    const double at[3] = {0, 0, 3};
    const rigcal_transform T = looking(0.35 * (camera - 1), 0.05 * (camera % 2), at, 3);
    const double c = cos(PI / 180 * turned_deg), s = sin(PI / 180 * turned_deg);
    const rigcal_transform turn = {{c, 0, s, 0, 1, 0, -s, 0, c}, {0, 0, 0}};
    rigcal_transform turned;

    check(rigcal_transform_compose(&turned, &turn, &T));
    return turned;
}

static void write_monitor(const char *folder)
{
    uint64_t random = 3;
    FILE *f = file(folder, "cameras", "camera,width,height,fx,fy,cx,cy");

    for (int c = 0; c < WATCHED; c++) {
        fprintf(f, "%c,640,480,800,800,319.5,239.5\n", 'a' + c);
    }
    done(f);

    f = file(folder, "boards", "frame,camera,point,X,Y,Z,u,v");
    for (int p = 0; p < WATCHED_BOARDS; p++) {
        const double at[3] = {0, 0, 0};
        rigcal_transform board =
            looking(0.6 * random_of(&random), 0.6 * random_of(&random), at, 3);

        for (int k = 0; k < 3; k++) {
            board.t[k] += 0.3 * random_of(&random);
        }
        for (int c = 0; c < WATCHED; c++) {
            const rigcal_transform cam = watched(c, 0);
            rigcal_observation seen[BOARD];

            make_board(seen, &cam, &board, &random);
            for (int i = 0; i < BOARD; i++) {
                fprintf(f, "%02d,%c,%d,%.3f,%.3f,0,%.4f,%.4f\n", p, 'a' + c, i,
                        seen[i].X_w[0], seen[i].X_w[1], seen[i].uv[0], seen[i].uv[1]);
            }
        }
    }
    done(f);

    f = file(folder, "matches", "time_s,camera_a,u_a,v_a,camera_b,u_b,v_b");
    for (int m = 0; m < FRAMES * MATCHES; m++) {
        const double place[3] = {0, 0, 3};
        rigcal_real X[3], uv[2][2];
        const int first = m % WATCHED, pair[2] = {first, (first + 1) % WATCHED};

        for (int k = 0; k < 3; k++) {
            X[k] = place[k] + 0.7 * random_of(&random);
        }
        for (int k = 0; k < 2; k++) {
            const rigcal_transform cam =
                watched(pair[k], (pair[k] == 1 && m / MATCHES >= BUMP) ? TURNED_DEG : 0);

            project(uv[k], &cam, X);
            uv[k][0] += 0.3 * normal(&random);
            uv[k][1] += 0.3 * normal(&random);
        }
        if (m % 20 == 7) { /* one in twenty is wrong */
            uv[1][0] += 30 * random_of(&random);
            uv[1][1] += 30 * random_of(&random);
        }
        fprintf(f, "%.4f,%c,%.4f,%.4f,%c,%.4f,%.4f\n", m / MATCHES / (double)FPS,
                'a' + pair[0], uv[0][0], uv[0][1], 'a' + pair[1], uv[1][0], uv[1][1]);
    }
    done(f);
}

int main(int argc, char *argv[])
{
    stop_if(argc != 2, "usage: rigcal_pictures OUT");
    write_flat(argv[1]);
    write_graph(argv[1]);
    write_monitor(argv[1]);
    return 0;
}
