/* rigcal calibrate: observations to poses, rig, targets and pairs. */
#include "cli_calibrate.h"
#include "cli_covariance.h"

#include <math.h>
#include <string.h>

/* The words for the verdicts, in the order of RIGCAL_VIEW_. */
static const char *const VERDICT[] = {"fits", "contradicts", "one_of_two", "unchecked"};

/* ==== files =============================================================== */

static void write_poses(FILE *file, const calibration *c)
{
    size_t i;

    fprintf(file, "camera,frame,n,%s,rms_px,%s\n", CLI_TRANSFORM_COLUMNS,
            "sigma_rot_deg,sigma_pos,second_rms_px,probability,verdict");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];
        const kept_pose *other = view_second(v);
        const kept_pose *taken = view_taken(v);
        const rigcal_transform cam_from_target = kept_transform(taken);

        fprintf(file, "%s,%s,%lu", c->cameras.names.name[v->camera],
                c->observations.frames.name[v->frame], (unsigned long)v->n);
        cli_write_transform(file, &cam_from_target);
        cli_write_numbers(file, &taken->rms_px, 1);
        cli_write_known(file, v->sigma_deg, v->has_sigma);
        cli_write_known(file, v->sigma_pos, v->has_sigma);
        cli_write_known(file, other ? other->rms_px : 0, other != NULL);
        cli_write_known(file, taken->probability, !v->by_paper);
        fprintf(file, ",%s\n", v->verdict >= 0 ? VERDICT[v->verdict] : "");
    }
}

/* The columns of a rig_sigma, and the end of the line: the lower triangle of the
 * covariance, row by row. */
#define SIGMA_COLUMNS \
    "sigma_rot_deg,sigma_pos,S11,S21,S22,S31,S32,S33,S41,S42,S43,S44,S51,S52," \
    "S53,S54,S55,S61,S62,S63,S64,S65,S66"

static void write_sigma(FILE *file, const rig_sigma *s, int is_known)
{
    int i, j;

    cli_write_known(file, (rigcal_real)s->deg, is_known);
    cli_write_known(file, (rigcal_real)s->position, is_known);
    for (i = 0; i < 6; i++) {
        for (j = 0; j <= i; j++) {
            cli_write_known(file, s->Sigma[6 * i + j], is_known);
        }
    }
}

/* Whether the file has columns for the covariances of camera `earlier` with the cameras of
 * later lines. */
static int has_between(const calibration *c, const rigcal_calibrated_rig *kept,
                       size_t earlier)
{
    size_t i;

    for (i = earlier + 1; i < kept->n_cameras; i++) {
        if (c->in_frame[earlier] && c->in_frame[i] && !kept->held[earlier] &&
            !kept->held[i]) {
            return 1;
        }
    }
    return 0;
}

/* Writes the covariances of a camera with those of earlier lines, and ends the line. */
static void write_between(FILE *file, const calibration *c,
                          const rigcal_calibrated_rig *kept, size_t camera)
{
    rigcal_real Sigma[36] = {0};
    size_t b;
    int k;

    for (b = 0; b < kept->n_cameras; b++) {
        if (has_between(c, kept, b)) {
            const int is_known =
                b < camera && !kept->held[camera] &&
                rigcal_calibrated_covariance(Sigma, kept, camera, b) == RIGCAL_OK;

            for (k = 0; k < 36; k++) {
                cli_write_known(file, Sigma[k], is_known);
            }
        }
    }
    fprintf(file, "\n");
}

static void write_rig_header(FILE *file, const calibration *c,
                             const rigcal_calibrated_rig *kept)
{
    size_t b;
    int k;

    fprintf(file, "camera,%s,%s,sigma_px,noise_px,sqrt_F", CLI_TRANSFORM_COLUMNS,
            SIGMA_COLUMNS);
    for (b = 0; b < kept->n_cameras; b++) {
        for (k = 0; has_between(c, kept, b) && k < 36; k++) {
            fprintf(file, ",%s",
                    cli_covariance_between(k / 6, k % 6, rig_camera_name(c, b)));
        }
    }
    fprintf(file, "\n");
}

