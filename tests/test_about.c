/* about: the version, the statuses in words, and the account that the library
 * gives of its structs, which bindings believe. The truth is the compiler's:
 * offsetof and sizeof of the header as a caller sees it. */
#include <stddef.h>
#include <string.h>

#include "rigcal.h"
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

/* ---- version and size of a real ------------------------------------------ */

static void test_the_version_of_the_library_is_that_of_the_header(void)
{
    TEST_ASSERT_EQUAL_INT32(RIGCAL_VERSION_MAJOR * 10000 +
                                RIGCAL_VERSION_MINOR * 100 +
                                RIGCAL_VERSION_PATCH,
                            rigcal_version());
}

static void test_the_library_and_its_caller_agree_on_the_size_of_a_real(void)
{
    TEST_ASSERT_EQUAL_INT32((int32_t)sizeof(rigcal_real), rigcal_sizeof_real());
#if RIGCAL_USE_FLOAT
    TEST_ASSERT_EQUAL_INT32(4, rigcal_sizeof_real());
#else
    TEST_ASSERT_EQUAL_INT32(8, rigcal_sizeof_real());
#endif
}

/* ---- statuses ------------------------------------------------------------ */

typedef struct {
    rigcal_status status;
    const char *name;
} status_name;

#define STATUS(name) \
    { \
        name, #name \
    }
static const status_name STATUSES[] = {
    STATUS(RIGCAL_OK),
    STATUS(RIGCAL_RUNNING),
    STATUS(RIGCAL_BUDGET_SPENT),
    STATUS(RIGCAL_DISCONNECTED),
    STATUS(RIGCAL_AMBIGUOUS),
    STATUS(RIGCAL_POOR_FIT),
    STATUS(RIGCAL_FEW_AGREE),
    STATUS(RIGCAL_VAGUE),
    STATUS(RIGCAL_UNSEEN_POINT),
    STATUS(RIGCAL_MOST_DISAGREE),
    STATUS(RIGCAL_ERR_NULL),
    STATUS(RIGCAL_ERR_NOT_FINITE),
    STATUS(RIGCAL_ERR_RANGE),
    STATUS(RIGCAL_ERR_CAMERA),
    STATUS(RIGCAL_ERR_ROTATION),
    STATUS(RIGCAL_ERR_CAPACITY),
    STATUS(RIGCAL_ERR_STATE),
    STATUS(RIGCAL_ERR_TOO_FEW),
    STATUS(RIGCAL_ERR_COINCIDENT),
    STATUS(RIGCAL_ERR_COLLINEAR),
    STATUS(RIGCAL_ERR_EDGE_ON),
    STATUS(RIGCAL_ERR_PRECISION),
    STATUS(RIGCAL_ERR_NO_RAY),
    STATUS(RIGCAL_ERR_BEHIND),
    STATUS(RIGCAL_ERR_WIDE_RAY),
    STATUS(RIGCAL_ERR_PARALLEL),
    STATUS(RIGCAL_ERR_EPIPOLE),
    STATUS(RIGCAL_ERR_OUTSIDE),
    STATUS(RIGCAL_ERR_DEGENERATE),
    STATUS(RIGCAL_ERR_NO_POSE),
    STATUS(RIGCAL_ERR_DAMAGED),
    STATUS(RIGCAL_ERR_FOREIGN),
    STATUS(RIGCAL_ERR_VERSION),
    STATUS(RIGCAL_ERR_NO_CONSENSUS),
    STATUS(RIGCAL_ERR_MIRRORED),
};
enum { N_STATUSES = sizeof STATUSES / sizeof STATUSES[0] };

static int is_status(rigcal_status status)
{
    for (int i = 0; i < N_STATUSES; i++) {
        if (STATUSES[i].status == status) {
            return 1;
        }
    }
    return 0;
}

static void test_every_status_is_named_as_the_header_spells_it(void)
{
    for (int i = 0; i < N_STATUSES; i++) {
        TEST_ASSERT_EQUAL_STRING(STATUSES[i].name,
                                 rigcal_status_name(STATUSES[i].status));
    }
}

