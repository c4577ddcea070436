/* solve.h - the published procedure and the library's own solver on one image, and
 * how far a pose is from the true one. */
#ifndef PAPER_SOLVE_H
#define PAPER_SOLVE_H

#include "scene.h"

/* What an attempt comes to: the map figures write the digit. */
enum { PAPER_NONE = 0, PAPER_FALSE = 1, PAPER_CORRECT = 2, PAPER_OUTCOMES = 3 };

typedef struct {
    int outcome;
    int has_pose;          /* even one that is no solution */
    int behind;            /* the search ended with points behind the camera */
    rigcal_transform pose; /* every point in front */
    double residual;       /* the published objective */
    double degrees;        /* between the pose's rotation and the true one */
    double condition;      /* cond(A) */
    int evals;
} paper_attempt;

/* The published procedure. */
typedef struct {
    int n;           /* points: 3 or 4 */
    int angles;      /* searched: 2 or 3 */
    int eliminated;  /* RIGCAL_YAW, .. */
    int pairs_used;  /* to eliminate it by: 2 as published, or 0, all */
    int first[2];    /* the two pairs, as numbers of rigcal_pairs_choose's list */
    int use_guess;   /* 0: from the library's grid, the best of 24 searches */
    double guess[3]; /* yaw, pitch, roll */
} paper_procedure;

/* n points, yaw eliminated by the first two pairs, from a guess. */
paper_procedure paper_published(int n);

void paper_true_angles(double ypr[3], const paper_scene *scene, int c);

/* Camera c of the images. */
void paper_solve(paper_attempt *attempt, const paper_procedure *procedure,
                 const paper_images *images, const paper_scene *scene, int c);

/* The solver that needs no guess, on all four points. */
void paper_solve_no_guess(paper_attempt *attempt, const paper_images *images,
                          const paper_scene *scene, int c);

/* The same on three points: all the poses that it returns, and which of them is
 * correct, or -1. Returns how many. */
int paper_solve_three(rigcal_transform poses[RIGCAL_POSES_MAX], int *right,
                      const paper_images *images, const paper_scene *scene, int c);

/* The covariance of camera c's pose at `pose`, for the noise of whole pixels. 0
 * when the points do not fix the pose. */
int paper_covariance(double Sigma[36], const rigcal_transform *pose,
                     const paper_images *images, int c);

/* A normal error (w, dt) of that covariance. 0 when it is none. */
int paper_draw(double d[6], const double Sigma[36], paper_rng *rng);

/* The pose moved by (w, dt), as in rigcal_pose_uncertainty. */
void paper_move(rigcal_transform *moved, const rigcal_transform *pose, const double d[6]);

double paper_degrees(const rigcal_transform *a, const rigcal_transform *b);
double paper_length(const double a[3], const double b[3]);

#endif
