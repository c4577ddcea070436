/* cli_calibrate.h - what the parts of rigcal calibrate share: every camera's pose in every
 * frame (cli_solve.c), targets that look the same from several sides (cli_turned.c,
 * cli_symmetry.c), the rig that they form (cli_rig.c), which views are wrong
 * (cli_judge.c) and why (cli_causes.c, cli_part.c, cli_suspects.c), its intrinsics
 * (cli_estimate.c), what is known of its cameras beforehand (cli_prior.c), what a person
 * reads of it (cli_findings.c, cli_report.c, cli_graph.c), and options and files
 * (cli_calibrate.c). */
#ifndef RIGCAL_CLI_CALIBRATE_H
#define RIGCAL_CLI_CALIBRATE_H

#include "cli.h"
#include "rigcal_paper.h"

#define DEGREE 57.295779513082320877

/* What became of a point: --robust left it out; it counts; the lens images no ray at its
 * pixel. */
enum { POINT_DISAGREES = 0, POINT_COUNTS = 1, POINT_UNSEEN = 2 };

/* Poses of a view that are kept: the one that is taken, and the best of the others. A
 * rotation is kept as a quaternion, because this takes 4 numbers and a matrix 9. */
enum { POSES_KEPT = 2 };
typedef struct {
    rigcal_real q_wxyz[4], t[3];
    rigcal_real rms_px, probability; /* as in rigcal_pose */
} kept_pose;

/* One camera in one frame. There may be a million of them, so the numbers are as small as
 * possible. */
typedef struct {
    const cli_observation *first;
    uint8_t *agree;         /* of each point: POINT_; NULL: all count */
    kept_pose *poses;       /* best first */
    uint32_t camera, frame; /* numbers of their names */
    uint32_t n_seen;
    uint32_t n_unseen; /* points left out because the lens images no ray there */
    uint32_t n;        /* points that count */
    uint32_t rig_camera;
    uint32_t placement;   /* number in the rig: that of its frame, unless frames were paired
                             anew */
    uint32_t rig_view;    /* number of the view in the rig, if in_rig */
    rigcal_real distance; /* from the camera to the middle of the points */
    rigcal_real sigma_deg, sigma_pos; /* standard deviations of the rotation and of the
                                         camera's centre */
    rigcal_status status;             /* OK, or the caveat of the pose */
    uint8_t n_poses, taken;
    uint8_t by_paper; /* by the published procedure: one pose, no sigma */
    uint8_t settled;  /* other frames decided which pose is right */
    uint8_t has_sigma;
    uint8_t has_information; /* whether that of the best pose has been kept */
    uint8_t in_rig;          /* whether its points count in the rig */
    uint8_t is_left_out;     /* whether it contradicts other views and does not count */
    uint8_t is_told;         /* whether the user has been told why */
    uint8_t is_repeated;     /* whether another frame has the same pixels */
    int8_t verdict;          /* RIGCAL_VIEW_; -1: the view was not judged */
} view;

/* The points of one view that count, in the form of the library. There are two of these,
 * because a pose of a view may be asked for while the points of another one are in use. */
typedef struct {
    rigcal_observation *list;
    rigcal_real *sigma; /* relative sigma of each; NULL: all alike */
    size_t room;
    size_t of; /* if the rig was given them: 1 + the number of the view; else 0 */
} gathered_points;

/* What is wrong, and what to do. Findings of the first rank are printed first. */
typedef enum { ABOUT_RIG, ABOUT_CAMERA, ABOUT_VIEW } finding_rank;
typedef struct {
    finding_rank rank;
    size_t number;
    const view *v; /* the view that it is about, or NULL */
    const char *what, *advice;
    const char *cameras, *frames; /* names of the cameras and frames that it is about,
                                     separated by commas; or NULL */
} finding;

/* Why a view has no pose, is not in the rig, or is doubtful, in few bytes: it may be said
 * of every line of the file. */
typedef enum {
    TROUBLE_TOO_FEW,
    TROUBLE_POINT, /* no pose because of one point */
    TROUBLE_NO_POSE,
    TROUBLE_CAVEAT,
    TROUBLE_LEFT_OUT, /* not in the rig */
} trouble_kind;
typedef struct {
    rigcal_real rms_px;
    uint32_t number; /* in the order of findings and troubles together */
    uint32_t camera, frame;
    uint32_t n; /* number of points; of TROUBLE_POINT: the number of its name */
    int16_t status;
    uint8_t kind;
} view_trouble;

