/* test_tags.h - simulated rigs of square tags, each view of which has two poses. The
 * cameras stand on an arc of 1.2 rad about the placements and look at them. Unit of length:
 * the side of a tag. Truth and composition are in double. */
#ifndef TEST_TAGS_H
#define TEST_TAGS_H

#include "test_support.h"

typedef struct {
    double distance;   /* distance of the cameras from the placements */
    double share_seen; /* share of all possible views, chosen at random; 1: all */
    double noise_px;
    /* the truth */
    rigcal_transform *true_cams, *true_places;
    uint8_t *right; /* for each view: which of its poses is nearer to the truth */
    /* the arguments of calls; `rig` and `choice` point to the other arrays */
    rigcal_camera camera;
    rigcal_transform *cams, *places;
    int32_t *group;
    rigcal_rig_view *views;
    rigcal_view_pose *own, *second;
    rigcal_observation *o; /* 4 for each view */
    uint8_t *takes;
    rigcal_real *work;
    rigcal_rig rig;
    rigcal_choice choice;
} test_tags;

/* Reals of memory for the choice and the adjustment. */
#define TEST_TAGS_WORK(C, F) \
    (RIGCAL_CHOOSE_WORK(C, F, (C) * (F)) > RIGCAL_RIG_WORK(C, C, F) \
         ? RIGCAL_CHOOSE_WORK(C, F, (C) * (F)) \
         : RIGCAL_RIG_WORK(C, C, F))

/* Declares `name`, with memory for these numbers of cameras and placements. */
#define TEST_TAGS(name, C, F) \
    static rigcal_transform name##_cams[4 * (C)], name##_places[4 * (F)]; \
    static uint8_t name##_takes[2 * (C) * (F)]; \
    static int32_t name##_group[C]; \
    static rigcal_rig_view name##_views[(C) * (F)]; \
    static rigcal_view_pose name##_own[2 * (C) * (F)]; \
    static rigcal_observation name##_o[4 * (C) * (F)]; \
    static rigcal_real name##_work[TEST_TAGS_WORK(C, F)]; \
    static test_tags name = {.true_cams = name##_cams, \
                             .true_places = name##_places, \
                             .right = name##_takes + (C) * (F), \
                             .cams = name##_cams + 2 * (C), \
                             .places = name##_places + 2 * (F), \
                             .group = name##_group, \
                             .views = name##_views, \
                             .own = name##_own, \
                             .second = name##_own + (C) * (F), \
                             .o = name##_o, \
                             .takes = name##_takes, \
                             .work = name##_work, \
                             .rig.work_capacity = TEST_TAGS_WORK(C, F)}

/* Makes random cameras and placements, and what is seen. distance, share_seen and noise_px
 * must be set before. Then solves both poses of every view. */
void test_tags_random(test_tags *t, test_rng *rng, int n_cameras, int n_placements);
void test_tags_solve(test_tags *t);

/* The number of views for which the choice is not the right pose; that it leaves out; whose
 * first pose is not right. */
int test_tags_wrong(const test_tags *t);
int test_tags_left_out(const test_tags *t);
int test_tags_wrong_first(const test_tags *t);

#endif /* TEST_TAGS_H */
