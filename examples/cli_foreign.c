#include "cli_foreign.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FORMAT "examples/data/FORMAT.md"

/* A format, and what to do with it. */
typedef struct {
    const char *what, *advice, *section; /* NULL: rigcal cannot use such files */
} format;

#define COPY_CAMERA "copy its numbers into a cameras.csv"

/* ==== bytes at the beginning ============================================== */

typedef struct {
    const char *bytes;
    size_t at, length;
    format is;
} magic;

/* clang-format off */
#define MAGIC(bytes, at) bytes, at, sizeof(bytes) - 1
#define PICTURE                                                                \
    {                                                                          \
        "a picture",                                                           \
        "rigcal finds no points in images, so give it their coordinates as "   \
        "CSV", "What you give"                                                 \
    }
#define ARCHIVE(what)                                                          \
    {                                                                          \
        what, "unpack it, and give the CSV file that is in it", NULL           \
    }
#define DATA_FILE(what)                                                        \
    {                                                                          \
        what, "write what it holds as CSV, from the program that made it",     \
            "What you give"                                                    \
    }

static const magic MAGICS[] = {
    {MAGIC("PK\003\004", 0),
     {"a spreadsheet (.xlsx, .ods) or another zip archive",
      "save the sheet as CSV, separated by commas", "Tables of other forms"}},
    {MAGIC("\xd0\xcf\x11\xe0", 0),
     {"an old spreadsheet (.xls)",
      "save the sheet as CSV, separated by commas", "Tables of other forms"}},
    {MAGIC("\xff\xfe\0\0", 0),
     {"text in UTF-32", "save it as UTF-8", "Tables of other forms"}},
    {MAGIC("\xff\xfe", 0),
     {"text in UTF-16", "save it as UTF-8", "Tables of other forms"}},
    {MAGIC("\xfe\xff", 0),
     {"text in UTF-16", "save it as UTF-8", "Tables of other forms"}},
    {MAGIC("\0\0\xfe\xff", 0),
     {"text in UTF-32", "save it as UTF-8", "Tables of other forms"}},
    {MAGIC("MATLAB 5.0 MAT-file", 0),
     {"a MATLAB .mat file", "write the camera's numbers into a cameras.csv",
      "MATLAB"}},
    {MAGIC("\x89HDF\r\n", 0),
     {"an HDF5 file, as MATLAB's .mat files of version 7.3 are",
      "write what it holds as CSV", "MATLAB"}},
    {MAGIC("%PDF-", 0), DATA_FILE("a PDF document")},
    {MAGIC("\x89PNG\r\n", 0), PICTURE},
    {MAGIC("\xff\xd8\xff", 0), PICTURE},
    {MAGIC("GIF8", 0), PICTURE},
    {MAGIC("II*\0", 0), PICTURE},
    {MAGIC("MM\0*", 0), PICTURE},
    {MAGIC("WEBP", 8), PICTURE},
    {MAGIC("\x93NUMPY", 0), DATA_FILE("a NumPy .npy file")},
    {MAGIC("SQLite format 3", 0),
     DATA_FILE("an SQLite database, as ROS 2 bags and COLMAP's databases are")},
    {MAGIC("#ROSBAG", 0), DATA_FILE("a ROS bag")},
    {MAGIC("\x89MCAP0", 0), DATA_FILE("an MCAP recording")},
    {MAGIC("\x1f\x8b", 0), ARCHIVE("a gzip archive")},
    {MAGIC("BZh", 0), ARCHIVE("a bzip2 archive")},
    {MAGIC("\xfd" "7zXZ", 0), ARCHIVE("an xz archive")},
    {MAGIC("7z\xbc\xaf", 0), ARCHIVE("a 7z archive")},
    {MAGIC("RIGC", 0),
     {"a calibration stored by rigcal_store_save",
      "read it with rigcal_store_load; the command line takes CSV", "What you give"}},
};
/* clang-format on */

