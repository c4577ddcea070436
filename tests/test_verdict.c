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

/* ---- all sentences ------------------------------------------------------------ */

static char expected[ROOM];

static void add(const char *sentence)
{
    TEST_ASSERT_TRUE(strlen(expected) + strlen(sentence) < ROOM);
    strcat(expected, sentence);
}

/* Sets what is to be told: clock 0, focal length 1 or mount 2, of the camera `left`. */
static void set_kind(int kind)
{
    static const int32_t KINDS[3] = {RIGCAL_FAULT_CLOCK, RIGCAL_FAULT_FOCAL,
                                     RIGCAL_FAULT_MOVED};
    set_up();
    found.F = RC(6.25);
    found.explained = RC(0.79);
    found.pattern = RC(0.32);
    found.pattern_sigma = RC(0.03);
    found.along = RC(0.5);
    found.along_time = RC(0.02);
    words.length = "cm";
    words.length_scale = 100;
    faults[0].kind = KINDS[kind];
    faults[0].placement = kind == 2 ? 12 : -1;
    faults[0].value[3] = kind == 2 ? RC(0.03) : 0;
}

/* The text that these numbers ask for. */
static void expect_text(int verdict, int bits, int kind)
{
    static const char *const WHAT[3] = {"the clock of left: its pictures are later than "
                                        "their stamps by 12.3 +- 1.0 ms",
                                        "the focal length of left: longer than given by "
                                        "1.23 +- 0.10 %",
                                        "the mount of left: it moved before placement 12, "
                                        "by 0.7 degrees and 3 cm"};
    static const char *const NEXT[3] = {
        "let the clocks be estimated.",
        "check that its intrinsics are its own, and calibrate them again.",
        "calibrate what was before the move, and after it, apart."};
    const int is_named = (bits & RIGCAL_FAULTS_NAMED) != 0;
    const int is_open = verdict == RIGCAL_RIG_FOUND || verdict == RIGCAL_RIG_UNEXPLAINED;

    expected[0] = 0;
    if (bits & RIGCAL_FAULTS_NO_LOOP) {
        add("No two cameras saw the same placements: the views cannot disagree, and "
            "nothing "
            "was tested. ");
    } else if (verdict == RIGCAL_RIG_AGREES) {
        add("The views agree with one rig (2.50 of the noise). ");
    } else {
        add("The views fit (0.18 px) but the rig does not (2.50 times the noise). ");
    }
    if (is_named) {
        add(verdict == RIGCAL_RIG_EXPLAINED ? "Most likely " : "One thing is wrong, ");
        add(WHAT[kind]);
        add(verdict == RIGCAL_RIG_EXPLAINED ? ". That explains 79 % of it. "
            : verdict == RIGCAL_RIG_FOUND
                ? "; that is certain, but it is not why the views disagree. "
                : "; that is certain, though the views hardly show it. ");
        if (bits & RIGCAL_FAULTS_ALIKE) {
            add("With this recording it cannot be told from the focal length of right. ");
        }
        if ((bits & RIGCAL_FAULTS_TWO_CAMERAS) && kind != 1) {
            add("With two cameras it is one or the other. ");
        }
    }
    if (is_open && (bits & RIGCAL_FAULTS_PATTERN)) {
        add("Neighbouring points err together (0.32; noise: 0.00 +- 0.03): the lens model, "
            "the board's coordinates or the detector, in every view. Disagreement between "
            "views of 2 to 8 times the noise is to be expected from that alone. ");
    }
    if (is_open) {
        add("None of the causes that can be tested explains it. ");
    }
    if (is_open && (bits & RIGCAL_FAULTS_ALONG_MOTION)) {
        add("50 % of it lies along the board's motion: single time stamps are wrong (by "
            "some 20 ms). ");
    }
    if (bits &
        (RIGCAL_FAULTS_NO_TIMES | RIGCAL_FAULTS_NO_NEIGHBOUR | RIGCAL_FAULTS_NO_MOTION)) {
        add("Clocks could not be tested: ");
        add(bits & RIGCAL_FAULTS_NO_TIMES       ? "no times are given. "
            : bits & RIGCAL_FAULTS_NO_NEIGHBOUR ? "no placement has a neighbour in time. "
                                                : "the target stood still. ");
    }
    add("Next: ");
    add(is_named && verdict != RIGCAL_RIG_FOUND ? NEXT[kind]
        : bits & RIGCAL_FAULTS_NO_LOOP ? "show the target where two cameras see it."
        : verdict == RIGCAL_RIG_AGREES ? "nothing."
        : bits & RIGCAL_FAULTS_PATTERN
            ? "check the lens model, the board's coordinates and the detector."
        : bits & RIGCAL_FAULTS_ALONG_MOTION
            ? "hold the board still for each picture, or trigger the cameras together."
        : bits & (RIGCAL_FAULTS_NO_TIMES | RIGCAL_FAULTS_NO_NEIGHBOUR)
            ? "record three frames or more at each place, at most 0.1 s apart, with the "
              "times of the frames."
            : "look which single views are wrong.");
}

