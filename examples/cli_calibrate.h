/* cli_calibrate.h - what the parts of rigcal calibrate share: every camera's pose in every
 * frame (cli_solve.c), targets that look the same from several sides (cli_turned.c,
 * cli_symmetry.c), the rig that they form (cli_rig.c), which views are wrong
 * (cli_judge.c) and why (cli_causes.c, cli_suspects.c), its intrinsics (cli_estimate.c),
 * what is known of its cameras beforehand (cli_prior.c), what a person reads of it
 * (cli_findings.c, cli_report.c, cli_graph.c), and options and files (cli_calibrate.c). */
#ifndef RIGCAL_CLI_CALIBRATE_H
#define RIGCAL_CLI_CALIBRATE_H

#include "cli.h"
#include "rigcal_paper.h"

#define DEGREE 57.295779513082320877

/* What became of a point: --robust left it out; it counts; its pixel has no ray. */
enum { POINT_DISAGREES = 0, POINT_COUNTS = 1, POINT_UNSEEN = 2 };

/* One camera in one frame. */
typedef struct {
    size_t camera, frame; /* numbers of their names */
    const cli_observation *first;
    size_t n_seen;
    uint8_t *agree;       /* of each seen: POINT_; NULL: all count */
    size_t n_unseen;      /* left out because the lens images no ray there */
    size_t n;             /* those that count */
    int by_paper;         /* by the published procedure: one pose, no sigma */
    rigcal_status status; /* OK or a caveat */
    rigcal_pose poses[RIGCAL_POSES_MAX]; /* best first */
    size_t n_poses, taken;
    int settled;          /* other frames told which one */
    rigcal_real distance; /* from the camera to the middle of the points */
    int has_sigma;
    rigcal_real sigma_deg, sigma_pos; /* of the rotation; of the centre */
    size_t rig_camera;
    size_t placement; /* of the rig: that of its frame, unless frames are paired anew */
    int in_rig;       /* its points count in the rig */
    size_t rig_view;  /* of the rig, which view it is; where in_rig */
    int is_left_out;  /* it contradicts others, and does not */
    int is_told;      /* why has been told */
    int is_repeated;  /* another frame has the same pixels */
    int verdict;      /* RIGCAL_VIEW_, or -1: it was not judged */
} view;

/* What is wrong, and what to do. The first rank is told first. */
typedef enum { ABOUT_RIG, ABOUT_CAMERA, ABOUT_VIEW } finding_rank;
typedef struct {
    finding_rank rank;
    size_t number;
    const view *v; /* that it is about, or NULL */
    const char *what, *advice;
    const char *cameras, *frames; /* that it is about, with commas between; or NULL */
    int is_said;                  /* in other words, or at another place */
} finding;

/* What is known beforehand of each camera of cameras.csv. */
typedef struct {
    const char *path; /* of --prior, or NULL */
    uint8_t *role;    /* RIGCAL_CAMERA_ */
    rigcal_camera_prior *prior;
    size_t n_held, n_prior; /* of --hold; of those with a covariance */
} known_cameras;

void read_known(known_cameras *known, const cli_cameras *cameras, const char *prior,
                const char *hold, int has_sigma);

/* The time of a picture; the line of the file that says so. */
typedef struct {
    size_t camera, frame;
    double time;
    size_t line;
} stamp;

/* What is known of times. Frames are numbered in the order of theirs. */
typedef struct {
    const char *path; /* of --times, or NULL */
    int is_frames;    /* --times frames: the unit is one frame, else 1 s */
    int is_free, has_drift;
    double sigma;     /* of a stamp by itself; 0: none */
    double *of_frame; /* the middle one of its views' */
    stamp *stamps;    /* of each view, by camera and frame */
    size_t n_stamps;
} known_times;

void read_times(known_times *times, cli_observations *observations,
                const cli_cameras *cameras, const char *const option[OPTION_COUNT]);
double time_of_view(const known_times *times, size_t camera, size_t frame);
rigcal_intrinsics_sigma choose_intrinsics_sigma(const char *text);

