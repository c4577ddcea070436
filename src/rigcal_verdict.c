#include "rc_linalg.h"

/* ---- constants --------------------------------------------------------- */

/* digits: the most digits of a number that are printed. */
enum { DIGITS_MOST = 9 };

/* 1: a number is printed with two digits if they are below this, otherwise with one. */
#define TWO_DIGITS_BELOW RC(1.95)

/* 1: larger numbers are printed as this one. */
#define NUMBER_MOST RC(999999999)

/* degrees: one radian has this many. */
#define DEGREES (180 / RC_PI)

/* percent: a whole has this many. */
#define PERCENT RC(100)

/* millionths in a whole: drifts are written in this unit. */
#define MILLIONTHS RC(1e6)

/* ---- a text that grows by whole sentences ------------------------------ */

typedef struct {
    char *text;
    size_t capacity, n, whole; /* bytes of the text; of the whole sentences that fit */
    int is_start;              /* 1: a sentence begins */
    const rigcal_faults *found;
    const rigcal_fault *fault; /* the fault that the sentence is about */
    const rigcal_faults_words *words;
} writer;

static void put_letter(writer *w, char letter)
{
    if (w->n < w->capacity) {
        w->text[w->n] = letter;
        if (w->is_start && letter >= 'a') { /* no name begins a sentence */
            w->text[w->n] = (char)(letter + ('A' - 'a'));
        }
    }
    w->is_start = 0;
    w->n++;
}

static void put(writer *w, const char *text)
{
    for (; *text != 0; text++) {
        put_letter(w, *text);
    }
}

/* Ends a sentence. It counts if there is also room for the final 0. */
static void end_sentence(writer *w)
{
    put_letter(w, '.');
    if (w->n < w->capacity) {
        w->whole = w->n;
    }
    put_letter(w, ' ');
    w->is_start = 1;
}

/* Writes x with this number of digits after the point. */
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

/* How many digits after the point show the first one or two digits of x. */
static int decimals_of(rigcal_real x)
{
    int decimals = 0;
    while (x > 0 && x < TWO_DIGITS_BELOW && decimals < DIGITS_MOST - 2) {
        x *= 10;
        decimals++;
    }
    return decimals;
}

/* Writes "12.3 +- 0.4". */
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

/* ---- the kinds of faults, and their units ------------------------------- */

/* The words of a fault. ~ ends a sentence. [this|that] is `this` if the fault's value is
 * not negative, otherwise `that`. % and a letter is replaced by put_thing. */
typedef struct {
    const char *what, *is, *next; /* the fault, how it shows, what to do */
} kind_words;

static const char CLOCKS_NEXT[] = "let the clocks be estimated~";
static const char STILL_NEXT[] = "hold the board still for each picture~";
static const char CAMERA_NEXT[] =
    "check that its intrinsics are its own, and calibrate them again~";

static const kind_words KINDS[RIGCAL_FAULT_KINDS] = {
    {"clock", "its pictures are [later|earlier] than their stamps by %v", CLOCKS_NEXT},
    {"clock", "it drifts by %v", "let clocks and drifts be estimated~"},
    {"the clocks", "against the first camera, %c", CLOCKS_NEXT},
    {"rolling shutter", "its last row is [later|earlier] than its first by %v", STILL_NEXT},
    {"focal length", "[longer|shorter] than given by %v", CAMERA_NEXT},
    {"aspect fx / fy", "[larger|smaller] than given by %v", CAMERA_NEXT},
    {"principal point", "off in x and y by %v", CAMERA_NEXT},
    {"distortion", "k1 and k2 are off by %v", CAMERA_NEXT},
    {"mount", "it moved before placement %b",
     "calibrate what was before the move, and after it, apart~"},
    {"the board is bent", "out of its plane along x and y by %v",
     "put the board on a flat plate, or measure its points~"},
    {"the board is stretched", "its X is [longer|shorter] than its Y by %v",
     "measure the board along X and along Y~"}};

enum { TIME, LENGTH, PART, MILLIONTH, PIXEL, NUMBER };

static const uint8_t UNIT_OF[RIGCAL_FAULT_KINDS] = {
    TIME, MILLIONTH, TIME, TIME, PART, PART, PIXEL, NUMBER, NUMBER, LENGTH, PART};