static void test_every_status_has_a_text_of_its_own(void)
{
    for (int i = 0; i < N_STATUSES; i++) {
        const char *text = rigcal_status_text(STATUSES[i].status);

        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_TRUE_MESSAGE(strlen(text) > 0, STATUSES[i].name);
        TEST_ASSERT_NOT_EQUAL_MESSAGE(0, strcmp(text, "unknown status"),
                                      STATUSES[i].name);
        TEST_ASSERT_NOT_EQUAL_MESSAGE(0, strcmp(text, STATUSES[i].name),
                                      STATUSES[i].name);
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_NOT_EQUAL_MESSAGE(
                0, strcmp(text, rigcal_status_text(STATUSES[j].status)),
                STATUSES[i].name);
        }
    }
}

static void test_a_number_that_is_no_status_is_an_unknown_status(void)
{
    static const rigcal_status FAR[] = {INT32_MIN, INT32_MIN + 1, -65536,
                                        65536,     INT32_MAX - 1, INT32_MAX};

    for (rigcal_status s = -1000; s <= 1000; s++) {
        if (!is_status(s)) {
            TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_name(s));
            TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_text(s));
        }
    }
    for (size_t i = 0; i < sizeof FAR / sizeof FAR[0]; i++) {
        TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_name(FAR[i]));
        TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_text(FAR[i]));
    }
}

/* ---- layout -------------------------------------------------------------- */

/* Every struct of rigcal.h, each followed by its fields in their order. */
#define STRUCT(type) \
    { \
#type, 0, (int32_t)sizeof(type) \
    }
#define FIELD(type, field) \
    { \
#type "." #field, (int32_t)offsetof(type, field), \
            (int32_t)sizeof(((type *)0)->field) \
    }