/* Each verdict with each set of bits and each kind. */
static void test_each_sentence_comes_when_its_bits_say_so(void)
{
    enum { SETS = 512 };

    for (int k = 0; k<12 * SETS; k += TEST_ONE_IN> 1 ? 37 : 1) {
        const int bits = k % SETS, verdict = k / SETS % 4, kind = k / SETS / 4;

        set_kind(kind);
        found.verdict = verdict;
        found.bits = bits;
        found.n_alike = bits & RIGCAL_FAULTS_ALIKE ? 1 : 0;
        expect_text(verdict, bits, kind);
        say();
        TEST_ASSERT_EQUAL_STRING(expected, text);
    }
}

/* ---- numbers ------------------------------------------------------------------- */

/* Of the noise of the views' own fits, and of sqrt(F). */
static void expect_numbers(const char *own, double own_px, const char *root, double F)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.01, 0.001);
    found.own_px = RC(own_px);
    found.F = RC(F);
    say();
    expected[0] = 0;
    add("The views fit (");
    add(own);
    add(" px) but the rig does not (");
    add(root);
    add(" times the noise). ");
    ASSERT_SAYS(expected);
}

static void test_numbers_have_their_digits(void)
{
    expect_numbers("0", 0, "0.00", 0);
    expect_numbers("0.0000000", 3e-12, "0.50", 0.25);
    expect_numbers("0.0000003", 3e-7, "0.00", -4);
    expect_numbers("0.012", 0.0123, "1.24", 1.236 * 1.236);
    expect_numbers("1.9", 1.94, "1.23", 1.234 * 1.234);
    expect_numbers("2", D(RC(1.95)), "10.00", 100);
    expect_numbers("3", 3.4, "12345.00", 12345. * 12345);
    if (!RIGCAL_USE_FLOAT) {
        expect_numbers("4", 3.6, "123456.75", 123456.75 * 123456.75);
        expect_numbers("123456789", 123456789.4, "1234567.89", 1234567.89 * 1234567.89);
        expect_numbers("999999999", 1e12, "9999999.99", 1e30);
    }
}

static void expect_pattern(const char *number, double pattern)
{
    set_up();
    found.verdict = RIGCAL_RIG_UNEXPLAINED;
    found.bits = RIGCAL_FAULTS_PATTERN;
    found.pattern = RC(pattern);
    say();
    expected[0] = 0;
    add("Neighbouring points err together (");
    add(number);
    add("; noise: 0.00 +- 0.00)");
    ASSERT_SAYS(expected);
}

/* What rounds to 0 has no sign. */
static void test_numbers_have_their_sign(void)
{
    expect_pattern("-0.32", -0.32);
    expect_pattern("-0.01", -0.0099);
    expect_pattern("0.00", -0.0049);
    expect_pattern("-0.01", -0.0051);
    expect_pattern("0.01", 0.0051);
    expect_pattern("0.00", 0.0049);
}

static void test_no_more_than_all_is_explained(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.01, 0.001);
    found.explained = RC(1.7);
    say();
    ASSERT_SAYS("That explains 100 % of it.");
    found.explained = RC(0.996);
    say();
    ASSERT_SAYS("That explains 100 % of it.");
    found.explained = RC(-0.25);
    say();
    ASSERT_SAYS("That explains -25 % of it.");
}

/* ---- units ------------------------------------------------------------------------ */

