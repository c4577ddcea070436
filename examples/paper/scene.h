/* scene.h - the scenes of the paper's experiments, and every setting of them.
 *
 * The paper's own numbers are lost; these are ours, in its spirit. */
#ifndef PAPER_SCENE_H
#define PAPER_SCENE_H

#include <stdint.h>

#include "rigcal.h"

/* ---- settings: name, value, unit, meaning; README.md shows this table --- */

#define PAPER_SETTINGS(S)                                                      \
    S(IMAGE_INCH, 1.0, "inch", "side of the square image")                     \
    S(FOCAL_INCH, 1.0, "inch", "focal length: the image spans 53 degrees")     \
    S(WIDTH, 512, "px", "image width and height, unless varied")               \
    S(DOCUMENTED_CM, 100.0, "cm", "from each camera to the target's middle, "  \
      "unless varied: 20 to 320 in figure 6; 50, 100, 200 in 9 to 14")         \
    S(GRID_STEP, 5.0, "deg", "between guesses of pitch (-87.5 .. 87.5) and "   \
      "roll (-177.5 .. 177.5), figures 3, 4, 5, 8")                            \
    S(SWEEP_STEP, 15.0, "deg", "the same for the documented scene of "         \
      "figure 9")                                                              \
    S(NEAR_YAW, 5.0, "deg", "error of a near guess of yaw, figure 5")          \
    S(FAR_YAW, 120.0, "deg", "error of a far one")                             \
    S(NEAR_GUESS, 12.0, "deg", "figure 6: guesses are off by up to this in "   \
      "pitch and in roll")                                                     \
    S(NEAR_GUESSES, 6, "-", "figure 6: so many of each angle")                 \
    S(MATCH_PX, 2.0, "px", "a pose is a solution if its points miss the "      \
      "digital image by no more, rms")                                         \
    S(MATCH_EXACT, 1e-6, "-", "the same for perfect images, as a part of the " \
      "focal length")                                                          \
    S(RIGHT_DEGREES, 5.0, "deg", "a solution is correct if its rotation is "   \
      "this near the true one; else it is false")                              \
    S(RIGHT_EXACT, 0.01, "deg", "the same for perfect images")                 \
    S(PLACEMENTS, 1000, "-", "random placements of the two cameras, "          \
      "figures 9 to 14")                                                       \
    S(OFF_AXIS, 0.05, "-", "random placements: the target's middle is off "    \
      "each axis by up to this part of its depth, in x and in y")              \
    S(TURN_LEAST, 20.0, "deg", "random placements: from camera 1 to camera 2 " \
      "by at least this, about an axis across the line of sight")              \
    S(TURN_MOST, 60.0, "deg", "and at most this")                              \
    S(BOUND_DRAWS, 4, "-", "normal errors drawn from the Cramer-Rao bound of " \
      "a placement")                                                           \
    S(REACH, 20.0, "cm", "figure 14, random placements: the matched points "   \
      "are within this of the target's middle, in each axis")                  \
    S(SEED, 20, "-", "of the random numbers (SplitMix64)")

#define PAPER_SETTING(name, value, unit, meaning)                              \
    static const double PAPER_##name = value;
PAPER_SETTINGS(PAPER_SETTING)

enum { PAPER_POINTS = 4, PAPER_CAMERAS = 2, PAPER_DEPTHS = 3, PAPER_WIDTHS = 11 };

/* Of figures 9 to 14: 50, 100, 200 cm; 32 to 1024 px. */
extern const double paper_depths_cm[PAPER_DEPTHS];
extern const int paper_widths[PAPER_WIDTHS];

/* Noise of a coordinate rounded to whole pixels: 1 / sqrt(12). */
#define PAPER_SIGMA_PX 0.28867513459481287

#define PAPER_DEGREE 0.017453292519943295

/* ---- random numbers, the same on every machine --------------------------- */

typedef struct {
    uint64_t state;
} paper_rng;

/* Streams of numbers: of each use of them, for each placement. */
enum { PAPER_PLACING, PAPER_GUESSING, PAPER_DRAWING, PAPER_MATCHING };
paper_rng paper_stream(int use, int k);

double paper_uniform(paper_rng *rng, double low, double high);
double paper_normal(paper_rng *rng);

/* ---- scenes ------------------------------------------------------------- */

/* The four points, in cm: no plane holds them, and their six distances are 17 to
 * 25 cm. With three, the first three. */
extern const double paper_points[PAPER_POINTS][3];

/* Both cameras see the target's middle at `depth_cm` along their axes. */
typedef struct {
    rigcal_transform cam_from_target[PAPER_CAMERAS];
} paper_scene;

/* The one scene of ours that stands for the paper's. */
void paper_scene_documented(paper_scene *scene, double depth_cm);

/* Placement k of the random ones: the same but for the depth at any depth. */
void paper_scene_random(paper_scene *scene, int k, double depth_cm);

/* ---- images ------------------------------------------------------------- */

/* What both cameras see. A perfect image has exact rays; its pixels, needed by the
 * solver that works in pixels, are rounded only as doubles are. */
typedef struct {
    rigcal_camera camera; /* both are alike */
    int digital;
    rigcal_observation seen[PAPER_CAMERAS][PAPER_POINTS];
    rigcal_sighting sightings[PAPER_CAMERAS][PAPER_POINTS];
} paper_images;

enum { PAPER_PERFECT = 0, PAPER_DIGITAL = 1 };

void paper_look(paper_images *images, const paper_scene *scene, int width,
                int digital);

/* Where camera k images a point of the target's frame; rounded when digital. */
void paper_see_point(double uv[2], const paper_images *images,
                     const paper_scene *scene, int k, const double X[3]);

/* The middle of the target, and a point in the frame of camera k. */
void paper_middle(double X[3]);
void paper_in_camera(double X_c[3], const rigcal_transform *T,
                     const double X[3]);

/* The program's own mistakes, which end it. */
void paper_expect(int fact, const char *what);

#endif