typedef struct {
    const char *name;
    rigcal_real scale;
} unit;

static const unit UNITS[] = {
    {"s", 1}, {"units", 1}, {"%", PERCENT}, {"millionths", MILLIONTHS}, {"px", 1}, {"", 1}};

/* The scale of a unit. *name is its name, which the caller may have set. */
static rigcal_real scale_of(const char **name, const writer *w, int which)
{
    const char *const given = (which == TIME) ? w->words->time : w->words->length;
    const rigcal_real scale =
        (which == TIME) ? w->words->time_scale : w->words->length_scale;
    *name = (which <= LENGTH && given != NULL) ? given : UNITS[which].name;
    return (which <= LENGTH && scale > 0) ? scale : UNITS[which].scale;
}

/* Writes value +- sigma, or sigma alone if value is 0. */
static void put_value(writer *w, int which, rigcal_real value, rigcal_real sigma)
{
    const char *name;
    const rigcal_real scale = scale_of(&name, w, which);
    if (value > 0 || value < 0) {
        put_measured(w, scale * value, scale * sigma);
    } else {
        put_rounded(w, scale * sigma);
    }
    if (which != NUMBER) {
        put_letter(w, ' ');
        put(w, name);
    }
}

/* ---- what stands in a sentence ----------------------------------------- */

static void put_camera(writer *w, int32_t camera)
{
    if (w->words->names != NULL) {
        put(w, w->words->names[camera]);
    } else {
        put(w, "camera ");
        put_number(w, (rigcal_real)camera, 0);
    }
}

/* Writes for example "the focal length of left". */
static void put_what(writer *w, const rigcal_fault *f)
{
    put(w, (f->camera < 0) ? "" : "the ");
    put(w, KINDS[f->kind].what);
    if (f->camera >= 0) {
        put(w, " of ");
        put_camera(w, f->camera);
    }
}

/* Writes how far something turned and shifted. */
static void put_move(writer *w, rigcal_real turn, rigcal_real shift)
{
    put_rounded(w, DEGREES * turn);
    put(w, " degrees and ");
    put_value(w, LENGTH, 0, shift);
}

/* Writes the placement where a camera moved, and how far it moved. */
static void put_break(writer *w)
{
    const rigcal_real *const d = w->fault->value;
    put_number(w, (rigcal_real)w->fault->placement, 0);
    put(w, ", by ");
    put_move(w, RC_SQRT(rc_vec3_dot(d, d)), RC_SQRT(rc_vec3_dot(&d[3], &d[3])));
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
            put(w, (clocks[c] < 0) ? "earlier by " : "later by ");
            put_value(w, TIME, RC_FABS(clocks[c]), sigma);
            comma = ", ";
        }
    }
}

/* Writes the size of a fault. It has no sign if the words state the direction. */
static void put_size(writer *w)
{
    const rigcal_fault *const f = w->fault;
    const int which = UNIT_OF[f->kind];
    const int has_way = which == TIME || which == PART;
    put_value(w, which, has_way ? RC_FABS(f->value[0]) : f->value[0], f->sigma[0]);
    if (f->n > 1) {
        put(w, " and ");
        put_value(w, which, f->value[1], f->sigma[1]);
    }
}

/* Writes the other faults that fit as well. */
static void put_alike(writer *w)
{
    const rigcal_fault *const first = w->fault;
    const char *comma = "With this recording it cannot be told from ";
    for (int32_t i = 1; i <= w->found->n_alike; i++) {
        if (first[i].explains || !first->explains) {
            put(w, comma);
            put_what(w, &first[i]);
            comma = ", ";
        }
    }
    if (comma[1] == ' ') {
        end_sentence(w);
    }
}

/* Writes the size of the fault that would go unseen. */
static void put_unseen(writer *w)
{
    const rigcal_fault *const f = w->fault;
    if (f->kind != RIGCAL_FAULT_CLOCKS && f->kind != RIGCAL_FAULT_MOVED) {
        put(w, ", off by ");
        put_value(w, UNIT_OF[f->kind], 0, RIGCAL_FAULT_DEVIATIONS * f->sigma[0]);
    }
}

