/* scene.h - the scenes of the paper's experiments, and every setting of them.
 *
 * The paper's coordinates are lost, so the scenes and these numbers are ours. */
#ifndef PAPER_SCENE_H
#define PAPER_SCENE_H

#include <stdint.h>

#include "rigcal_paper.h"

/* ---- settings: name, value, unit, meaning; README.md shows this table --- */

/* clang-format off */
#define PAPER_SETTINGS(S)                                                      \
    S(IMAGE_INCH, 1.0, "inch", "side of the square image")                     \
    S(FOCAL_INCH, 1.0, "inch", "focal length: the image spans 53 degrees")     \
    S(WIDTH, 512, "px", "image width and height, where a figure does not "     \
      "vary it")                                                               \
    S(DOCUMENTED_CM, 100.0, "cm", "from each camera to the target's middle; "  \
      "figure 6 takes 20 to 320, figures 9 to 14 take 50, 100 and 200")        \
    S(GRID_STEP, 5.0, "deg", "figures 3, 4, 5, 8: step between guesses of "    \
      "pitch (-87.5 .. 87.5) and of roll (-177.5 .. 177.5)")                   \
    S(SWEEP_STEP, 15.0, "deg", "figures 6 and 9, documented scene: the same "  \
      "step")                                                                  \
    S(NEAR_YAW, 5.0, "deg", "figure 5: error of the near guess of yaw")        \
    S(FAR_YAW, 120.0, "deg", "figure 5: error of the far guess of yaw")        \
    S(NEAR_GUESS, 12.0, "deg", "figure 6, residual and error: largest error "  \
      "of the guesses of pitch and roll")                                      \
    S(NEAR_GUESSES, 6, "-", "figure 6, residual and error: number of "         \
      "guesses of each angle")                                                 \
    S(COUNT_NEAR, 25.0, "deg", "counts: largest error of the near guesses "    \
      "of pitch and roll")                                                     \
    S(YAW_APART, 30.0, "deg", "counts: the far guess of yaw is this much "     \
      "worse than the near one, because the paper's are 40 and 10")            \
    S(THEIR_PITCH, 10.0, "deg", "guess of pitch from which the paper's "       \
      "three points end in a false solution")                                  \
    S(THEIR_ROLL, 90.0, "deg", "guess of roll, the same")                      \
    S(OUR_PITCH, 60.0, "deg", "guess of pitch from which our three points "    \
      "end in one, with the same roll")                                        \
    S(MATCH_PX, 2.0, "px", "digital images: a pose is a solution if its "      \
      "points are at most this far from their pixels, rms")                    \
    S(MATCH_EXACT, 1e-6, "-", "perfect images: the same, as a fraction of "    \
      "the focal length")                                                      \
    S(RIGHT_DEGREES, 5.0, "deg", "digital images: a solution is correct if "   \
      "its rotation is at most this far from the true one; else it is false")  \
    S(RIGHT_EXACT, 0.01, "deg", "perfect images: the same")                    \
    S(PLACEMENTS, 1000, "-", "number of random placements of the two "         \
      "cameras")                                                               \
    S(OFF_AXIS, 0.05, "-", "random placements: largest offset of the "         \
      "target's middle from an optical axis, in x and in y, as a fraction "    \
      "of its depth")                                                          \
    S(TURN_LEAST, 20.0, "deg", "random placements: smallest rotation from "    \
      "camera 1 to camera 2, about an axis across the line of sight")          \
    S(TURN_MOST, 60.0, "deg", "random placements: largest such rotation")      \
    S(BOUND_DRAWS, 4, "-", "random placements: number of errors drawn from "   \
      "the Cramer-Rao bound of each")                                          \
    S(REACH, 20.0, "cm", "figure 14, random placements: largest offset of a "  \
      "matched point from the target's middle, along each axis")               \
    S(SEED, 20, "-", "seed of the random numbers (SplitMix64)")
/* clang-format on */

#define PAPER_SETTING(name, value, unit, meaning) static const double PAPER_##name = value;
PAPER_SETTINGS(PAPER_SETTING)

enum { PAPER_POINTS = 4, PAPER_CAMERAS = 2, PAPER_DEPTHS = 3, PAPER_WIDTHS = 11 };

/* Depths and widths of figures 9 to 14: 50, 100, 200 cm; 32 to 1024 px. */
extern const double paper_depths_cm[PAPER_DEPTHS];
extern const int paper_widths[PAPER_WIDTHS];

/* Noise of a coordinate rounded to whole pixels: 1 / sqrt(12). */
#define PAPER_SIGMA_PX 0.28867513459481287

#define PAPER_DEGREE 0.017453292519943295

/* ---- random numbers, the same on every machine --------------------------- */

typedef struct {
    uint64_t state;
} paper_rng;

/* Streams of random numbers: one for each use of them, for each placement. */
enum { PAPER_PLACING, PAPER_GUESSING, PAPER_DRAWING, PAPER_MATCHING };
paper_rng paper_stream(int use, int k);

double paper_uniform(paper_rng *rng, double low, double high);
double paper_normal(paper_rng *rng);

/* ---- scenes ------------------------------------------------------------- */

/* The four points [cm]. They are not in one plane, and their six distances are 17 to 25 cm.
 * Scenes of three points use the first three. */
extern const double paper_points[PAPER_POINTS][3];

/* Both cameras see the target's middle at `depth_cm` along their axes. */
typedef struct {
    rigcal_transform cam_from_target[PAPER_CAMERAS];
} paper_scene;

/* The one scene of ours that stands for the paper's. */
void paper_scene_documented(paper_scene *scene, double depth_cm);

/* Random placement k. The placement is the same at each depth, except for the depth. */
void paper_scene_random(paper_scene *scene, int k, double depth_cm);

/* ---- images ------------------------------------------------------------- */

/* What both cameras see. A perfect image has exact rays. Its pixels, for the solver that
 * works in pixels, have only the rounding of doubles. */
typedef struct {
    rigcal_camera camera; /* both are alike */
    int digital;
    rigcal_observation seen[PAPER_CAMERAS][PAPER_POINTS];
    rigcal_bearing bearings[PAPER_CAMERAS][PAPER_POINTS];
} paper_images;

enum { PAPER_PERFECT = 0, PAPER_DIGITAL = 1 };

void paper_look(paper_images *images, const paper_scene *scene, int width, int digital);

/* The pixel of a point of the target's frame in camera k, rounded if the image is
 * digital. */
void paper_see_point(double uv[2], const paper_images *images, const paper_scene *scene,
                     int k, const double X[3]);

/* The middle of the target, and a point in the frame of camera k. */
void paper_middle(double X[3]);
void paper_in_camera(double X_c[3], const rigcal_transform *T, const double X[3]);

/* Ends the program if a fact about the program itself does not hold. */
void paper_expect(int fact, const char *what);

#endif
