#include "rc_real.h"

/* ---- constants --------------------------------------------------------- */

/* digits: most of a number that are printed. */
enum { DIGITS_MOST = 9 };

/* 1: a number whose first two digits are less is printed with both, else with one. */
#define TWO_DIGITS_BELOW RC(1.95)

/* 1: larger numbers are printed as this. */
#define NUMBER_MOST RC(999999999)

/* degrees: in a radian. */
#define DEGREES (180 / RC_PI)

/* percent: in a whole. */
#define PERCENT RC(100)

/* millionths: in a whole, of which drifts are told. */
#define MILLIONTHS RC(1e6)

/* ---- a text that grows by whole sentences ------------------------------ */

typedef struct {
    char *text;
    size_t capacity, n, whole; /* bytes that it takes; of its whole sentences that fit */
    int is_start;              /* of a sentence */
    const rigcal_faults *found;
    const rigcal_faults_words *words;
} writer;

static void put(writer *w, const char *text)
{
    for (; *text != 0; text++) {
        const int is_small = w->is_start && *text >= 'a' && *text <= 'z';
        if (w->n < w->capacity) {
            w->text[w->n] = is_small ? (char)(*text - 'a' + 'A') : *text;
        }
        w->is_start = 0;
        w->n++;
    }
}

/* A sentence ends: it counts, if there is room for the 0 too. */
static void end_sentence(writer *w, const char *end)
{
    put(w, end);
    if (w->n < w->capacity) {
        w->whole = w->n;
    }
    put(w, " ");
    w->is_start = 1;
}

static void say(writer *w, const char *sentence)
{
    put(w, sentence);
    end_sentence(w, "");
}

/* x, rounded, with so many digits behind the point. */
static void put_number(writer *w, rigcal_real x, int decimals)
{
    char digits[DIGITS_MOST + 3];
    int at = DIGITS_MOST + 2;
    rigcal_real scaled = RC_FABS(x);
    for (int k = 0; k < decimals; k++) {
        scaled *= 10;
    }
    uint32_t number = (uint32_t)(rc_min(scaled, NUMBER_MOST) + RC(1) / 2);
    if (x < 0 && number > 0) {
        put(w, "-");
    }
    digits[at] = 0;
    for (int k = 0; at > 0 && (number > 0 || k <= decimals); k++) {
        if (k == decimals && k > 0) {
            digits[--at] = '.';
        }
        digits[--at] = (char)('0' + (int)(number % 10));
        number /= 10;
    }
    put(w, &digits[at]);
}

/* How many digits behind the point show the first one or two of x. */
static int decimals_of(rigcal_real x)
{
    int decimals = 0;
    while (x > 0 && x < TWO_DIGITS_BELOW && decimals < DIGITS_MOST - 2) {
        x *= 10;
        decimals++;
    }
    return decimals;
}

/* "12.3 +- 0.4" */
static void put_measured(writer *w, rigcal_real value, rigcal_real sigma)
{
    const int decimals = decimals_of(sigma);
    put_number(w, value, decimals);
    put(w, " +- ");
    put_number(w, sigma, decimals);
}

static void put_rounded(writer *w, rigcal_real x)
{
    put_number(w, x, decimals_of(x));
}

/* ---- names and units --------------------------------------------------- */

static void put_camera(writer *w, int32_t camera)
{
    if (w->words->names != NULL) {
        put(w, w->words->names[camera]);
    } else {
        put(w, "camera ");
        put_number(w, (rigcal_real)camera, 0);
    }
}

static rigcal_real scale_or_1(rigcal_real scale)
{
    return (scale > 0) ? scale : 1;
}

static void put_length_unit(writer *w)
{
    put(w, " ");
    put(w, (w->words->length != NULL) ? w->words->length : "units");
}

static void put_time_unit(writer *w)
{
    put(w, " ");
    put(w, (w->words->time != NULL) ? w->words->time : "s");
}

/* ---- a fault ----------------------------------------------------------- */

/* What is wrong, whose; its words for a value above 0, and below; in what unit: a part of
 * 100 or so, or 0 for a time and -1 for a length. By their kinds. */
typedef struct {
    const char *what, *by, *more, *less, *than, *unit, *next;
    rigcal_real scale;
} fault_words;

static const char CLOCKS_NEXT[] = "let the clocks be estimated.";
static const char CAMERA_NEXT[] =
    "check that its intrinsics are its own, and calibrate them again.";

#define LATER "later", "earlier"
#define LONGER "longer", "shorter"
#define LARGER "larger", "smaller"
#define NO_WORD "", ""