/* Length and time have scales of their own. A scale that is not above 0 counts as 1. */
static void test_units_are_those_of_the_caller(void)
{
    static const double SCALES[4] = {0.5, 1000, 0, -3};
    static const char *const LENGTHS[4] = {"2.0 +- 0.5 mm", "4000 +- 1000 mm",
                                           "4.0 +- 1.0 mm", "4.0 +- 1.0 mm"};
    static const char *const TIMES[4] = {"2.0 +- 0.5 ms", "4000 +- 1000 ms",
                                         "4.0 +- 1.0 ms", "4.0 +- 1.0 ms"};

    for (int k = 0; k < 4; k++) {
        explained_by(RIGCAL_FAULT_BENT, -1, 4, 1);
        words.length_scale = RC(SCALES[k]);
        words.time_scale = 7;
        say();
        ASSERT_SAYS(LENGTHS[k]);
        explained_by(RIGCAL_FAULT_SHUTTER, 1, 4, 1);
        words.time_scale = RC(SCALES[k]);
        words.length_scale = 7;
        say();
        ASSERT_SAYS(TIMES[k]);
    }
    explained_by(RIGCAL_FAULT_BENT, -1, 0.19, 0.02);
    words.length = NULL;
    words.length_scale = 0;
    say();
    ASSERT_SAYS("out of its plane along x and y by 0.19 +- 0.02 units.");
    ASSERT_SAYS("Next: put the board on a flat plate, or measure its points.");
    explained_by(RIGCAL_FAULT_STRETCHED, -1, -0.003, 0.0002);
    say();
    ASSERT_SAYS("its X is shorter than its Y by 0.30 +- 0.02 %.");
    ASSERT_SAYS("Next: measure the board along X and along Y.");
    explained_by(RIGCAL_FAULT_SHUTTER, 2, -0.015, 0.001);
    say();
    ASSERT_SAYS("its last row is earlier than its first by 15.0 +- 1.0 ms.");
    ASSERT_SAYS("Next: hold the board still for each picture.");
    explained_by(RIGCAL_FAULT_DRIFT, 2, 0.00003, 0.000001);
    say();
    ASSERT_SAYS("it drifts by 30.0 +- 1.0 millionths.");
    ASSERT_SAYS("Next: let clocks and drifts be estimated.");
    explained_by(RIGCAL_FAULT_ASPECT, 2, 0.003, 0.001);
    say();
    ASSERT_SAYS("the aspect fx / fy of top: larger than given by 0.30 +- 0.10 %.");
}

/* A clock with a sigma is told, whichever it is. One of 0 is told by its sigma. */
static void test_each_clock_that_is_free_is_told(void)
{
    static rigcal_real of[8] = {RC(-0.05), 0,         RC(0.03),  RC(0.5),
                                RC(0.002), RC(0.003), RC(0.004), 0};

    explained_by(RIGCAL_FAULT_CLOCKS, -1, 0, 0);
    found.clocks = of;
    say();
    ASSERT_SAYS(
        "the clocks: against the first camera, left's pictures are earlier by 50 +- "
        "2 ms, right's pictures are later by 3 ms, top's pictures are later by 30 "
        "+- 4 ms. That");
    found.clocks = NULL;
    say();
    ASSERT_SAYS("the clocks: against the first camera, . That");
}

/* A fault of 0 goes the way of positive ones. */
static void test_a_fault_of_0_has_a_way(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0, 0.001);
    say();
    ASSERT_SAYS("the focal length of right: longer than given by 0.10 %.");
}

/* Of the clocks together, and of a move, no size is told. */
static void test_what_would_go_unseen_has_its_size(void)
{
    set_up();
    words.with_unseen = 1;
    faults[0].kind = RIGCAL_FAULT_CLOCKS;
    faults[0].camera = -1;
    faults[1].kind = RIGCAL_FAULT_MOVED;
    faults[2].kind = RIGCAL_FAULT_CLOCK;
    faults[2].sigma[0] = RC(0.0005);
    say();
    ASSERT_SAYS("The clocks, would go unseen; the largest such fault moves a camera by 0.6 "
                "degrees and 6 mm. The mount of right, would go unseen; the");
    ASSERT_SAYS("The clock of top, off by 3 ms, would go unseen; the");
}

/* What comes next is of the first fault, whatever would go unseen. */
static void test_what_comes_next_is_of_the_first_fault(void)
{
    explained_by(RIGCAL_FAULT_FOCAL, 1, 0.0123, 0.001);
    faults[1].kind = faults[2].kind = RIGCAL_FAULT_DRIFT;
    words.with_unseen = 1;
    say();
    ASSERT_SAYS("The clock of top, off by 5000 millionths, would go unseen; the");
    ASSERT_SAYS("Next: check that its intrinsics are its own, and calibrate them again.");
}

/* ---- what is refused ---------------------------------------------------------------- */

static void expect_status(rigcal_status status)
{
    size_t n = 77;

    FILL(text);
    ASSERT_STATUS(status, rigcal_faults_text(text, ROOM, &n, &found, faults, &words));
    if (status != RIGCAL_OK) {
        ASSERT_UNTOUCHED(text);
        TEST_ASSERT_EQUAL_size_t(77, n);
    }
}

