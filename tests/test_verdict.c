/* verdict: the results for a rig in sentences. Each sentence must come if and only if its
 * number says so. */
#include <string.h>

#include "test_support.h"

enum { ROOM = 2000 };

static char text[ROOM];
static rigcal_faults found;
static rigcal_fault faults[3];
static rigcal_faults_words words;
static rigcal_real clocks[8] = {0, RC(-0.123), RC(0.032), 0, 0, RC(0.002), RC(0.0007), 0};
static const char *const NAMES[4] = {"left", "right", "top", "door"};

/* A rig of four cameras that agrees; the first fault is the focal length of one. */
static void set_up(void)
{
    memset(&found, 0, sizeof found);
    memset(faults, 0, sizeof faults);
    memset(&words, 0, sizeof words);
    found.n = 3;
    found.n_seen = 3;
    found.n_cameras = 4;
    found.F = 1;
    found.own_px = RC(0.18);
    found.clocks = clocks;
    for (int i = 0; i < 3; i++) {
        faults[i].kind = RIGCAL_FAULT_FOCAL;
        faults[i].camera = i;
        faults[i].placement = -1;
        faults[i].n = 1;
        faults[i].is_seen = faults[i].explains = 1;
        faults[i].value[0] = RC(0.0123);
        faults[i].sigma[0] = RC(0.001);
        faults[i].turn = RC(0.01);
        faults[i].shift = RC(0.006);
    }
    words.names = NAMES;
    words.length = "mm";
    words.length_scale = 1000;
    words.time = "ms";
    words.time_scale = 1000;
}

static void say(void)
{
    size_t n = 0;

    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_text(text, ROOM, &n, &found, faults, &words));
    TEST_ASSERT_TRUE(n > strlen(text));
}

#define ASSERT_SAYS(part) TEST_ASSERT_NOT_NULL_MESSAGE(strstr(text, part), text)
#define ASSERT_SAYS_NOT(part) TEST_ASSERT_NULL_MESSAGE(strstr(text, part), text)

/* The rig disagrees, and the first fault explains it. */
static void explained_by(int kind, int camera, double value, double sigma)
{
    set_up();
    found.verdict = RIGCAL_RIG_EXPLAINED;
    found.bits = RIGCAL_FAULTS_NAMED;
    found.F = RC(11.6 * 11.6);
    found.explained = RC(0.79);
    faults[0].kind = kind;
    faults[0].camera = camera;
    faults[0].value[0] = RC(value);
    faults[0].sigma[0] = RC(sigma);
}

static void test_a_rig_that_agrees(void)
{
    set_up();
    found.F = RC(1.0609);
    say();
    TEST_ASSERT_EQUAL_STRING(
        "The views agree with one rig (1.03 of the noise). Next: nothing.", text);
}

static void test_a_fault_that_explains(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.0123, 0.001);
    say();
    ASSERT_SAYS("The views fit (0.18 px) but the rig does not (11.60 times the noise). ");
    ASSERT_SAYS("Most likely the focal length of right: longer than given by 1.23 +- "
                "0.10 %. That explains 79 % of it.");
    ASSERT_SAYS("Next: check that its intrinsics are its own");
    ASSERT_SAYS_NOT("None of the causes");
    ASSERT_SAYS_NOT("cannot be told");
}

static void test_each_kind_has_its_words_and_units(void)
{
    explained_by(RIGCAL_FAULT_CLOCK, 2, 0.005, 0.0003);
    say();
    ASSERT_SAYS(
        "the clock of top: its pictures are later than their stamps by 5.0 +- 0.3 ms");
    ASSERT_SAYS("Next: let the clocks be estimated.");
    explained_by(RIGCAL_FAULT_CLOCKS, -1, 0, 0);
    say();
    ASSERT_SAYS("the clocks: against the first camera, right's pictures are earlier by 123 "
                "+- 2 ms, top's pictures are later by 32.0 +- 0.7 ms.");
    explained_by(RIGCAL_FAULT_CLOCK, 2, -0.005, 0.0003);
    say();
    ASSERT_SAYS(
        "the clock of top: its pictures are earlier than their stamps by 5.0 +- 0.3 ms");
    explained_by(RIGCAL_FAULT_FOCAL, 1, -0.0123, 0.001);
    say();
    ASSERT_SAYS("the focal length of right: shorter than given by 1.23 +- 0.10 %");
    explained_by(RIGCAL_FAULT_ASPECT, 1, -0.003, 0.001);
    say();
    ASSERT_SAYS("smaller than given by 0.30 +- 0.10 %");
    explained_by(RIGCAL_FAULT_DRIFT, 1, -0.00003, 0.000001);
    say();
    ASSERT_SAYS("it drifts by -30.0 +- 1.0 millionths");
    explained_by(RIGCAL_FAULT_SHUTTER, 0, 0.015, 0.001);
    say();
    ASSERT_SAYS("the rolling shutter of left: its last row is later than its first by 15.0 "
                "+- 1.0 ms");
    explained_by(RIGCAL_FAULT_CENTRE, 3, 7, 1.5);
    faults[0].n = 2;
    faults[0].value[1] = -4;
    faults[0].sigma[1] = 2;
    say();
    ASSERT_SAYS(
        "the principal point of door: off in x and y by 7.0 +- 1.5 px and -4 +- 2 px");
    explained_by(RIGCAL_FAULT_DISTORTION, 3, 0.25, 0.01);
    faults[0].n = 2;
    faults[0].value[1] = RC(-0.5);
    faults[0].sigma[1] = RC(0.02);
    say();
    ASSERT_SAYS(
        "the distortion of door: k1 and k2 are off by 0.250 +- 0.010 and -0.50 +- 0.02.");
    explained_by(RIGCAL_FAULT_STRETCHED, -1, 0.003, 0.0002);
    say();
    ASSERT_SAYS("the board is stretched: its X is longer than its Y by 0.30 +- 0.02 %");
    explained_by(RIGCAL_FAULT_MOVED, 1, 0.01, 0.001);
    faults[0].placement = 12;
    faults[0].value[3] = RC(0.003);
    say();
    ASSERT_SAYS(
        "the mount of right: it moved before placement 12, by 0.6 degrees and 3 mm");
}