static const fault_words WORDS[RIGCAL_FAULT_KINDS] = {
    {"clock", "its pictures are ", LATER, " than their stamps by ", "", CLOCKS_NEXT, 0},
    {"clock", "it drifts by ", NO_WORD, "", " millionths",
     "let clocks and drifts be estimated.", MILLIONTHS},
    {"the clocks", "against the first camera, ", NO_WORD, "", "", CLOCKS_NEXT, 0},
    {"rolling shutter", "its last row is ", LATER, " than its first by ", "",
     "hold the board still for each picture.", 0},
    {"focal length", "", LONGER, " than given by ", " %", CAMERA_NEXT, PERCENT},
    {"aspect fx / fy", "", LARGER, " than given by ", " %", CAMERA_NEXT, PERCENT},
    {"principal point", "off in x and y by ", NO_WORD, "", " px", CAMERA_NEXT, 1},
    {"distortion", "k1 and k2 are off by ", NO_WORD, "", "", CAMERA_NEXT, 1},
    {"mount", "it moved before placement ", NO_WORD, "", "",
     "calibrate what was before the move, and after it, apart.", 0},
    {"the board is bent", "out of its plane along x and y by ", NO_WORD, "", "",
     "put the board on a flat plate, or measure its points.", -1},
    {"the board is stretched", "its X is ", LONGER, " than its Y by ", " %",
     "measure the board along X and along Y.", PERCENT}};

static int is_clock(int32_t kind)
{
    return kind == RIGCAL_FAULT_CLOCK || kind == RIGCAL_FAULT_CLOCKS;
}

/* "the focal length of left" */
static void put_what(writer *w, const rigcal_fault *f)
{
    if (f->camera < 0) {
        put(w, WORDS[f->kind].what);
        return;
    }
    put(w, "the ");
    put(w, WORDS[f->kind].what);
    put(w, " of ");
    put_camera(w, f->camera);
}

/* Which way a fault goes: how large it is then has no sign. */
static rigcal_real put_way(writer *w, int32_t kind, rigcal_real value)
{
    const fault_words *const words = &WORDS[kind];
    if (words->more[0] == 0) {
        return value;
    }
    put(w, (value < 0) ? words->less : words->more);
    return RC_FABS(value);
}

/* A number of that kind, with its unit. */
static void put_value(writer *w, int32_t kind, rigcal_real value, rigcal_real sigma)
{
    rigcal_real scale = WORDS[kind].scale;
    const int is_time = !(scale > 0) && !(scale < 0), is_length = scale < 0;
    if (is_time || is_length) {
        scale = scale_or_1(is_time ? w->words->time_scale : w->words->length_scale);
    }
    if (value > 0 || value < 0) {
        put_measured(w, scale * value, scale * sigma);
    } else {
        put_rounded(w, scale * sigma);
    }
    if (is_time) {
        put_time_unit(w);
    } else if (is_length) {
        put_length_unit(w);
    } else {
        put(w, WORDS[kind].unit);
    }
}

/* How far something turned and shifted. */
static void put_move(writer *w, rigcal_real turn, rigcal_real shift)
{
    put_rounded(w, DEGREES * turn);
    put(w, " degrees and ");
    put_rounded(w, scale_or_1(w->words->length_scale) * shift);
    put_length_unit(w);
}