static const rigcal_layout_entry EXPECTED[] = {
    STRUCT(rigcal_layout_entry),
    FIELD(rigcal_layout_entry, name),
    FIELD(rigcal_layout_entry, offset),
    FIELD(rigcal_layout_entry, size),

    STRUCT(rigcal_transform),
    FIELD(rigcal_transform, R),
    FIELD(rigcal_transform, t),

    STRUCT(rigcal_camera),
    FIELD(rigcal_camera, lens),
    FIELD(rigcal_camera, width),
    FIELD(rigcal_camera, height),
    FIELD(rigcal_camera, reserved),
    FIELD(rigcal_camera, fx),
    FIELD(rigcal_camera, fy),
    FIELD(rigcal_camera, cx),
    FIELD(rigcal_camera, cy),
    FIELD(rigcal_camera, k1),
    FIELD(rigcal_camera, k2),
    FIELD(rigcal_camera, p1),
    FIELD(rigcal_camera, p2),
    FIELD(rigcal_camera, k3),
    FIELD(rigcal_camera, k4),
    FIELD(rigcal_camera, k5),
    FIELD(rigcal_camera, k6),

    STRUCT(rigcal_observation),
    FIELD(rigcal_observation, X_w),
    FIELD(rigcal_observation, uv),

    STRUCT(rigcal_sighting),
    FIELD(rigcal_sighting, X_w),
    FIELD(rigcal_sighting, ray),

    STRUCT(rigcal_vertex),
    FIELD(rigcal_vertex, x),
    FIELD(rigcal_vertex, cost),
    STRUCT(rigcal_neldermead),
    FIELD(rigcal_neldermead, k),
    FIELD(rigcal_neldermead, evals),
    FIELD(rigcal_neldermead, max_evals),
    FIELD(rigcal_neldermead, phase),
    FIELD(rigcal_neldermead, vertex_next),
    FIELD(rigcal_neldermead, status),
    FIELD(rigcal_neldermead, xtol),
    FIELD(rigcal_neldermead, ftol),
    FIELD(rigcal_neldermead, trial),
    FIELD(rigcal_neldermead, reflected),
    FIELD(rigcal_neldermead, vertex),

    STRUCT(rigcal_pair),
    FIELD(rigcal_pair, normal),
    FIELD(rigcal_pair, offset),
    FIELD(rigcal_pair, i),
    FIELD(rigcal_pair, j),

    STRUCT(rigcal_elimination),
    FIELD(rigcal_elimination, angle),
    FIELD(rigcal_elimination, cosine),
    FIELD(rigcal_elimination, sine),
    FIELD(rigcal_elimination, condition),
    FIELD(rigcal_elimination, unit),
    FIELD(rigcal_elimination, residual),

    STRUCT(rigcal_paper_options),
    FIELD(rigcal_paper_options, angles),
    FIELD(rigcal_paper_options, eliminate),
    FIELD(rigcal_paper_options, eliminating),
    FIELD(rigcal_paper_options, use_guess),
    FIELD(rigcal_paper_options, max_evals),
    FIELD(rigcal_paper_options, reserved),
    FIELD(rigcal_paper_options, guess_ypr),
    FIELD(rigcal_paper_options, xtol),
    FIELD(rigcal_paper_options, ftol),

    STRUCT(rigcal_paper_pose),
    FIELD(rigcal_paper_pose, cam_from_world),
    FIELD(rigcal_paper_pose, ypr),
    FIELD(rigcal_paper_pose, residual),
    FIELD(rigcal_paper_pose, condition),
    FIELD(rigcal_paper_pose, rms),
    FIELD(rigcal_paper_pose, eliminated),
    FIELD(rigcal_paper_pose, evals),
    FIELD(rigcal_paper_pose, starts),
    FIELD(rigcal_paper_pose, reserved),

    STRUCT(rigcal_paper_solver),
    FIELD(rigcal_paper_solver, sightings),
    FIELD(rigcal_paper_solver, pairs),
    FIELD(rigcal_paper_solver, n),
    FIELD(rigcal_paper_solver, n_pairs),
    FIELD(rigcal_paper_solver, options),
    FIELD(rigcal_paper_solver, nm),
    FIELD(rigcal_paper_solver, best),
    FIELD(rigcal_paper_solver, least_condition),
    FIELD(rigcal_paper_solver, seed_cost),
    FIELD(rigcal_paper_solver, seed_node),
    FIELD(rigcal_paper_solver, phase),
    FIELD(rigcal_paper_solver, next),
    FIELD(rigcal_paper_solver, eliminate),
    FIELD(rigcal_paper_solver, found),
    FIELD(rigcal_paper_solver, behind),
    FIELD(rigcal_paper_solver, evals),
    FIELD(rigcal_paper_solver, starts),
    FIELD(rigcal_paper_solver, spent),

    STRUCT(rigcal_pose),
    FIELD(rigcal_pose, cam_from_world),
    FIELD(rigcal_pose, sse),
    FIELD(rigcal_pose, rms_px),
    FIELD(rigcal_pose, probability),

    STRUCT(rigcal_pose_options),
    FIELD(rigcal_pose_options, use_start),
    FIELD(rigcal_pose_options, sigma_px),
    FIELD(rigcal_pose_options, start),

    STRUCT(rigcal_lens),
    FIELD(rigcal_lens, is_fisheye),
    FIELD(rigcal_lens, is_pinhole),
    FIELD(rigcal_lens, N),
    FIELD(rigcal_lens, D),
    FIELD(rigcal_lens, q),
    STRUCT(rigcal_fit),
    FIELD(rigcal_fit, camera),
    FIELD(rigcal_fit, observations),
    FIELD(rigcal_fit, sigma),
    FIELD(rigcal_fit, mask),
    FIELD(rigcal_fit, n),
    FIELD(rigcal_fit, is_mirrored),
    FIELD(rigcal_fit, left_out),
    FIELD(rigcal_fit, pixel),
    FIELD(rigcal_fit, nothing),
    FIELD(rigcal_fit, origin),
    FIELD(rigcal_fit, lens),
    STRUCT(rigcal_view_moments),
    FIELD(rigcal_view_moments, weight),
    FIELD(rigcal_view_moments, S),
    FIELD(rigcal_view_moments, u_mean),
    FIELD(rigcal_view_moments, V_mean),
    FIELD(rigcal_view_moments, h),
    FIELD(rigcal_view_moments, Q),
    FIELD(rigcal_view_moments, C),
    FIELD(rigcal_view_moments, G),
    STRUCT(rigcal_refinement),
    FIELD(rigcal_refinement, evals),
    FIELD(rigcal_refinement, is_stale),
    FIELD(rigcal_refinement, curvature),
    FIELD(rigcal_refinement, status),
    FIELD(rigcal_refinement, sse),
    FIELD(rigcal_refinement, last_gain),
    FIELD(rigcal_refinement, lambda),
    FIELD(rigcal_refinement, cam_from_points),
    FIELD(rigcal_refinement, g),
    FIELD(rigcal_refinement, H),
    STRUCT(rigcal_descent),
    FIELD(rigcal_descent, m3),
    FIELD(rigcal_descent, nm),
    STRUCT(rigcal_pose_triple),
    FIELD(rigcal_pose_triple, index),
    FIELD(rigcal_pose_triple, count),
    FIELD(rigcal_pose_triple, ray),
    STRUCT(rigcal_pose_optimum),
    FIELD(rigcal_pose_optimum, rows),
    FIELD(rigcal_pose_optimum, t),
    FIELD(rigcal_pose_optimum, sse),
    STRUCT(rigcal_pose_lattice),
    FIELD(rigcal_pose_lattice, index),
    FIELD(rigcal_pose_lattice, reserved),
    FIELD(rigcal_pose_lattice, least_cost),
    FIELD(rigcal_pose_lattice, azimuth),
    FIELD(rigcal_pose_lattice, cost),
    FIELD(rigcal_pose_lattice, moments),
    STRUCT(rigcal_pose_solver),
    FIELD(rigcal_pose_solver, phase),
    FIELD(rigcal_pose_solver, next),
    FIELD(rigcal_pose_solver, n_seeds),
    FIELD(rigcal_pose_solver, n_exact),
    FIELD(rigcal_pose_solver, n_found),
    FIELD(rigcal_pose_solver, is_flat),
    FIELD(rigcal_pose_solver, is_plane),
    FIELD(rigcal_pose_solver, leans),
    FIELD(rigcal_pose_solver, failure),
    FIELD(rigcal_pose_solver, bad),
    FIELD(rigcal_pose_solver, is_warm),
    FIELD(rigcal_pose_solver, point),
    FIELD(rigcal_pose_solver, is_mirrored),
    FIELD(rigcal_pose_solver, is_vague),
    FIELD(rigcal_pose_solver, is_unfinished),
    FIELD(rigcal_pose_solver, is_wide),
    FIELD(rigcal_pose_solver, picks),
    FIELD(rigcal_pose_solver, n),
    FIELD(rigcal_pose_solver, n_used),
    FIELD(rigcal_pose_solver, extent_px),
    FIELD(rigcal_pose_solver, scale),
    FIELD(rigcal_pose_solver, sigma_px),
    FIELD(rigcal_pose_solver, axis),
    FIELD(rigcal_pose_solver, normal),
    FIELD(rigcal_pose_solver, fit),
    FIELD(rigcal_pose_solver, from),
    FIELD(rigcal_pose_solver, work),
    FIELD(rigcal_pose_solver, found),

    STRUCT(rigcal_pose_uncertainty),
    FIELD(rigcal_pose_uncertainty, Sigma),
    FIELD(rigcal_pose_uncertainty, rotation),
    FIELD(rigcal_pose_uncertainty, translation),
    FIELD(rigcal_pose_uncertainty, center),
    FIELD(rigcal_pose_uncertainty, sigma_px),

    STRUCT(rigcal_robust_options),
    FIELD(rigcal_robust_options, threshold_px),
    FIELD(rigcal_robust_options, sigma_px),
    FIELD(rigcal_robust_options, samples),
    FIELD(rigcal_robust_options, seed),
    STRUCT(rigcal_robust_poses),
    FIELD(rigcal_robust_poses, best),
    FIELD(rigcal_robust_poses, tried),
    FIELD(rigcal_robust_poses, ray),
    FIELD(rigcal_robust_poses, cost),
    STRUCT(rigcal_robust_solver),
    FIELD(rigcal_robust_solver, camera),
    FIELD(rigcal_robust_solver, observations),
    FIELD(rigcal_robust_solver, sigma),
    FIELD(rigcal_robust_solver, inliers),
    FIELD(rigcal_robust_solver, n),
    FIELD(rigcal_robust_solver, n_agree),
    FIELD(rigcal_robust_solver, work),
    FIELD(rigcal_robust_solver, origin),
    FIELD(rigcal_robust_solver, sigma_px),
    FIELD(rigcal_robust_solver, threshold_px),
    FIELD(rigcal_robust_solver, missed),
    FIELD(rigcal_robust_solver, area_px2),
    FIELD(rigcal_robust_solver, random),
    FIELD(rigcal_robust_solver, sample),
    FIELD(rigcal_robust_solver, samples),
    FIELD(rigcal_robust_solver, tried),
    FIELD(rigcal_robust_solver, is_complete),
    FIELD(rigcal_robust_solver, phase),
    FIELD(rigcal_robust_solver, next),
    FIELD(rigcal_robust_solver, n_poses),
    FIELD(rigcal_robust_solver, rounds),
    FIELD(rigcal_robust_solver, failure),
    STRUCT(rigcal_blame),
    FIELD(rigcal_blame, verdict),
    FIELD(rigcal_blame, point),
    FIELD(rigcal_blame, is_rest_poor),
    FIELD(rigcal_blame, reserved),
    FIELD(rigcal_blame, rms_px),
    FIELD(rigcal_blame, rms_without_px),
    FIELD(rigcal_blame, chance),
    FIELD(rigcal_blame, probability),
    STRUCT(rigcal_diagnosis),
    FIELD(rigcal_diagnosis, verdict),
    FIELD(rigcal_diagnosis, is_handed),
    FIELD(rigcal_diagnosis, rms_mirrored_px),
    FIELD(rigcal_diagnosis, rms_flipped_px),
    FIELD(rigcal_diagnosis, units),
    FIELD(rigcal_diagnosis, blame),
    STRUCT(rigcal_point),
    FIELD(rigcal_point, X),
    FIELD(rigcal_point, Sigma),
    FIELD(rigcal_point, rms_px),

    STRUCT(rigcal_view),
    FIELD(rigcal_view, cam_from_target),
    FIELD(rigcal_view, weight),
    FIELD(rigcal_view, camera),
    FIELD(rigcal_view, placement),

    STRUCT(rigcal_mounted_camera),
    FIELD(rigcal_mounted_camera, camera),
    FIELD(rigcal_mounted_camera, cam_from_rig),
    FIELD(rigcal_mounted_camera, Sigma),
    FIELD(rigcal_mounted_camera, has_Sigma),
    FIELD(rigcal_mounted_camera, reserved),

    STRUCT(rigcal_saved_info),
    FIELD(rigcal_saved_info, sequence),
    FIELD(rigcal_saved_info, tag),
    FIELD(rigcal_saved_info, n_cameras),
    FIELD(rigcal_saved_info, n_bytes),
    FIELD(rigcal_saved_info, real_bytes),
};
enum { N_EXPECTED = sizeof EXPECTED / sizeof EXPECTED[0] };