/* The rig's cameras are those with a view; they are numbered anew for it. */
typedef struct {
    cli_cameras cameras;
    cli_observations observations;
    int by_paper; /* --method paper */
    int is_robust;
    int is_weighing;          /* --weigh: points count by column sigma_px */
    rigcal_pose_options pose; /* of --method ml */
    rigcal_robust_options robust;
    int exit_status;

    rigcal_observation *observed; /* work for one view: the points that count */
    rigcal_real *observed_sigma;  /* of each; NULL: all alike */
    size_t *observed_at;          /* and which of the view's each is */
    rigcal_bearing *bearings;
    rigcal_pair *pairs;
    size_t n_pairs;

    view *views; /* those solved, by camera and frame */
    size_t n_views;
    size_t n_bad_fits; /* views whose points do not fit their pose */

    known_cameras known;
    known_times times;
    int has_intrinsics; /* --intrinsics-sigma */
    rigcal_intrinsics_sigma intrinsics;
    size_t *camera;       /* of the rig's camera, the number of its name */
    size_t main_camera;   /* of the rig: the first that is fixed, else the first */
    int *in_frame;        /* whether the rig's camera has a pose in the main one's frame */
    rigcal_rig rig;       /* its views are sorted by placement; placements are frames, and
                           after frames have been paired anew some without one */
    size_t *placement_of; /* of a frame */
    int32_t *paired_by; /* of the rig's camera: its pictures belong so many frames later */
    size_t n_paired;    /* how often frames have been paired anew */
    rigcal_rig_clocks clocks;
    double *placement_time;
    size_t *view_of; /* of the rig's view, the number of ours */
    int *placed;     /* by placement: whether it has a place in the main camera's frame */

    rigcal_view_pose *second_poses; /* of the rig's views */
    rigcal_choice choice;
    rigcal_judgement judgement;
    rigcal_judged_view *judged; /* of the rig's views */
    size_t n_left_out;          /* views */
    finding *findings;
    size_t n_findings, room_for_findings;
    int sigma_is_told;   /* --sigma is too small for most views */
    int *camera_is_told; /* by camera: what is wrong with its views has been told */

    int is_adjusted; /* else the views' poses are joined, and what follows is not known */
    rigcal_rig_fit fit;
    rigcal_real
        *sigma_px;     /* of each of the rig's cameras, by its own residuals; 0: unknown */
    double own_rms_px; /* of the views by themselves, per point */
    double noise_px;   /* that the rig's sigmas are for, before ... */
    double root_F, factor; /* ... they are multiplied by factor: 1 at least */

    int is_explained; /* by a fault: then no view is wrong */
    int is_tested;    /* for faults of the rig as a whole: */
    rigcal_faults verdict;
    rigcal_fault *faults; /* verdict.n */
    rigcal_considered considered;
    int is_estimating;          /* --estimate-intrinsics */
    rigcal_estimated estimated; /* of change NULL: they are not */
} calibration;

/* The pose taken, and the best of those not taken, or NULL. */
const rigcal_pose *view_taken(const view *v);
const rigcal_pose *view_second(const view *v);

/* The views of a camera, by frame: *first up to the one that is returned. */
const view *views_of(const view **first, const calibration *c, size_t camera);

/* What the library is given of the view: the points that count. They hold until the next
 * call. */
rigcal_view view_points(const calibration *c, const view *v);

/* Takes one of the view's poses, and measures what follows from it. */
void view_take(const calibration *c, view *v, size_t pose);

/* Of the view's point k, 0 <= k < n_seen: its name; whether it is left out; whether
 * --robust left it out;
 * what is observed less where the pose taken puts it. view_residual returns 0, and
 * writes zeros, where the camera cannot see it with that pose. pose_residual: the same
 * of any pose. */
typedef struct {
    rigcal_real duv[2], error_px;
    int is_known; /* of view_residuals_in_rig */
} residual;
const char *view_point_name(const calibration *c, const view *v, size_t k);
int view_leaves_out(const view *v, size_t k);
int view_disagrees(const view *v, size_t k);
int view_residual(residual *r, const calibration *c, const view *v, size_t k);

int pose_residual(residual *r, const calibration *c, const view *v, size_t k,
                  const rigcal_transform *cam_from_target);

/* The rig's camera; the frame that the rig's poses are in. */
const char *rig_camera_name(const calibration *c, size_t rig_camera);
const char *rig_frame_name(const calibration *c);

/* Where the rig puts the target for the camera. Of a view that is not in the rig: the
 * pose taken. */
rigcal_transform view_in_rig(const calibration *c, const view *v);

/* What is observed less where the rig puts it, of each point of the view: NULL where it is
 * not known. Points that do not count are left by the placement as it is at its instant. It
 * holds until the next call. */
const residual *view_residuals_in_rig(const calibration *c, const view *v);

/* Covariance of (w, dt) of a pose, and the standard deviations of its rotation and of the
 * camera's centre. */
typedef struct {
    rigcal_real Sigma[36];
    double deg, position;
} rig_sigma;

/* The noise of a pixel that the rig's covariances are for; 0: it is not known. find_noise
 * finds it, of a rig that has been adjusted. */
void find_noise(calibration *c);
rigcal_real rig_noise_px(const calibration *c);

/* Of a camera of the rig; of b_from_a of two of one group. They return 0 if no sigma is
 * known. */