/* What is known beforehand of each camera of cameras.csv. */
typedef struct {
    const char *path; /* path of --prior, or NULL */
    cli_transforms file;
    size_t *line;  /* in that file; of cameras with a covariance */
    uint8_t *role; /* RIGCAL_CAMERA_ */
    rigcal_camera_prior *prior;
    size_t n_held, n_prior; /* numbers of cameras of --hold, and of cameras with a
                               covariance */
} known_cameras;

void read_known(known_cameras *known, const cli_cameras *cameras, const char *prior,
                const char *hold, int has_sigma);

/* The time of a picture, and the line of the file that has it. */
typedef struct {
    size_t camera, frame;
    double time;
    size_t line;
} stamp;

/* What is known of times. Frames are numbered in the order of their times. */
typedef struct {
    const char *path; /* path of --times, or NULL */
    int is_frames;    /* --times frames: the unit is one frame, else 1 s */
    int is_free, has_drift;
    double sigma;     /* noise of a single stamp; 0: none */
    double *of_frame; /* of each frame: the median time of its views */
    stamp *stamps;    /* of each view, by camera and frame */
    size_t n_stamps;
} known_times;

void read_times(known_times *times, cli_observations *observations,
                const cli_cameras *cameras, const char *const option[OPTION_COUNT]);
double time_of_view(const known_times *times, size_t camera, size_t frame);
rigcal_intrinsics_sigma choose_intrinsics_sigma(const char *text);

/* The rig's cameras are the cameras that have a view, numbered anew. */
typedef struct {
    cli_cameras cameras;
    cli_observations observations;
    int by_paper; /* --method paper */
    int is_robust;
    int is_weighing;          /* --weigh: points count by column sigma_px */
    rigcal_pose_options pose; /* options of --method ml */
    rigcal_robust_options robust;
    int exit_status;

    gathered_points *gathered, *aside; /* work for one view */
    rigcal_pose *found;                /* RIGCAL_POSES_MAX */
    uint8_t *agree;
    rigcal_pair *pairs;
    size_t n_pairs;

    view *views; /* the solved views, by camera and frame */
    size_t n_views;
    size_t n_bad_fits; /* views whose points do not fit their pose */

    known_cameras known;
    known_times times;
    int has_intrinsics; /* --intrinsics-sigma */
    rigcal_intrinsics_sigma intrinsics;
    size_t *camera;     /* for each camera of the rig: the number of its name */
    size_t main_camera; /* camera of the rig whose frame is the rig's: the first that is
                             fixed, or else the first */
    int *in_frame;      /* for each camera of the rig: whether it has a pose in the main
                             camera's frame */
    rigcal_rig rig;     /* Its views are sorted by placement. Placements are frames. After
                           frames were paired anew, some placements have no frame. */
    uint32_t *placement_of; /* for each frame: its placement */
    int32_t *paired_by; /* for each camera of the rig: how many frames later its pictures
                           belong */
    size_t n_paired;    /* how often frames were paired anew */
    rigcal_rig_clocks clocks;
    double *placement_time;
    uint32_t *view_of; /* for each view of the rig: its number in `views` */
    uint8_t *placed;   /* for each placement: whether it has a pose in the main camera's
                        frame */

    rigcal_choice choice;
    rigcal_judgement judgement;
    rigcal_judged_view *judged; /* of the views of the rig */
    size_t n_left_out;          /* views */
    finding *findings;
    size_t n_findings, room_for_findings;
    view_trouble *troubles;
    size_t n_troubles, room_for_troubles;
    int sigma_is_told;   /* whether the user was told that --sigma is too small for most
                            views */
    int *camera_is_told; /* for each camera: whether the user was told what is wrong with
                            its views */

    int is_adjusted; /* 1: the rig was adjusted. 0: the poses of the views were only joined,
                        and what follows here is not known. */
    rigcal_rig_fit fit;
    rigcal_real *sigma_px; /* for each camera of the rig: the noise of a pixel by its own
                          residuals; 0: unknown */
    double own_rms_px;     /* rms of the views at their own poses, per point */
    double noise_px; /* noise that the sigmas of the rig are computed for, before ... */
    double root_F, factor; /* ... they are multiplied by factor: root_F without what
                              intrinsics that are considered add to it; 1 at least */

    int is_explained; /* whether a fault explains the disagreement: then no view is wrong */
    int is_tested;    /* whether faults of the rig as a whole were tested: */
    rigcal_faults verdict;
    rigcal_fault *faults; /* verdict.n */
    rigcal_considered considered;
    int is_estimating;          /* --estimate-intrinsics */
    rigcal_estimated estimated; /* its member `change` is NULL: intrinsics are not
                                   estimated */
} calibration;

/* View `index` of the rig. */
view *rig_view(const calibration *c, size_t index);