static int is_field(const char *name)
{
    return strchr(name, '.') != NULL;
}

/* Line `index`, whose name must end inside its array. */
static rigcal_layout_entry layout_line(int32_t index)
{
    rigcal_layout_entry entry;

    memset(&entry, 'x', sizeof entry);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_OK, rigcal_layout(&entry, index));
    TEST_ASSERT_NOT_NULL(memchr(entry.name, '\0', sizeof entry.name));
    return entry;
}

static void test_every_struct_and_field_of_the_header_is_told_once(void)
{
    for (int i = 0; i < N_EXPECTED; i++) {
        int told = 0;

        for (int32_t k = 0; k < rigcal_layout_count(); k++) {
            const rigcal_layout_entry line = layout_line(k);

            if (strcmp(line.name, EXPECTED[i].name) == 0) {
                told++;
                TEST_ASSERT_EQUAL_INT32_MESSAGE(EXPECTED[i].offset, line.offset,
                                                line.name);
                TEST_ASSERT_EQUAL_INT32_MESSAGE(EXPECTED[i].size, line.size,
                                                line.name);
            }
        }
        TEST_ASSERT_EQUAL_INT_MESSAGE(1, told, EXPECTED[i].name);
    }
    TEST_ASSERT_EQUAL_INT32(N_EXPECTED, rigcal_layout_count());
}