/* Each number of the result and of the faults by itself. */
static void test_each_number_is_checked(void)
{
    for (int k = 0; k < 12; k++) {
        set_up();
        rigcal_real *const numbers[12] = {
            &found.F,          &found.freedom_between, &found.freedom_within,
            &found.sigma_px,   &found.own_px,          &found.explained,
            &found.pattern,    &found.pattern_sigma,   &found.along,
            &found.along_time, &words.length_scale,    &words.time_scale};
        *numbers[k] = TEST_NAN;
        expect_status(RIGCAL_ERR_NOT_FINITE);
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 18; k++) {
            rigcal_fault *const f = &faults[i];
            rigcal_real *const others[6] = {&f->gain,    &f->p,    &f->bic,
                                            &f->F_after, &f->turn, &f->shift};
            set_up();
            *(k < 6 ? &f->value[k] : k < 12 ? &f->sigma[k - 6] : others[k - 12]) = TEST_INF;
            expect_status(RIGCAL_ERR_NOT_FINITE);
        }
    }
    for (int k = 0; k < 8; k++) {
        rigcal_real of[8];

        set_up();
        memcpy(of, clocks, sizeof of);
        of[k] = TEST_NAN;
        found.clocks = of;
        expect_status(RIGCAL_ERR_NOT_FINITE);
    }
    for (int c = 0; c < 4; c++) {
        const char *names[4] = {"a", "b", "c", "d"};

        set_up();
        names[c] = NULL;
        words.names = names;
        expect_status(RIGCAL_ERR_NULL);
    }
}

/* Counts, kinds and cameras, at their bounds and beyond. */
static void test_counts_are_checked_from_both_sides(void)
{
    for (int32_t verdict = -1; verdict < 5; verdict++) {
        set_up();
        found.verdict = verdict;
        expect_status(verdict >= 0 && verdict < 4 ? RIGCAL_OK : RIGCAL_ERR_RANGE);
    }
    for (int32_t n = -1; n < 4; n++) {
        for (int32_t alike = -1; alike < 4; alike++) {
            const int is_right = n >= 0 && alike >= 0 && (alike == 0 || alike < n);

            set_up();
            found.n = n;
            found.n_alike = alike;
            expect_status(is_right ? RIGCAL_OK : RIGCAL_ERR_RANGE);
            found.bits = RIGCAL_FAULTS_NAMED;
            expect_status(is_right && n > 0 ? RIGCAL_OK : RIGCAL_ERR_RANGE);
        }
    }
    for (int i = 0; i < 3; i++) {
        for (int32_t kind = -1; kind <= RIGCAL_FAULT_KINDS; kind++) {
            set_up();
            faults[i].kind = kind;
            expect_status(kind >= 0 && kind < RIGCAL_FAULT_KINDS ? RIGCAL_OK
                                                                 : RIGCAL_ERR_RANGE);
        }
        for (int32_t camera = -2; camera < 6; camera++) {
            set_up();
            faults[i].camera = camera;
            expect_status(camera >= -1 && camera < 4 ? RIGCAL_OK : RIGCAL_ERR_RANGE);
        }
    }
    set_up();
    found.n_cameras = -1;
    expect_status(RIGCAL_ERR_RANGE);
    set_up();
    found.n = found.n_cameras = 0;
    expect_status(RIGCAL_OK);
}

/* Without room nothing is written, but what is needed is told. */
static void test_outputs_that_are_not_wanted(void)
{
    size_t n = 0;

    set_up();
    say();
    const size_t length = strlen(text);
    FILL(text);
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY,
                  rigcal_faults_text(text, 0, &n, &found, faults, &words));
    ASSERT_UNTOUCHED(text);
    TEST_ASSERT_EQUAL_size_t(length + 1, n);
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_text(text, n, NULL, &found, faults, &words));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_text(NULL, n, &n, &found, faults, &words));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_text(text, n, &n, NULL, faults, &words));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_text(text, n, &n, &found, NULL, &words));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_text(text, n, &n, &found, faults, NULL));
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
    RUN_TEST(test_each_sentence_comes_when_its_bits_say_so);
    RUN_TEST(test_numbers_have_their_digits);
    RUN_TEST(test_numbers_have_their_sign);
    RUN_TEST(test_no_more_than_all_is_explained);
    RUN_TEST(test_units_are_those_of_the_caller);
    RUN_TEST(test_each_clock_that_is_free_is_told);
    RUN_TEST(test_a_fault_of_0_has_a_way);
    RUN_TEST(test_what_would_go_unseen_has_its_size);
    RUN_TEST(test_what_comes_next_is_of_the_first_fault);
    RUN_TEST(test_each_number_is_checked);
    RUN_TEST(test_counts_are_checked_from_both_sides);
    RUN_TEST(test_outputs_that_are_not_wanted);
}