static const format *by_bytes(const char *text, size_t length)
{
    static const format UTF_16 = {"text in UTF-16", "save it as UTF-8",
                                  "Tables of other forms"};
    size_t i;

    for (i = 0; i < sizeof MAGICS / sizeof MAGICS[0]; i++) {
        const magic *m = &MAGICS[i];

        if (m->at + m->length <= length && memcmp(text + m->at, m->bytes, m->length) == 0) {
            return &m->is;
        }
    }
    /* Text without a byte order mark: every second byte of plain letters is 0. */
    if (length >= 4 && (text[0] == '\0') != (text[1] == '\0') &&
        (text[0] == '\0') == (text[2] == '\0') && (text[1] == '\0') == (text[3] == '\0')) {
        return &UTF_16;
    }
    return NULL;
}

/* ==== words in a text ===================================================== */

static const format OPENCV_XML = {"OpenCV's XML (FileStorage)", COPY_CAMERA, "OpenCV"};
static const format OPENCV_JSON = {"OpenCV's JSON (FileStorage)", COPY_CAMERA, "OpenCV"};
static const format OPENCV_YAML = {"OpenCV's YAML (FileStorage)", COPY_CAMERA, "OpenCV"};
static const format KALIBR = {"Kalibr's camchain YAML", COPY_CAMERA, "Kalibr"};
static const format ROS = {"ROS's camera_info YAML", COPY_CAMERA, "ROS"};
static const format ROS_INI = {"ROS's camera calibration in INI form", COPY_CAMERA, "ROS"};
static const format COLMAP = {"COLMAP's text", COPY_CAMERA, "COLMAP, Bundler"};
static const format BUNDLER = {"a Bundler file", COPY_CAMERA, "COLMAP, Bundler"};
static const format VISUAL_SFM = {"a VisualSFM .nvm file", COPY_CAMERA, "COLMAP, Bundler"};
static const format MATLAB_TEXT = {"Calib_Results.m of the MATLAB toolbox", COPY_CAMERA,
                                   "MATLAB"};
static const format MRCAL = {"an mrcal camera model", COPY_CAMERA, "JSON, TOML and others"};
static const format JSON = {"JSON", COPY_CAMERA, "JSON, TOML and others"};
static const format TOML = {"TOML or INI", COPY_CAMERA, "JSON, TOML and others"};
static const format YAML = {"YAML", COPY_CAMERA, "JSON, TOML and others"};
static const format XML = {"XML", COPY_CAMERA, "JSON, TOML and others"};
static const format LFS_POINTER = {"a pointer of Git LFS, not the file itself",
                                   "run git lfs pull", NULL};
static const format WEB_PAGE = {
    "a web page", "download the file itself, not the page that shows it", NULL};
static const format OLD_LINE_ENDS = {"text with the line ends of old Macs (CR)",
                                     "save it with line ends LF or CR LF",
                                     "Tables of other forms"};
static const format QUOTES = {"CSV with its names in quotes", "write it without quotes",
                              "Tables of other forms"};
static const format SEMICOLONS = {
    "a table separated by semicolons",
    "separate its fields by commas, and write numbers with a decimal point",
    "Tables of other forms"};
static const format TABS = {"a table separated by tabs", "separate its fields by commas",
                            "Tables of other forms"};
static const format BLANKS = {"a table separated by blanks",
                              "separate its fields by commas", "Tables of other forms"};

/* A format is recognised by the first pattern that is found: at the begin of the text,
 * after lines that begin with # and blanks, or at the begin of any line. */
typedef struct {
    int where;
    const char *pattern; /* see matches_at */
    const format *is;
} words;

enum { BEGINS, BEHIND_COMMENTS, HAS };