/* A struct that gains a field, which EXPECTED does not know, shows here: a
 * gap before a field, or at the struct's end, is never as large as the
 * alignment. */
static void test_the_fields_follow_their_struct_in_order_without_overlap(void)
{
    const int32_t widest =
        (int32_t)(sizeof(void *) > 8 ? sizeof(void *) : (size_t)8);
    int32_t end = 0;
    rigcal_layout_entry owner = layout_line(0);

    TEST_ASSERT_FALSE(is_field(owner.name));
    for (int32_t k = 1; k <= rigcal_layout_count(); k++) {
        const int last = k == rigcal_layout_count();
        const rigcal_layout_entry line = last ? owner : layout_line(k);

        if (last || !is_field(line.name)) {
            TEST_ASSERT_EQUAL_INT32_MESSAGE(0, owner.offset, owner.name);
            TEST_ASSERT_TRUE_MESSAGE(end <= owner.size, owner.name);
            TEST_ASSERT_TRUE_MESSAGE(owner.size - end < widest, owner.name);
            owner = line;
            end = 0;
            continue;
        }
        const size_t length = strlen(owner.name);
        TEST_ASSERT_EQUAL_STRING_LEN(owner.name, line.name, length);
        TEST_ASSERT_EQUAL_CHAR('.', line.name[length]);
        TEST_ASSERT_TRUE_MESSAGE(line.size > 0, line.name);
        TEST_ASSERT_TRUE_MESSAGE(line.offset >= end, line.name);
        TEST_ASSERT_TRUE_MESSAGE(line.offset - end < widest, line.name);
        end = line.offset + line.size;
    }
}