static void write_rig(FILE *file, const calibration *c)
{
    const rigcal_calibrated_rig kept = rig_kept(c);
    rig_sigma s;
    size_t i;

    write_rig_header(file, c, &kept);
    for (i = 0; i < c->rig.n_cameras; i++) {
        if (c->in_frame[i]) {
            const int is_known = rig_camera_sigma(&s, c, i);
            const rigcal_real noise = rig_camera_noise(c, i);

            fprintf(file, "%s", rig_camera_name(c, i));
            cli_write_transform(file, &c->rig.cams_from_rig[i]);
            write_sigma(file, &s, is_known);
            cli_write_known(file, noise, noise > 0);
            cli_write_known(file, (rigcal_real)c->noise_px, is_known);
            cli_write_known(file, (rigcal_real)c->root_F, is_known && c->root_F > 0);
            write_between(file, c, &kept, i);
        }
    }
}

/* Sets `kept` to the cameras of rig.csv in the form of rigcal_store_save_rig, with their
 * joint covariance. Returns 0 if the cameras have no common frame or their noise is not
 * known. */
static int take_joint(rigcal_calibrated_rig *kept, const calibration *c)
{
    const size_t n = c->rig.n_cameras;
    size_t i;

    for (i = 0; i < n; i++) {
        if (!c->in_frame[i]) {
            return 0;
        }
    }
    kept->capacity = n;
    kept->Sigma_capacity = RIGCAL_CALIBRATED_SIZE(n);
    kept->cameras = cli_alloc(n, sizeof *kept->cameras);
    kept->group = cli_alloc(n, sizeof *kept->group);
    kept->held = cli_alloc(n, sizeof *kept->held);
    kept->Sigma = cli_alloc(kept->Sigma_capacity, sizeof *kept->Sigma);
    for (i = 0; i < n; i++) {
        kept->cameras[i].camera = c->cameras.camera[c->camera[i]];
    }
    return c->is_adjusted &&
           rigcal_calibrated_take(kept, &c->rig, &c->fit, rig_noise_px(c)) == RIGCAL_OK;
}

static void write_stored(FILE *file, const calibration *c)
{
    const size_t n = c->rig.n_cameras, capacity = rigcal_store_rig_size(n, n);
    uint8_t *bytes = cli_alloc(capacity + 1, 1);
    rigcal_mounted_camera *cameras = cli_alloc(n + 1, sizeof *cameras);
    rigcal_calibrated_rig kept;
    size_t i, count = 0, n_bytes = 0;

    memset(&kept, 0, sizeof kept);
    if (take_joint(&kept, c)) {
        rigcal_store_save_rig(bytes, capacity, &n_bytes, &kept, 1, 0);
    } else {
        for (i = 0; i < n; i++) {
            rigcal_mounted_camera *m = &cameras[count];

            m->camera = c->cameras.camera[c->camera[i]];
            m->cam_from_rig = c->rig.cams_from_rig[i];
            count += c->in_frame[i] != 0;
        }
        rigcal_store_save(bytes, capacity, &n_bytes, cameras, count, 1, 0);
    }
    fwrite(bytes, 1, n_bytes, file);
}

static void write_targets(FILE *file, const calibration *c)
{
    size_t frame;

    fprintf(file, "frame,%s\n", CLI_TRANSFORM_COLUMNS);
    for (frame = 0; frame < c->observations.frames.count; frame++) {
        const size_t placement = c->placement_of[frame];

        if (c->placed[placement]) {
            fprintf(file, "%s", c->observations.frames.name[frame]);
            cli_write_transform(file, &c->rig.rig_from_placements[placement]);
            fprintf(file, "\n");
        }
    }
}