int rig_camera_sigma(rig_sigma *s, const calibration *c, size_t rig_camera);
int rig_pair(rigcal_transform *b_from_a, rig_sigma *s, const calibration *c, size_t a,
             size_t b);

/* Noise of a camera's pixels, for what is measured with it: by its own residuals in the
 * rig; 0: not known. */
rigcal_real rig_camera_noise(const calibration *c, size_t rig_camera);

/* The rig with the joint covariance of its cameras; of none, if no sigma is known. */
rigcal_calibrated_rig rig_kept(const calibration *c);

/* Notes what is wrong, and sets the exit status; all are told by tell_findings, before the
 * messages that were held. What is returned holds until the next. */
finding *find(calibration *c, finding_rank rank, const char *what, const char *advice);
void tell_findings(calibration *c);
int is_finding_told(const calibration *c, const finding *f);

/* Says why a view has no pose, or is not in the rig, and keeps it for summary.json. The
 * exit status is as it was. */
void say_of_view(calibration *c, const view *v, const char *what);

/* The name of a view's camera; of its frame. */
const char *view_camera_name(const calibration *c, const view *v);
const char *view_frame_name(const calibration *c, const view *v);

/* Which pose each view has, which views are wrong, and the rig of the others. Returns 0
 * where there is none; RIG_PAIRED_ANEW: views have other placements, judge it again. */
enum { RIG_PAIRED_ANEW = 2 };
int judge_rig(calibration *c);
void name_rig_trouble(calibration *c, const char *what, rigcal_status status,
                      int32_t at_fault);

/* Turns of a flat target in its plane, and mirrored turns, that map its points onto each
 * other. What is found
 * holds until the next call. */
enum { SYMMETRIES_MOST = 16 };
typedef struct {
    rigcal_symmetries of;
    double deg[SYMMETRIES_MOST];
    int is_mirrored[SYMMETRIES_MOST];
} symmetries;
const symmetries *symmetries_of(const rigcal_view *seen);

/* "a, b and c", of at most some ten. */
const char *names_joined(const char *const names[], size_t n, const char *last);

/* "a,b,c", all of them. */
const char *names_with_commas(const char *const names[], size_t n);

/* Of c->judged: which views count, and which pose each has. */
void note_verdicts(calibration *c);

/* The name of the frame of a placement; "" if it has none. */
const char *name_of_placement(const calibration *c, size_t placement);

/* Gives the rig the times of its views. Of a rig whose poses have been chosen: adjusts it
 * with all views, and tests it for faults. Returns 1 where one of them explains why views
 * disagree, so that none of them is wrong; 2 where frames must be paired anew, and have
 * been; else 0. */
enum { TEST_TELLS_NOTHING, TEST_EXPLAINS, TEST_PAIRS_ANEW };
void give_times(calibration *c);
int test_all_views(calibration *c);
void test_rig(calibration *c); /* the adjusted rig */
void consider_intrinsics(calibration *c);
int estimate_intrinsics(calibration *c); /* 0: they are as they were */
void print_estimated(const calibration *c);
void write_cameras(FILE *file, const calibration *c);
const char *verdict_text(const calibration *c); /* NULL: there is none */
void print_verdict(const calibration *c);
void print_clocks(const calibration *c);
void write_faults(FILE *file, const calibration *c);
void write_clocks(FILE *file, const calibration *c);

/* Why views are left out; why there is no rig; what is suspect before. */
void find_causes(calibration *c);
void find_contradiction(calibration *c);
void find_suspects(calibration *c);
void find_groups(calibration *c);
void find_point(calibration *c, const view *v, const rigcal_blame *blame);
void find_duplicates(calibration *c);

/* Noise of a camera of cameras.csv by its views' own fits, the middle of them; 0: too few
 * tell anything. */
double camera_noise(const calibration *c, size_t camera);

/* In this order. All say what they cannot do, and set the exit status. `folder`: of
 * the files, or NULL. */
void solve_views(calibration *c);
void turn_views(calibration *c); /* of targets that look the same from several sides */
void name_left_out(const calibration *c, const char *folder);
void form_rig(calibration *c);
void print_summary(const calibration *c); /* of a view at least */
void print_graph(const calibration *c);
int find_weakest(rigcal_weakest *weakest, const calibration *c);
const char *next_text(const calibration *c, const rigcal_weakest *weakest);
void write_summary(FILE *file, const calibration *c);
int *cameras_that_count(const calibration *c); /* of the rig: those with a view in it */
int widest(const cli_names *names);
void print_rig_sigma(const rig_sigma *s, int is_known);

double length_of(const rigcal_real x[3]);

#endif