static void test_a_line_that_is_not_there_is_refused_and_nothing_written(void)
{
    const int32_t count = rigcal_layout_count();
    const int32_t no_line[] = {-1, count, count + 1, INT32_MIN, INT32_MAX};
    rigcal_layout_entry entry, before;

    memset(&before, 0x5a, sizeof before);
    for (size_t i = 0; i < sizeof no_line / sizeof no_line[0]; i++) {
        entry = before;
        TEST_ASSERT_EQUAL_INT32(RIGCAL_ERR_RANGE,
                                rigcal_layout(&entry, no_line[i]));
        TEST_ASSERT_EQUAL_MEMORY(&before, &entry, sizeof entry);
    }
    TEST_ASSERT_EQUAL_INT32(RIGCAL_ERR_NULL, rigcal_layout(NULL, 0));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_version_of_the_library_is_that_of_the_header);
    RUN_TEST(test_the_library_and_its_caller_agree_on_the_size_of_a_real);
    RUN_TEST(test_every_status_is_named_as_the_header_spells_it);
    RUN_TEST(test_every_status_has_a_text_of_its_own);
    RUN_TEST(test_a_number_that_is_no_status_is_an_unknown_status);
    RUN_TEST(test_every_struct_and_field_of_the_header_is_told_once);
    RUN_TEST(test_the_fields_follow_their_struct_in_order_without_overlap);
    RUN_TEST(test_a_line_that_is_not_there_is_refused_and_nothing_written);
    return UNITY_END();
}