static void put_more(writer *w, char thing)
{
    const rigcal_fault *const f = w->fault;
    switch (thing) {
    case 'b':
        put_break(w);
        break;
    case 'c':
        put_clocks(w);
        break;
    case 'm':
        put_move(w, f->turn, f->shift);
        break;
    case 't':
        put_value(w, TIME, 0, w->found->along_time);
        break;
    case 'u':
        put_unseen(w);
        break;
    case 'v':
        put_size(w);
        break;
    case 'w':
        put_what(w, f);
        break;
    case '2':
        put_alike(w);
        break;
    default:
        put_letter(w, thing);
        break;
    }
}

static void put_thing(writer *w, char thing)
{
    const rigcal_faults *const found = w->found;
    rigcal_real x = found->pattern;
    int decimals = 2;
    switch (thing) {
    case 'F':
        x = RC_SQRT(rc_max(found->F, 0));
        break;
    case 'p':
        break;
    case 's':
        x = found->pattern_sigma;
        break;
    case 'a':
        x = PERCENT * found->along;
        decimals = 0;
        break;
    case 'e':
        x = PERCENT * rc_min(found->explained, 1);
        decimals = 0;
        break;
    case 'o':
        x = found->own_px;
        decimals = decimals_of(x);
        break;
    default:
        put_more(w, thing);
        return;
    }
    put_number(w, x, decimals);
}

/* Writes a sentence, or several. %i stands for how the fault shows, and %n for what to do.
 * These are sentences too. */
static void tell(writer *w, const char *sentence)
{
    const char *rest = "";
    char skip_to = 0;
    for (; *sentence != 0 || *rest != 0; sentence++) {
        if (*sentence == 0) {
            sentence = rest;
            rest = "";
        }
        const char letter = *sentence;
        if (skip_to != 0) {
            if (letter == skip_to) {
                skip_to = 0;
            }
        } else if (letter == '[') {
            if (w->fault->value[0] < 0) {
                skip_to = '|';
            }
        } else if (letter == '|') {
            skip_to = ']';
        } else if (letter == '~') {
            end_sentence(w);
        } else if (letter != '%' && letter != ']') {
            put_letter(w, letter);
        } else if (letter == '%' && (*++sentence == 'i' || *sentence == 'n')) {
            const kind_words *const kind = &KINDS[w->fault->kind];
            rest = sentence + 1;
            sentence = ((*sentence == 'i') ? kind->is : kind->next) - 1;
        } else if (letter == '%') {
            put_thing(w, *sentence);
        }
    }
}

/* ---- the sentences ----------------------------------------------------- */

/* A sentence, and when it holds: for these verdicts, if all bits of `with` and none of
 * `without` are set. */
typedef struct {
    uint16_t verdicts, with, without;
    const char *sentence;
} rule;

#define OF(verdict) (1 << RIGCAL_RIG_##verdict)

enum {
    ALL = OF(AGREES) | OF(EXPLAINED) | OF(FOUND) | OF(UNEXPLAINED),
    OPEN = OF(FOUND) | OF(UNEXPLAINED),
    NAMED = RIGCAL_FAULTS_NAMED,
    PATTERN = RIGCAL_FAULTS_PATTERN,
    ALONG = RIGCAL_FAULTS_ALONG_MOTION,
    NO_TIMES = RIGCAL_FAULTS_NO_TIMES,
    ALONE = RIGCAL_FAULTS_NO_NEIGHBOUR,
    STILL = RIGCAL_FAULTS_NO_MOTION,
    NO_LOOP = RIGCAL_FAULTS_NO_LOOP,
    CLOCK_OR_MOVED = 1 << 14, /* not a bit of rigcal_faults: the kind of the first fault */
    TWO = RIGCAL_FAULTS_TWO_CAMERAS | CLOCK_OR_MOVED
};

/* The sentences of all rules that hold, in this order. What would go unseen follows
 * them. */