static const words WORDS[] = {
    {BEGINS, "version https://git-lfs", &LFS_POINTER},
    {BEGINS, "<(html|!doctype html)", &WEB_PAGE},
    {HAS, "<opencv_storage", &OPENCV_XML},
    {HAS, "\"type_id\" *: *\"opencv", &OPENCV_JSON},
    {BEGINS, "%yaml:", &OPENCV_YAML},
    {HAS, "!!opencv-", &OPENCV_YAML},
    {HAS, "^ *(distortion_coeffs|T_cn_cnm1|cam_overlaps|intrinsics) *:", &KALIBR},
    {HAS, "# oST version", &ROS_INI},
    {HAS,
     "^ *(camera_matrix|distortion_coefficients|distortion_model|"
     "projection_matrix) *:",
     &ROS},
    {BEGINS, "# (camera|image|3D point|rig calib|frame) list with", &COLMAP},
    {BEGINS, "[0-9]+ [a-z_]*(PINHOLE|RADIAL|OPENCV|FOV|FISHEYE)[a-z_]* [0-9]+ [0-9]+ ",
     &COLMAP},
    {BEGINS, "# bundle file", &BUNDLER},
    {BEGINS, "NVM_V3", &VISUAL_SFM},
    {HAS, "[\"']lensmodel[\"'] *:", &MRCAL},
    {HAS, "^ *fc *= *[[]", &MATLAB_TEXT},
    {BEGINS, "<[?!a-z]", &XML},
    {BEGINS, "{", &JSON},
    {BEGINS, "[[][ \t\r\n\v\f]*[[{\"0-9-]", &JSON},
    {HAS, "^[[][a-z0-9_. \"-]+][ \t\r\n\v\f]*$", &TOML},
    {BEHIND_COMMENTS, "(---|%yaml)", &YAML},
    {BEHIND_COMMENTS, "[a-z_][a-z0-9_-]*: ", &YAML},
    {BEHIND_COMMENTS, "[a-z_][a-z0-9_-]*:\r?$", &YAML},
    {BEGINS, "\"[^\",]*\",", &QUOTES},
    {BEGINS, "[^,;]+;[^,]*$", &SEMICOLONS},
    {BEGINS, "[^,\t]+\t[^,]*$", &TABS},
    {BEGINS, "(frame|camera|point|fx|u|v) [^,]*$", &BLANKS},
    {BEGINS, "[^,]* (frame|camera|point|fx|u|v) [^,]*$", &BLANKS},
};

static int small(char c)
{
    return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : (unsigned char)c;
}

/* The end of the part of a pattern that matches one character: the character itself, or a
 * set in brackets. */
static const char *end_of_one(const char *pattern)
{
    if (*pattern == '[') {
        pattern += pattern[1] == '^' ? 2 : 1;
        pattern = strchr(pattern + 1, ']'); /* the first may be ] */
    }
    return pattern + 1;
}

/* Whether that part matches the character. Capitals match small letters. [^a] matches any
 * other character but the end of a line. */
static int matches_one(const char *pattern, const char *end, char character)
{
    const int c = small(character);
    int is_other, is_in = 0;

    if (*pattern != '[' || c == '\0') {
        return c != '\0' && small(*pattern) == c;
    }
    pattern++;
    is_other = *pattern == '^';
    for (pattern += is_other; pattern < end - 1; pattern++) {
        if (pattern[1] == '-' && pattern + 2 < end - 1) {
            is_in |= c >= small(pattern[0]) && c <= small(pattern[2]);
            pattern += 2;
        } else {
            is_in |= c == small(*pattern);
        }
    }
    return is_other ? !is_in && c != '\n' : is_in;
}

static int matches_at(const char *pattern, const char *text, const char *at);

/* Matches (one|other) and the rest of the pattern. */
static int matches_words(const char *pattern, const char *text, const char *at)
{
    const char *rest = strchr(pattern, ')') + 1;

    do {
        size_t n = 0;

        pattern++;
        while (pattern[n] != '|' && pattern[n] != ')' &&
               small(pattern[n]) == small(at[n])) {
            n++;
        }
        if ((pattern[n] == '|' || pattern[n] == ')') && matches_at(rest, text, at + n)) {
            return 1;
        }
        pattern += strcspn(pattern, "|)");
    } while (*pattern == '|');
    return 0;
}

/* Whether the text matches at this place. A pattern is made of characters and sets: [a-z],
 * [^a-z]. After each may stand how often it is wanted: any number of times (*), once or
 * more (+), 0 times or once (?). (one|other) is one of the words; ^ and $ are the begin and
 * the end of a line. The function calls itself at most once for each part of the
 * pattern. */