static void write_pairs(FILE *file, const calibration *c)
{
    rigcal_transform b_from_a;
    rig_sigma s;
    size_t a, b;

    fprintf(file, "camera_a,camera_b,%s,%s\n", CLI_TRANSFORM_COLUMNS, SIGMA_COLUMNS);
    for (a = 0; a < c->rig.n_cameras; a++) {
        for (b = a + 1; b < c->rig.n_cameras; b++) {
            if (c->in_frame[a] && c->rig.group[a] == c->rig.group[b]) {
                const int is_known = rig_pair(&b_from_a, &s, c, a, b);

                fprintf(file, "%s,%s", rig_camera_name(c, a), rig_camera_name(c, b));
                cli_write_transform(file, &b_from_a);
                write_sigma(file, &s, is_known);
                fprintf(file, "\n");
            }
        }
    }
}

/* Writes each point as it was given, and its residual: observed minus projected by the
 * rig. */
static void write_residuals(FILE *file, const calibration *c)
{
    size_t i, k;

    fprintf(file,
            "camera,frame,point,X,Y,Z,observed_u,observed_v,du,dv,error_px,left_out\n");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];
        view_residuals of = residuals_in_rig(c, v);

        for (k = 0; k < v->n_seen; k++) {
            const residual r = next_residual(&of, c, k);

            fprintf(file, "%s,%s,%s", c->cameras.names.name[v->camera],
                    c->observations.frames.name[v->frame], view_point_name(c, v, k));
            cli_write_numbers(file, cli_X(&c->observations, &v->first[k]), 3);
            cli_write_numbers(file, v->first[k].uv, 2);
            cli_write_known(file, r.duv[0], r.is_known);
            cli_write_known(file, r.duv[1], r.is_known);
            cli_write_known(file, r.error_px, r.is_known);
            fprintf(file, ",%d\n", v->is_left_out || view_leaves_out(v, k));
        }
    }
}

static void write_files(const calibration *c, const char *folder)
{
    cli_output *output = cli_output_begin(folder);

    cli_progress(c->n_views, "writing %s", folder);
    write_poses(cli_output_file(output, "poses.csv"), c);
    write_rig(cli_output_file(output, "rig.csv"), c);
    write_stored(cli_output_file(output, "rig.bin"), c);
    write_targets(cli_output_file(output, "targets.csv"), c);
    write_pairs(cli_output_file(output, "pairs.csv"), c);
    write_residuals(cli_output_file(output, "residuals.csv"), c);
    write_summary(cli_output_file(output, "summary.json"), c);
    if (c->is_tested) {
        write_faults(cli_output_file(output, "faults.csv"), c);
    }
    if (c->estimated.change != NULL) {
        write_cameras(cli_output_file(output, "cameras.csv"), c);
    }
    if (c->times.path != NULL && c->is_adjusted) {
        write_clocks(cli_output_file(output, "clocks.csv"), c);
    }
    cli_output_finish(output);
    cli_progress_end();
}

/* ==== the command ========================================================= */

/* Returns 1 for the published procedure, 0 for maximum likelihood. */
static int choose_method(const char *text)
{
    const int by_paper = text != NULL && strcmp(text, "paper") == 0;

    if (text != NULL && !by_paper && strcmp(text, "ml") != 0) {
        cli_fail("--method is ml or paper, not \"%s\"", text);
    }
    return by_paper;
}

static uint32_t choose_seed(const char *text)
{
    double seed;

    cli_numbers(&seed, 1, "--seed", text);
    if (!(seed >= 0 && seed <= UINT32_MAX && floor(seed) >= seed)) {
        cli_fail("--seed is a whole number from 0 to %lu, not \"%s\"",
                 (unsigned long)UINT32_MAX, text);
    }
    return (uint32_t)seed;
}