static const rule RULES[] = {
    {ALL, NO_LOOP, 0,
     "No two cameras saw the same placements: the views cannot disagree, and nothing was "
     "tested~"},
    {OF(AGREES), 0, NO_LOOP, "The views agree with one rig (%F of the noise)~"},
    {ALL - OF(AGREES), 0, NO_LOOP,
     "The views fit (%o px) but the rig does not (%F times the noise)~"},
    {OF(EXPLAINED), NAMED, 0, "Most likely %w: %i~That explains %e %% of it~"},
    {ALL - OF(EXPLAINED), NAMED, 0, "One thing is wrong, %w: %i; that is certain, "},
    {OF(FOUND), NAMED, 0, "but it is not why the views disagree~"},
    {OF(AGREES) | OF(UNEXPLAINED), NAMED, 0, "though the views hardly show it~"},
    {ALL, NAMED, 0, "%2"},
    {ALL, NAMED | TWO, 0, "With two cameras it is one or the other~"},
    {OPEN, PATTERN, 0,
     "Neighbouring points err together (%p; noise: 0.00 +- %s): the lens model, the "
     "board's coordinates or the detector, in every view~Disagreement between views of 2 "
     "to 8 times the noise is to be expected from that alone~"},
    {OPEN, 0, 0, "None of the causes that can be tested explains it~"},
    {OPEN, ALONG, 0,
     "%a %% of it lies along the board's motion: single time stamps are wrong (by some "
     "%t)~"}};

/* Only the first rule that holds is written. */
static const rule UNTESTED[] = {{ALL, NO_TIMES, 0, "no times are given~"},
                                {ALL, ALONE, 0, "no placement has a neighbour in time~"},
                                {ALL, STILL, 0, "the target stood still~"}};

static const char RECORD[] = "record three frames or more at each place, at most 0.1 s "
                             "apart, with the times of the frames~";

/* What to do next. Only the first rule that holds is written. */
static const rule NEXT[] = {
    {ALL - OF(FOUND), NAMED, 0, "%n"},
    {ALL, NO_LOOP, 0, "show the target where two cameras see it~"},
    {OF(AGREES), 0, 0, "nothing~"},
    {ALL, PATTERN, 0, "check the lens model, the board's coordinates and the detector~"},
    {ALL, ALONG, 0,
     "hold the board still for each picture, or trigger the cameras together~"},
    {ALL, NO_TIMES, 0, RECORD},
    {ALL, ALONE, 0, RECORD},
    {ALL, 0, 0, "look which single views are wrong~"}};

#define N_OF(table) (sizeof(table) / sizeof((table)[0]))

/* Writes the sentences of the rules that hold, at most `most`, each after `before`. */
static void tell_rules(writer *w, const char *before, const rule rules[], size_t n,
                       size_t most)
{
    int32_t bits = w->found->bits;
    if ((bits & NAMED) != 0 &&
        (w->fault->kind == RIGCAL_FAULT_CLOCK || w->fault->kind == RIGCAL_FAULT_CLOCKS ||
         w->fault->kind == RIGCAL_FAULT_MOVED)) {
        bits |= CLOCK_OR_MOVED;
    }
    for (size_t i = 0; i < n && most > 0; i++) {
        if ((rules[i].verdicts >> w->found->verdict & 1) != 0 &&
            (bits & rules[i].with) == rules[i].with && (bits & rules[i].without) == 0) {
            tell(w, before);
            tell(w, rules[i].sentence);
            most--;
        }
    }
}

static void tell_unseen(writer *w)
{
    for (int32_t i = 0; i < w->found->n; i++, w->fault++) {
        tell(w, w->fault->is_seen
                    ? "%w%u, would go unseen; the largest such fault moves a camera by %m~"
                    : "%w: this recording cannot show it~");
    }
    w->fault -= w->found->n;
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
        if (found->clocks != NULL && (!rc_is_finite(found->clocks[c]) ||
                                      !rc_is_finite(found->clocks[found->n_cameras + c]))) {
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
    writer w = {text, capacity, 0, 0, 1, found, faults, words};
    tell_rules(&w, "", RULES, N_OF(RULES), N_OF(RULES));
    tell_rules(&w, "Clocks could not be tested: ", UNTESTED, N_OF(UNTESTED), 1);
    if (words->with_unseen != 0) {
        tell_unseen(&w);
    }
    tell_rules(&w, "Next: ", NEXT, N_OF(NEXT), 1);
    if (capacity > 0) {
        text[w.whole] = 0;
    }
    if (n_needed != NULL) {
        *n_needed = w.n; /* the last space becomes the final 0 */
    }
    return (w.n <= capacity) ? RIGCAL_OK : RIGCAL_ERR_CAPACITY;
}