/* The pose that was taken. The best pose of those not taken, or NULL. */
const kept_pose *view_taken(const view *v);
const kept_pose *view_second(const view *v);
rigcal_transform kept_transform(const kept_pose *kept);
void keep_transform(kept_pose *kept, const rigcal_transform *cam_from_target);

/* The views of a camera, in the order of frames: from *first to just before the one that is
 * returned. */
const view *views_of(const view **first, const calibration *c, size_t camera);

/* The view that the library gets: the points that count. It is valid until the next
 * call. */
rigcal_view view_points(const calibration *c, const view *v);

/* Makes the library's form of pose number `which` of the view, with its information. If
 * there is no such pose, it gets n = 0, and the status is not OK. */
rigcal_status make_pose(rigcal_view_pose *pose, const calibration *c, view *v,
                        size_t which);

/* The sources of the rig's views, of their best poses, and of their second poses. The
 * context is the calibration. */
rigcal_status view_at(rigcal_rig_view *seen, size_t index, void *context);
rigcal_status pose_at(rigcal_view_pose *pose, size_t index, void *context);
rigcal_status second_pose_at(rigcal_view_pose *pose, size_t index, void *context);

/* The pose by which the library joins a view of the rig. */
rigcal_view_pose pose_in_rig(const calibration *c, size_t index);

/* Takes one of the view's poses, and computes what follows from it. */
void view_take(const calibration *c, view *v, size_t pose);

/* About the view's point k, 0 <= k < n_seen: its name; whether it is left out; whether
 * --robust left it out; its residual, observed minus projected by the pose taken.
 * view_residual returns 0 and writes zeros if the camera cannot see the point with that
 * pose. pose_residual does the same for any pose. */
typedef struct {
    rigcal_real duv[2], error_px;
    int is_known; /* only from next_residual */
} residual;
const char *view_point_name(const calibration *c, const view *v, size_t k);
int view_leaves_out(const view *v, size_t k);
int view_disagrees(const view *v, size_t k);
int view_residual(residual *r, const calibration *c, const view *v, size_t k);

int pose_residual(residual *r, const calibration *c, const view *v, size_t k,
                  const rigcal_transform *cam_from_target);

/* The name of a camera of the rig. The name of the camera whose frame the rig's poses are
 * in. */
const char *rig_camera_name(const calibration *c, size_t rig_camera);
const char *rig_frame_name(const calibration *c);

/* Where the rig puts the target for the camera. If the view is not in the rig: the pose
 * taken. */
rigcal_transform view_in_rig(const calibration *c, const view *v);

/* The residual of each point of the view: observed minus projected by the rig. With clocks,
 * the target is where it was at the time of the view; for points that do not count, where
 * it was at the instant of the placement. Ask for one view at a time, and for its points in
 * their order. Points that do not count may be skipped. */
typedef struct {
    const view *v;
    rigcal_transform pose;
    const rigcal_real *duv; /* with clocks: of the points that count; else NULL */
    size_t n_counted;       /* of these, the number that were asked for */
    int is_known;
} view_residuals;
view_residuals residuals_in_rig(const calibration *c, const view *v);
residual next_residual(view_residuals *of, const calibration *c, size_t k);

/* Covariance of (w, dt) of a pose, and the standard deviations of its rotation and of the
 * camera's centre. */
typedef struct {
    rigcal_real Sigma[36];
    double deg, position;
} rig_sigma;

/* The noise of a pixel that the covariances of the rig are computed for; 0: it is not
 * known. find_noise finds it after the adjustment of the rig. */
void find_noise(calibration *c);
rigcal_real rig_noise_px(const calibration *c);

/* Sigma of a camera of the rig. Sigma of b_from_a for two cameras of one group. Both return
 * 0 if no sigma is known. */
int rig_camera_sigma(rig_sigma *s, const calibration *c, size_t rig_camera);
int rig_pair(rigcal_transform *b_from_a, rig_sigma *s, const calibration *c, size_t a,
             size_t b);

/* The noise of a camera's pixels, for measurements with that camera: by its own residuals
 * in the rig. 0: not known. */
rigcal_real rig_camera_noise(const calibration *c, size_t rig_camera);

/* The rig with the joint covariance of its cameras. It has no cameras if no sigma is
 * known. */
rigcal_calibrated_rig rig_kept(const calibration *c);

/* Notes what is wrong, and sets the exit status. tell_findings prints all findings, before
 * the messages that were held. The result is valid until the next call. */
finding *find(calibration *c, finding_rank rank, const char *what, const char *advice);
void tell_findings(calibration *c);
int is_finding_told(const calibration *c, const finding *f);