static void test_a_fault_that_does_not_explain_is_no_reason(void)
{
    explained_by(RIGCAL_FAULT_BENT, -1, 0.00019, 0.00002);
    found.verdict = RIGCAL_RIG_FOUND;
    faults[0].explains = 0;
    say();
    ASSERT_SAYS(
        "the board is bent: out of its plane along x and y by 0.19 +- 0.02 mm; that "
        "is certain, but it is not why the views disagree.");
    ASSERT_SAYS("None of the causes that can be tested explains it.");
    ASSERT_SAYS_NOT("Most likely");
    ASSERT_SAYS_NOT("flat plate");
}

static void test_a_fault_that_the_views_hardly_show(void)
{
    explained_by(RIGCAL_FAULT_ASPECT, 1, 0.003, 0.0003);
    found.verdict = RIGCAL_RIG_AGREES;
    found.F = 1;
    say();
    ASSERT_SAYS("The views agree with one rig (1.00 of the noise). One thing is wrong, the "
                "aspect fx / fy of right: larger than given by 0.30 +- 0.03 %; that is "
                "certain, though the views hardly show it.");
}

static void test_a_pattern_comes_only_where_nothing_explains(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.01, 0.001);
    found.bits |= RIGCAL_FAULTS_PATTERN;
    found.pattern = RC(0.32);
    found.pattern_sigma = RC(0.03);
    say();
    ASSERT_SAYS_NOT("Neighbouring");
    found.verdict = RIGCAL_RIG_UNEXPLAINED;
    found.bits = RIGCAL_FAULTS_PATTERN;
    say();
    ASSERT_SAYS(
        "Neighbouring points err together (0.32; noise: 0.00 +- 0.03): the lens "
        "model, the board's coordinates or the detector, in every view. "
        "Disagreement between views of 2 to 8 times the noise is to be expected from "
        "that alone.");
    ASSERT_SAYS("Next: check the lens model");
}

static void test_what_lies_along_the_motion(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.01, 0.001);
    found.verdict = RIGCAL_RIG_UNEXPLAINED;
    found.bits = RIGCAL_FAULTS_ALONG_MOTION;
    found.along = RC(0.5);
    found.along_time = RC(0.02);
    say();
    ASSERT_SAYS(
        "50 % of it lies along the board's motion: single time stamps are wrong (by "
        "some 20 ms).");
    ASSERT_SAYS("Next: hold the board still");
}

static void test_what_could_not_be_tested(void)
{
    set_up();
    found.bits = RIGCAL_FAULTS_NO_TIMES;
    say();
    ASSERT_SAYS("Clocks could not be tested: no times are given.");
    found.bits = RIGCAL_FAULTS_NO_NEIGHBOUR;
    say();
    ASSERT_SAYS("Clocks could not be tested: no placement has a neighbour in time.");
    found.bits = RIGCAL_FAULTS_NO_MOTION;
    say();
    ASSERT_SAYS("Clocks could not be tested: the target stood still.");
    found.bits = RIGCAL_FAULTS_NO_LOOP;
    say();
    ASSERT_SAYS("nothing was tested");
    ASSERT_SAYS_NOT("The views agree");
}

static void test_what_cannot_be_told_apart(void)
{
    explained_by(RIGCAL_FAULT_CLOCK, 0, 0.005, 0.0003);
    found.n_alike = 2;
    found.bits |= RIGCAL_FAULTS_ALIKE | RIGCAL_FAULTS_TWO_CAMERAS;
    faults[2].explains = 0; /* never given as a reason */
    say();
    ASSERT_SAYS("With this recording it cannot be told from the focal length of right.");
    ASSERT_SAYS("With two cameras it is one or the other.");
    ASSERT_SAYS_NOT("of top");
}

