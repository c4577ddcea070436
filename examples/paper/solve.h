/* solve.h - the published procedure and the library's own solver on one image, and
 * how far a pose is from the true one. */
#ifndef PAPER_SOLVE_H
#define PAPER_SOLVE_H

#include "scene.h"

/* The outcome of an attempt. The map figures write the digit. */
enum { PAPER_NONE = 0, PAPER_FALSE = 1, PAPER_CORRECT = 2, PAPER_OUTCOMES = 3 };

typedef struct {
    int outcome;
    int has_pose;          /* true also for a pose that is no solution */
    int behind;            /* the search ended with points behind the camera */
    rigcal_transform pose; /* every point is in front */
    double residual;       /* value of the published objective */
    double degrees;        /* angle between the pose's rotation and the true one */
    double condition;      /* cond(A) */
    int evals;
} paper_attempt;

/* Settings of the published procedure. */
typedef struct {
    int n;           /* number of points: 3 or 4 */
    int angles;      /* number of angles searched: 2 or 3 */
    int eliminated;  /* RIGCAL_YAW, or another angle */
    int pairs_used;  /* pairs that eliminate it: 2 as published, 0: all */
    int first[2];    /* the two pairs, as numbers of rigcal_pairs_choose's list */
    int use_guess;   /* 0: from the library's grid, the best of 24 searches */
    double guess[3]; /* yaw, pitch, roll */
} paper_procedure;

/* The procedure for n points, from a guess. The first two pairs eliminate yaw. */
paper_procedure paper_published(int n);

void paper_true_angles(double ypr[3], const paper_scene *scene, int c);

/* Solves camera c of the images. */
void paper_solve(paper_attempt *attempt, const paper_procedure *procedure,
                 const paper_images *images, const paper_scene *scene, int c);

/* Runs the solver that needs no guess on all four points. */
void paper_solve_no_guess(paper_attempt *attempt, const paper_images *images,
                          const paper_scene *scene, int c);

/* The same on three points. Sets all poses that it returns, and the index of the correct
 * one, or -1. Returns their number. */
int paper_solve_three(rigcal_transform poses[RIGCAL_POSES_MAX], int *right,
                      const paper_images *images, const paper_scene *scene, int c);

/* The covariance of the pose `pose` of camera c, for the noise of rounding to whole pixels.
 * Returns 0 if the points do not fix the pose. */
int paper_covariance(double Sigma[36], const rigcal_transform *pose,
                     const paper_images *images, int c);

/* Draws a normal error (w, dt) with that covariance. Returns 0 if it is not a
 * covariance. */
int paper_draw(double d[6], const double Sigma[36], paper_rng *rng);

/* The pose moved by (w, dt), as in rigcal_pose_uncertainty. */
void paper_move(rigcal_transform *moved, const rigcal_transform *pose, const double d[6]);

double paper_degrees(const rigcal_transform *a, const rigcal_transform *b);
double paper_length(const double a[3], const double b[3]);

#endif