static rigcal_real length_of(const rigcal_real v[3])
{
    return RC_SQRT(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void put_clocks(writer *w)
{
    const rigcal_real *const clocks = w->found->clocks;
    const char *comma = "";
    for (int32_t c = 0; clocks != NULL && c < w->found->n_cameras; c++) {
        const rigcal_real sigma = clocks[w->found->n_cameras + c];
        if (sigma > 0) {
            put(w, comma);
            put_camera(w, c);
            put(w, "'s pictures are ");
            const rigcal_real by = put_way(w, RIGCAL_FAULT_CLOCK, clocks[c]);
            put(w, " by ");
            put_value(w, RIGCAL_FAULT_CLOCK, by, sigma);
            comma = ", ";
        }
    }
}

/* All of a fault but the end of the sentence. */
static void put_fault(writer *w, const rigcal_fault *f)
{
    put_what(w, f);
    put(w, ": ");
    put(w, WORDS[f->kind].by);
    if (f->kind == RIGCAL_FAULT_CLOCKS) {
        put_clocks(w);
    } else if (f->kind == RIGCAL_FAULT_MOVED) {
        put_number(w, (rigcal_real)f->placement, 0);
        put(w, ", by ");
        put_move(w, length_of(&f->value[0]), length_of(&f->value[3]));
    } else {
        const rigcal_real by = put_way(w, f->kind, f->value[0]);
        put(w, WORDS[f->kind].than);
        put_value(w, f->kind, by, f->sigma[0]);
        if (f->n > 1) {
            put(w, " and ");
            put_value(w, f->kind, f->value[1], f->sigma[1]);
        }
    }
}

/* ---- the sentences ----------------------------------------------------- */

static void say_agreement(writer *w)
{
    const rigcal_faults *const found = w->found;
    if ((found->bits & RIGCAL_FAULTS_NO_LOOP) != 0) {
        say(w, "No two cameras saw the same placements: the views cannot disagree, and "
               "nothing was tested.");
        return;
    }
    if (found->verdict == RIGCAL_RIG_AGREES) {
        put(w, "The views agree with one rig (");
    } else {
        put(w, "The views fit (");
        put_rounded(w, found->own_px);
        put(w, " px) but the rig does not (");
    }
    put_number(w, RC_SQRT(rc_max(found->F, 0)), 2);
    end_sentence(w, (found->verdict == RIGCAL_RIG_AGREES) ? " of the noise)."
                                                          : " times the noise).");
}

static void say_alike(writer *w, const rigcal_fault faults[])
{
    const rigcal_faults *const found = w->found;
    const char *comma = "With this recording it cannot be told from ";
    for (int32_t i = 1; i <= found->n_alike; i++) {
        if (faults[i].explains || !faults[0].explains) {
            put(w, comma);
            put_what(w, &faults[i]);
            comma = ", ";
        }
    }
    if (comma[1] == ' ') {
        end_sentence(w, ".");
    }
    if ((found->bits & RIGCAL_FAULTS_TWO_CAMERAS) != 0 &&
        (is_clock(faults[0].kind) || faults[0].kind == RIGCAL_FAULT_MOVED)) {
        say(w, "With two cameras it is one or the other.");
    }
}

static void say_fault(writer *w, const rigcal_fault faults[])
{
    const rigcal_faults *const found = w->found;
    if ((found->bits & RIGCAL_FAULTS_NAMED) == 0) {
        return;
    }
    put(w,
        (found->verdict == RIGCAL_RIG_EXPLAINED) ? "Most likely " : "One thing is wrong, ");
    put_fault(w, &faults[0]);
    if (found->verdict == RIGCAL_RIG_EXPLAINED) {
        end_sentence(w, ".");
        put(w, "That explains ");
        put_number(w, PERCENT * rc_min(found->explained, 1), 0);
        end_sentence(w, " % of it.");
    } else {
        end_sentence(w, (found->verdict == RIGCAL_RIG_FOUND)
                            ? "; that is certain, but it is not why the views disagree."
                            : "; that is certain, though the views hardly show it.");
    }
    say_alike(w, faults);
}

static void say_pattern(writer *w)
{
    const rigcal_faults *const found = w->found;
    if (found->verdict < RIGCAL_RIG_FOUND) {
        return;
    }
    if ((found->bits & RIGCAL_FAULTS_PATTERN) != 0) {
        put(w, "Neighbouring points err together (");
        put_number(w, found->pattern, 2);
        put(w, "; noise: 0.00 +- ");
        put_number(w, found->pattern_sigma, 2);
        end_sentence(w, "): the lens model, the board's coordinates or the detector, in "
                        "every view.");
        say(w, "Disagreement between views of 2 to 8 times the noise is to be expected "
               "from that alone.");
    }
    say(w, "None of the causes that can be tested explains it.");
    if ((found->bits & RIGCAL_FAULTS_ALONG_MOTION) != 0) {
        put_number(w, PERCENT * found->along, 0);
        put(w, " % of it lies along the board's motion: single time stamps are wrong (by "
               "some ");
        put_rounded(w, scale_or_1(w->words->time_scale) * found->along_time);
        put_time_unit(w);
        end_sentence(w, ").");
    }
}

static void say_untested(writer *w)
{
    const int32_t bits = w->found->bits;
    if ((bits & RIGCAL_FAULTS_NO_TIMES) != 0) {
        say(w, "Clocks could not be tested: no times are given.");
    } else if ((bits & RIGCAL_FAULTS_NO_NEIGHBOUR) != 0) {
        say(w, "Clocks could not be tested: no placement has a neighbour in time.");
    } else if ((bits & RIGCAL_FAULTS_NO_MOTION) != 0) {
        say(w, "Clocks could not be tested: the target stood still.");
    }
}

static void say_unseen(writer *w, const rigcal_fault *f)
{
    put_what(w, f);
    if (!f->is_seen) {
        end_sentence(w, ": this recording cannot show it.");
        return;
    }
    if (f->kind != RIGCAL_FAULT_CLOCKS && f->kind != RIGCAL_FAULT_MOVED) {
        put(w, ", off by ");
        put_value(w, f->kind, 0, RIGCAL_FAULT_DEVIATIONS * f->sigma[0]);
    }
    put(w, ", would go unseen; the largest such fault moves a camera by ");
    put_move(w, f->turn, f->shift);
    end_sentence(w, ".");
}

/* The one thing to do next. */
static const char *next_of(const rigcal_faults *found, const rigcal_fault faults[])
{
    const int is_reason =
        (found->bits & RIGCAL_FAULTS_NAMED) != 0 && found->verdict != RIGCAL_RIG_FOUND;
    if (is_reason) {
        return WORDS[faults[0].kind].next;
    }
    if ((found->bits & RIGCAL_FAULTS_NO_LOOP) != 0) {
        return "show the target where two cameras see it.";
    }
    if (found->verdict == RIGCAL_RIG_AGREES) {
        return "nothing.";
    }
    if ((found->bits & RIGCAL_FAULTS_PATTERN) != 0) {
        return "check the lens model, the board's coordinates and the detector.";
    }
    if ((found->bits & RIGCAL_FAULTS_ALONG_MOTION) != 0) {
        return "hold the board still for each picture, or trigger the cameras together.";
    }
    return ((found->bits & (RIGCAL_FAULTS_NO_TIMES | RIGCAL_FAULTS_NO_NEIGHBOUR)) != 0)
               ? "record three frames or more at each place, at most 0.1 s apart, with the "
                 "times of the frames."
               : "look which single views are wrong.";
}

/* ---- all of them ------------------------------------------------------- */

static rigcal_status check(const rigcal_faults *found, const rigcal_fault faults[],
                           const rigcal_faults_words *words)
{
    if (found->verdict < RIGCAL_RIG_AGREES || found->verdict > RIGCAL_RIG_UNEXPLAINED ||
        found->n < 0 || found->n_alike < 0 ||
        (found->n_alike > 0 && found->n_alike >= found->n) || found->n_cameras < 0 ||
        ((found->bits & RIGCAL_FAULTS_NAMED) != 0 && found->n < 1)) {
        return RIGCAL_ERR_RANGE;
    }
    if (!rc_all_finite(&found->F, 10) || !rc_is_finite(words->length_scale) ||
        !rc_is_finite(words->time_scale)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    for (int32_t c = 0; c < found->n_cameras; c++) {
        if (words->names != NULL && words->names[c] == NULL) {
            return RIGCAL_ERR_NULL;
        }
        if (found->clocks != NULL && !(rc_is_finite(found->clocks[c]) &&
                                       rc_is_finite(found->clocks[found->n_cameras + c]))) {
            return RIGCAL_ERR_NOT_FINITE;
        }
    }
    for (int32_t i = 0; i < found->n; i++) {
        if (faults[i].kind < 0 || faults[i].kind >= RIGCAL_FAULT_KINDS ||
            faults[i].camera < -1 || faults[i].camera >= found->n_cameras) {
            return RIGCAL_ERR_RANGE;
        }
        if (!rc_all_finite(faults[i].value, 2 * RIGCAL_FAULT_VALUES + 6)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_faults_text(char text[], size_t capacity, size_t *n_needed,
                                 const rigcal_faults *found, const rigcal_fault faults[],
                                 const rigcal_faults_words *words)
{
    if (text == NULL || found == NULL || faults == NULL || words == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check(found, faults, words);
    if (status != RIGCAL_OK) {
        return status;
    }
    writer w = {text, capacity, 0, 0, 1, found, words};
    say_agreement(&w);
    say_fault(&w, faults);
    say_pattern(&w);
    say_untested(&w);
    for (int32_t i = 0; words->with_unseen != 0 && i < found->n; i++) {
        say_unseen(&w, &faults[i]);
    }
    put(&w, "Next: ");
    say(&w, next_of(found, faults));
    if (capacity > 0) {
        text[w.whole] = 0;
    }
    if (n_needed != NULL) {
        *n_needed = w.n; /* a space less, and a 0 */
    }
    return (w.n <= capacity) ? RIGCAL_OK : RIGCAL_ERR_CAPACITY;
}