static int matches_at(const char *pattern, const char *text, const char *at)
{
    const char *end;
    size_t n = 0, least, most;

    if (*pattern == '\0') {
        return 1;
    }
    if (*pattern == '^') {
        return (at == text || at[-1] == '\n') && matches_at(pattern + 1, text, at);
    }
    if (*pattern == '$' && pattern[1] == '\0') {
        return *at == '\0' || *at == '\n';
    }
    if (*pattern == '(') {
        return matches_words(pattern, text, at);
    }
    end = end_of_one(pattern);
    least = *end != '*' && *end != '?';
    most = *end == '*' || *end == '+' ? (size_t)-1 : 1;
    while (n < most && matches_one(pattern, end, at[n])) {
        n++;
    }
    end += *end == '*' || *end == '+' || *end == '?';
    for (n++; n-- > least;) {
        if (matches_at(end, text, at + n)) {
            return 1;
        }
    }
    return 0;
}

static const char *behind_comments(const char *text)
{
    while (*text == '#' && strchr(text, '\n') != NULL) {
        text = strchr(text, '\n');
        text += strspn(text, " \t\r\n\v\f");
    }
    return text;
}

static int matches(const words *w, const char *text)
{
    const char *at;

    if (w->where != HAS) {
        at = w->where == BEGINS ? text : behind_comments(text);
        return matches_at(w->pattern, text, at);
    }
    for (at = text; *at != '\0'; at++) {
        if (matches_at(w->pattern, text, at)) {
            return 1;
        }
    }
    return 0;
}

/* Whether the header has one of rigcal's key columns. */
static int is_ours(const char *text)
{
    static const char *const KEYS[] = {"camera", "frame", "camera_a"};
    const char *end = text + strcspn(text, "\r\n");
    size_t i, length;

    for (; text < end; text += length + 1) {
        length = strcspn(text, ",\r\n");
        for (i = 0; i < sizeof KEYS / sizeof KEYS[0]; i++) {
            if (length == strlen(KEYS[i]) && strncmp(text, KEYS[i], length) == 0) {
                return 1;
            }
        }
    }
    return 0;
}

static const format *by_words(const char *text)
{
    size_t i;

    text += strspn(text, " \t\r\n");
    if (strchr(text, '\r') != NULL && strchr(text, '\n') == NULL) {
        return &OLD_LINE_ENDS;
    }
    if (is_ours(text)) {
        return NULL;
    }
    for (i = 0; i < sizeof WORDS / sizeof WORDS[0]; i++) {
        if (matches(&WORDS[i], text)) {
            return WORDS[i].is;
        }
    }
    return NULL;
}

const char *cli_foreign(const char *text, size_t length)
{
    enum { LOOKED_AT = 65536 };
    const size_t part = length < LOOKED_AT ? length : LOOKED_AT;
    const format *is = by_bytes(text, part);
    char *copy = cli_alloc(LOOKED_AT + 1, 1);

    if (is == NULL) {
        memcpy(copy, text, part);
        is = by_words(copy);
    }
    if (is == NULL) {
        return NULL;
    }
    snprintf(copy, LOOKED_AT, "this looks like %s: %s", is->what, is->advice);
    if (is->section != NULL) {
        snprintf(copy + strlen(copy), LOOKED_AT - strlen(copy), "; see \"%s\" in " FORMAT,
                 is->section);
    }
    return copy;
}

/* ==== our own files ======================================================= */

const char *cli_form(const csv_table *table)
{
    static const struct {
        const char *form, *columns[3];
    } FORMS[] = {
        {"residuals.csv", {"camera", "du", "dv"}},
        {"poses.csv", {"camera", "frame", "R11"}},
        {"rig.csv", {"camera", "R11", "tx"}},
        {"targets.csv", {"frame", "R11", "tx"}},
        {"pairs.csv", {"camera_a", "camera_b", "R11"}},
        {"cameras.csv", {"camera", "width", "fx"}},
        {"observations.csv", {"camera", "u", "v"}},
        {"times.csv", {"frame", "camera", "time_s"}},
        {"what rigcal triangulate prints", {"frame", "point", "ncams"}},
    };
    size_t i, k;

    for (i = 0; i < sizeof FORMS / sizeof FORMS[0]; i++) {
        for (k = 0; k < 3 && csv_optional(table, FORMS[i].columns[k]) != CSV_NONE; k++) {
        }
        if (k == 3) {
            return FORMS[i].form;
        }
    }
    return NULL;
}