static void test_what_would_have_been_seen_comes_on_demand(void)
{
    set_up();
    say();
    ASSERT_SAYS_NOT("unseen");
    words.with_unseen = 1;
    faults[2].is_seen = 0;
    say();
    ASSERT_SAYS("The focal length of left, off by 0.5 %, would go unseen; the largest such "
                "fault moves a camera by 0.6 degrees and 6 mm.");
    ASSERT_SAYS("The focal length of top: this recording cannot show it.");
}

static void test_without_names_and_units_there_are_numbers(void)
{
    explained_by(RIGCAL_FAULT_CLOCK, 2, 0.05, 0.01);
    memset(&words, 0, sizeof words);
    say();
    ASSERT_SAYS(
        "the clock of camera 2: its pictures are later than their stamps by 0.050 +- "
        "0.010 s.");
}

static void test_a_name_that_begins_with_no_letter_stays(void)
{
    static const char *const odd[4] = {"{1}", "~2", "9", "[4]"};

    explained_by(RIGCAL_FAULT_CLOCKS, -1, 0, 0);
    words.names = odd;
    say();
    ASSERT_SAYS("~2's pictures are earlier by");
}

/* Whatever the size of the buffer: whole sentences, and the size that all of them need. */
static void test_a_buffer_that_is_too_small_gets_whole_sentences(void)
{
    size_t n = 0, needed = 0;
    char all[ROOM];

    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.0123, 0.001);
    say();
    strcpy(all, text);
    for (size_t room = 1; room < ROOM; room++) {
        const rigcal_status status =
            rigcal_faults_text(text, room, &n, &found, faults, &words);
        const size_t length = strlen(text);

        TEST_ASSERT_TRUE(length < room);
        TEST_ASSERT_EQUAL_STRING_LEN(all, text, length);
        TEST_ASSERT_TRUE(length == 0 || text[length - 1] == '.');
        TEST_ASSERT_TRUE(needed == 0 || n == needed);
        needed = n;
        ASSERT_STATUS(room < needed ? RIGCAL_ERR_CAPACITY : RIGCAL_OK, status);
        TEST_ASSERT_EQUAL_INT(room >= needed, strcmp(all, text) == 0);
    }
}

static void test_what_is_no_result_is_refused(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.01, 0.001);
    faults[1].kind = RIGCAL_FAULT_KINDS;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_faults_text(text, ROOM, NULL, &found, faults, &words));
    set_up();
    faults[2].camera = 4;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_faults_text(text, ROOM, NULL, &found, faults, &words));
    set_up();
    found.verdict = 4;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_faults_text(text, ROOM, NULL, &found, faults, &words));
    set_up();
    faults[0].sigma[0] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_faults_text(text, ROOM, NULL, &found, faults, &words));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_faults_text(text, ROOM, NULL, &found, faults, NULL));
}

static void test_a_named_fault_that_is_not_there_is_refused(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.01, 0.001);
    found.bits |= RIGCAL_FAULTS_NAMED;
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_text(text, ROOM, NULL, &found, faults, &words));
    found.n = found.n_alike = 0;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_faults_text(text, ROOM, NULL, &found, faults, &words));
}

/* If the first fault does not explain, the others need not either. */
static void test_what_cannot_be_told_apart_where_nothing_explains(void)
{
    explained_by(RIGCAL_FAULT_CLOCK, 0, 0.005, 0.0003);
    found.n_alike = 2;
    found.bits |= RIGCAL_FAULTS_ALIKE;
    faults[0].explains = faults[1].explains = faults[2].explains = 0;
    say();
    ASSERT_SAYS(
        "it cannot be told from the focal length of right, the focal length of top.");
}

TEST_MAIN()
{
    RUN_TEST(test_a_rig_that_agrees);
    RUN_TEST(test_a_fault_that_explains);
    RUN_TEST(test_each_kind_has_its_words_and_units);
    RUN_TEST(test_a_fault_that_does_not_explain_is_no_reason);
    RUN_TEST(test_a_fault_that_the_views_hardly_show);
    RUN_TEST(test_a_pattern_comes_only_where_nothing_explains);
    RUN_TEST(test_what_lies_along_the_motion);
    RUN_TEST(test_what_could_not_be_tested);
    RUN_TEST(test_what_cannot_be_told_apart);
    RUN_TEST(test_what_would_have_been_seen_comes_on_demand);
    RUN_TEST(test_without_names_and_units_there_are_numbers);
    RUN_TEST(test_a_name_that_begins_with_no_letter_stays);
    RUN_TEST(test_a_buffer_that_is_too_small_gets_whole_sentences);
    RUN_TEST(test_what_is_no_result_is_refused);
    RUN_TEST(test_a_named_fault_that_is_not_there_is_refused);
    RUN_TEST(test_what_cannot_be_told_apart_where_nothing_explains);
}