static void check_method(const calibration *c, const char *const option[OPTION_COUNT])
{
    if (c->by_paper && option[OPTION_ROBUST] != NULL) {
        cli_fail("--robust does not go with --method paper: leave one out");
    }
    if (c->by_paper && option[OPTION_WEIGH] != NULL) {
        cli_fail("--weigh does not go with --method paper, in which all points count "
                 "alike: leave one out");
    }
    if (c->by_paper && option[OPTION_SIGMA] != NULL) {
        cli_fail("--sigma does not go with --method paper, which knows no noise: "
                 "leave one out");
    }
    if (c->by_paper && (option[OPTION_HOLD] != NULL || option[OPTION_PRIOR] != NULL)) {
        cli_fail("--hold and --prior do not go with --method paper: leave one out");
    }
    if (c->by_paper &&
        (option[OPTION_TIMES] != NULL || option[OPTION_INTRINSICS_SIGMA] != NULL)) {
        cli_fail("--times and --intrinsics-sigma do not go with --method paper, which has "
                 "no adjustment: leave one out");
    }
    if (option[OPTION_ROBUST] == NULL &&
        (option[OPTION_THRESHOLD] != NULL || option[OPTION_SEED] != NULL)) {
        cli_fail("--threshold and --seed go with --robust: give it too");
    }
}

static void choose(calibration *c, const char *const option[OPTION_COUNT])
{
    c->by_paper = choose_method(option[OPTION_METHOD]);
    c->is_robust = option[OPTION_ROBUST] != NULL;
    c->is_weighing = option[OPTION_WEIGH] != NULL;
    check_method(c, option);
    rigcal_pose_defaults(&c->pose);
    rigcal_robust_defaults(&c->robust);
    if (option[OPTION_SIGMA] != NULL) {
        c->pose.sigma_px = (rigcal_real)cli_sigma(option[OPTION_SIGMA]);
        c->robust.sigma_px = c->pose.sigma_px;
    }
    if (option[OPTION_THRESHOLD] != NULL) {
        c->robust.threshold_px =
            (rigcal_real)cli_pixels("--threshold", option[OPTION_THRESHOLD], 1e-3);
    }
    if (option[OPTION_SEED] != NULL) {
        c->robust.seed = choose_seed(option[OPTION_SEED]);
    }
    if (option[OPTION_INTRINSICS_SIGMA] != NULL) {
        c->intrinsics = choose_intrinsics_sigma(option[OPTION_INTRINSICS_SIGMA]);
        c->has_intrinsics = 1;
    }
    c->is_estimating = option[OPTION_ESTIMATE_INTRINSICS] != NULL;
    if (c->is_estimating && !c->has_intrinsics) {
        cli_fail("--estimate-intrinsics goes with --intrinsics-sigma: what is known of the "
                 "intrinsics holds them");
    }
    if (c->is_estimating && option[OPTION_TIMES] != NULL) {
        cli_fail("--estimate-intrinsics does not go with --times: leave one out");
    }
}

int cli_calibrate(const char *const option[OPTION_COUNT])
{
    const char *folder = option[OPTION_OUT];
    calibration c;

    memset(&c, 0, sizeof c);
    if (option[OPTION_PROGRESS] != NULL) {
        cli_progress_lines();
    }
    choose(&c, option);
    cli_cameras_read(&c.cameras, option[OPTION_CAMERAS]);
    read_known(&c.known, &c.cameras, option[OPTION_PRIOR], option[OPTION_HOLD],
               option[OPTION_SIGMA] != NULL);
    cli_observations_read(&c.observations, option[OPTION_OBSERVATIONS], &c.cameras,
                          CLI_TARGETS | (c.is_weighing ? CLI_SIGMAS : 0));
    read_times(&c.times, &c.observations, &c.cameras, option);
    cli_observations_by_view(&c.observations);
    cli_names_close(&c.observations.frames);
    cli_hold();
    solve_views(&c);
    turn_views(&c);
    name_left_out(&c, folder);
    find_duplicates(&c);
    find_suspects(&c);
    form_rig(&c);
    tell_findings(&c);
    if (c.n_views == 0) {
        cli_say("no view has a pose, so there is nothing to print%s",
                folder != NULL ? " and nothing to write" : "");
        return c.exit_status;
    }
    print_summary(&c);
    if (folder != NULL) {
        cli_flush_stdout("; no file was written");
        write_files(&c, folder);
    }
    return c.exit_status;
}