/* Says why a view has no pose, or is not in the rig, and keeps the reason for summary.json.
 * Does not change the exit status. point: number of its name, for TROUBLE_POINT.
 */
void say_of_view(calibration *c, const view *v, trouble_kind kind, rigcal_status status,
                 size_t point);

/* The text of it, in memory of cli_alloc. */
char *trouble_text(const calibration *c, const view_trouble *trouble);

/* The name of a view's camera. The name of its frame. */
const char *view_camera_name(const calibration *c, const view *v);
const char *view_frame_name(const calibration *c, const view *v);

/* Decides which pose each view has and which views are wrong, and makes the rig of the
 * others. Returns 0 if there is no rig, RIG_PAIRED_ANEW if views got other placements: then
 * judge again. */
enum { RIG_PAIRED_ANEW = 2 };
int judge_rig(calibration *c);
void name_rig_trouble(calibration *c, const char *what, rigcal_status status,
                      int32_t at_fault);

/* The turns of a flat target in its plane, and mirrored turns, that map its points onto
 * each other. The result is valid until the next call. */
enum { SYMMETRIES_MOST = 16 };
typedef struct {
    rigcal_symmetries of;
    double deg[SYMMETRIES_MOST];
    int is_mirrored[SYMMETRIES_MOST];
} symmetries;
const symmetries *symmetries_of(const rigcal_view *seen);

/* The rig with some of its views alone, for a search of the library that needs no more. */
typedef struct {
    calibration *c;
    rigcal_rig rig; /* the rig, with these views alone */
    size_t *views;  /* their numbers in the rig, ascending */
    uint8_t *left_out;
} rig_part;
void open_part_of_camera(rig_part *part, calibration *c, size_t camera);
void close_part(rig_part *part);
rigcal_status cause_of_view(rigcal_cause *cause, calibration *c, size_t i,
                            const symmetries *by);

/* "a, b and c", for about ten names at most. */
const char *names_joined(const char *const names[], size_t n, const char *last);

/* "a,b,c", with all names. */
const char *names_with_commas(const char *const names[], size_t n);

/* Takes over from c->judged which views count, and which pose each has. */
void note_verdicts(calibration *c);

/* The name of the frame of a placement; "" if it has none. */
const char *name_of_placement(const calibration *c, size_t placement);

/* Gives the times of the views to the rig. If the poses have been chosen, adjusts the rig
 * with all views and tests it for faults. Returns TEST_EXPLAINS if a fault explains why
 * views disagree, so that no view is wrong; TEST_PAIRS_ANEW if frames had to be paired
 * anew, and were; otherwise TEST_TELLS_NOTHING. */
enum { TEST_TELLS_NOTHING, TEST_EXPLAINS, TEST_PAIRS_ANEW };
void give_times(calibration *c);
int test_all_views(calibration *c);
void test_rig(calibration *c); /* of the adjusted rig */
void consider_intrinsics(calibration *c);
int estimate_intrinsics(calibration *c); /* 0: the intrinsics are unchanged */
void print_estimated(const calibration *c);
void write_cameras(FILE *file, const calibration *c);
const char *verdict_text(const calibration *c); /* NULL: there is none */
void print_verdict(const calibration *c);
void print_clocks(const calibration *c);
void write_faults(FILE *file, const calibration *c);
void write_clocks(FILE *file, const calibration *c);

/* Finds and tells why views are left out; why there is no rig; what looks wrong before the
 * rig is made. */
void find_causes(calibration *c);
void find_contradiction(calibration *c);
void find_suspects(calibration *c);
void find_groups(calibration *c);
void find_point(calibration *c, const view *v, const rigcal_blame *blame);
void find_duplicates(calibration *c);

/* The noise of a pixel of a camera of cameras.csv: the median of its views' own fits. 0:
 * too few views give an estimate. */
double camera_noise(const calibration *c, size_t camera);

/* These run in this order. Each says what it cannot do, and sets the exit status. `folder`
 * is the folder of the files, or NULL. */
void solve_views(calibration *c);
void turn_views(calibration *c); /* for targets that look the same from several sides */
void name_left_out(const calibration *c, const char *folder);
void form_rig(calibration *c);
void print_summary(const calibration *c); /* if at least one view was solved */
void print_graph(const calibration *c);
int find_weakest(rigcal_weakest *weakest, const calibration *c);
const char *next_text(const calibration *c, const rigcal_weakest *weakest);
void write_summary(FILE *file, const calibration *c);
int *cameras_that_count(const calibration *c); /* number of cameras of the rig that have a
                                                  view in it */
int widest(const cli_names *names);
void print_rig_sigma(const rig_sigma *s, int is_known);

double length_of(const rigcal_real x[3]);

#endif
