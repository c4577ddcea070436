#include "cli_csv.h"

#include "cli_foreign.h"
#include "cli_input.h"
#include "cli_os.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if RIGCAL_USE_FLOAT
#define REAL_MAX ((double)FLT_MAX)
#else
#define REAL_MAX DBL_MAX
#endif

/* ==== complaints, memory ================================================== */

static int is_progress_shown, is_progress_in_lines;

void cli_progress_lines(void)
{
    is_progress_in_lines = 1;
}

void cli_progress_end(void)
{
    if (is_progress_shown) {
        fputs("\r\033[K", stderr);
        is_progress_shown = 0;
    }
}

void cli_progress(size_t n_views, const char *format, ...)
{
    enum { LEAST = 50 };
    va_list arguments;

    if (!is_progress_in_lines && (n_views < LEAST || !cli_os_is_terminal())) {
        return;
    }
    cli_progress_end();
    va_start(arguments, format);
    fputs(is_progress_in_lines ? "rigcal-progress: " : "rigcal: ", stderr);
    vfprintf(stderr, format, arguments);
    fputs(is_progress_in_lines ? "\n" : "", stderr);
    va_end(arguments);
    fflush(stderr);
    is_progress_shown = !is_progress_in_lines;
}

/* Messages that are held back until other messages have been shown. A 0 is followed by the
 * number of one that is made later. */
static char *held;
static size_t held_size, held_room;
static int is_holding;
static cli_later *say_numbered;
static const void *context_of_numbered;

void cli_hold(void)
{
    is_holding = 1;
}

void cli_release(void)
{
    char *const text = held;
    const size_t size = held_size;
    size_t at = 0, number;

    cli_progress_end();
    held = NULL;
    held_size = held_room = 0;
    is_holding = 0;
    while (text != NULL && at < size) {
        const char *zero = memchr(text + at, '\0', size - at);
        const size_t end = zero != NULL ? (size_t)(zero - text) : size;

        fwrite(text + at, 1, end - at, stderr);
        at = end;
        if (zero != NULL) {
            memcpy(&number, zero + 1, sizeof number);
            say_numbered(context_of_numbered, number);
            at += 1 + sizeof number;
        }
    }
    free(text);
}

/* Adds to the messages held. Returns 0 if memory is short: then all have been shown. */
static int hold(const char text[], size_t size)
{
    if (held == NULL || held_size + size > held_room) {
        const size_t room = held_size + size + held_size / 2 + 1024;
        char *larger = realloc(held, room);

        if (larger == NULL) {
            cli_release();
            return 0;
        }
        held = larger;
        held_room = room;
    }
    memcpy(held + held_size, text, size);
    held_size += size;
    return 1;
}

static void hold_text(const char *text)
{
    if (!is_holding || !hold(text, strlen(text))) {
        fputs(text, stderr);
    }
}

void cli_say_later(cli_later *say, const void *context, size_t number)
{
    char marked[1 + sizeof number] = {0};

    say_numbered = say;
    context_of_numbered = context;
    memcpy(marked + 1, &number, sizeof number);
    if (!is_holding || !hold(marked, sizeof marked)) {
        say(context, number);
    }
}

static void complain(const char *before, const char *format, va_list arguments,
                     const char *behind)
{
    va_list copy;
    char *text;
    int size;

    cli_progress_end();
    if (!is_holding) {
        fputs(before, stderr);
        vfprintf(stderr, format, arguments);
        fputs(behind, stderr);
        return;
    }
    va_copy(copy, arguments);
    size = vsnprintf(NULL, 0, format, copy);
    va_end(copy);
    text = cli_alloc((size_t)(size > 0 ? size : 0) + 1, 1);
    vsnprintf(text, (size_t)(size > 0 ? size : 0) + 1, format, arguments);
    hold_text(before);
    hold_text(text);
    hold_text(behind);
    cli_free(text);
}

void cli_say(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    complain("rigcal: ", format, arguments, "\n");
    va_end(arguments);
}

void cli_say_part(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    complain("", format, arguments, "");
    va_end(arguments);
}

void cli_fail(const char *format, ...)
{
    va_list arguments;

    cli_release();
    va_start(arguments, format);
    complain("rigcal: ", format, arguments, "\n");
    va_end(arguments);
    exit(CLI_USAGE);
}

char *cli_text(const char *format, ...)
{
    va_list arguments;
    char *text;
    int size;

    va_start(arguments, format);
    size = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    text = cli_alloc((size_t)(size > 0 ? size : 0) + 1, 1);
    va_start(arguments, format);
    vsnprintf(text, (size_t)(size > 0 ? size : 0) + 1, format, arguments);
    va_end(arguments);
    return text;
}

void csv_fail_line(const csv_table *table, size_t line, const char *format, ...)
{
    va_list arguments;

    cli_release();
    va_start(arguments, format);
    fprintf(stderr, "%s:%lu: ", table->path, (unsigned long)line);
    complain("", format, arguments, "\n");
    va_end(arguments);
    exit(CLI_USAGE);
}

void csv_fail(const csv_table *table, size_t row, const char *format, ...)
{
    va_list arguments;

    cli_release();
    va_start(arguments, format);
    fprintf(stderr, "%s:%lu: ", table->path, (unsigned long)table->lines[row]);
    complain("", format, arguments, "\n");
    va_end(arguments);
    exit(CLI_USAGE);
}

/* All memory that was allocated. It is freed at the end. */
static void **blocks;
static size_t n_blocks, room_for_blocks;

static void free_blocks(void)
{
    while (n_blocks > 0) {
        free(blocks[--n_blocks]);
    }
    free(blocks);
}

void *cli_alloc(size_t count, size_t size)
{
    void *memory = calloc(count > 0 ? count : 1, size);

    if (n_blocks == 0) {
        atexit(free_blocks);
    }
    if (n_blocks == room_for_blocks) {
        const size_t room = 2 * room_for_blocks + 64;
        void **list = realloc(blocks, room * sizeof *blocks);

        if (list == NULL) {
            free(memory);
            cli_fail("out of memory");
        }
        blocks = list;
        room_for_blocks = room;
    }
    if (memory == NULL) {
        cli_fail("out of memory");
    }
    blocks[n_blocks++] = memory;
    return memory;
}

/* The position of a block in the list. The search begins with the newest. */
static size_t find_block(const void *memory)
{
    size_t i = n_blocks;

    while (i > 0 && blocks[i - 1] != memory) {
        i--;
    }
    if (i == 0) {
        cli_fail(
            "memory that cli_alloc did not give is freed: this is a mistake in rigcal");
    }
    return i - 1;
}

void *cli_resize(void *memory, size_t count, size_t size)
{
    const size_t i = find_block(memory);
    void *resized =
        size > 0 && count > SIZE_MAX / size ? NULL : realloc(memory, count * size + 1);

    if (resized == NULL) {
        cli_fail("out of memory");
    }
    return blocks[i] = resized;
}

void cli_free(void *memory)
{
    const size_t i = find_block(memory);

    free(memory);
    blocks[i] = blocks[--n_blocks];
}

void *cli_keep(size_t size)
{
    enum { BLOCK = 65536 };
    static char *block;
    static size_t left;
    const size_t rounded = (size + sizeof(double) - 1) / sizeof(double) * sizeof(double);

    if (rounded > left) {
        left = rounded > BLOCK ? rounded : BLOCK;
        block = cli_alloc(left, 1);
    }
    block += rounded;
    left -= rounded;
    return block - rounded;
}

/* ==== the file, its lines, its fields ===================================== */

/* A file that is read line by line. */
struct csv_source {
    FILE *file;
    char *text; /* text that was read but not used yet: from `begin` to `end` */
    size_t room, begin, end;
    size_t line; /* number of the last line that was handed out */
    int is_over; /* whether the end of the file was read */
};

/* Reads on until the buffer is full. */
static void fill(const csv_table *table)
{
    csv_source *s = table->source;

    memmove(s->text, s->text + s->begin, s->end - s->begin);
    s->end -= s->begin;
    s->begin = 0;
    if (s->end == s->room) {
        s->room *= 2;
        s->text = cli_resize(s->text, s->room + 1, 1);
    }
    s->end += fread(s->text + s->end, 1, s->room - s->end, s->file);
    if (ferror(s->file)) {
        cli_fail("cannot read %s: %s", table->path, strerror(errno));
    }
    s->is_over = s->end < s->room;
}

/* Makes the line from text to stop a string, without its CR. Refuses control characters: a
 * file with them is not text. */
static void end_line(const csv_table *table, size_t line, const char *text, char *stop)
{
    const char *c;

    if (stop > text && stop[-1] == '\r') {
        stop--;
    }
    *stop = '\0';
    for (c = text; c < stop; c++) {
        if (((unsigned char)*c < ' ' && *c != '\t') || *c == 0x7f) {
            csv_fail_line(table, line,
                          "byte %u does not belong in text: is this a CSV file?",
                          (unsigned)(unsigned char)*c);
        }
    }
}

static int is_blank(const char *text)
{
    return text[strspn(text, " \t")] == '\0';
}

static size_t count_of(char wanted, const char *text, const char *end)
{
    size_t count = 0;

    for (; text < end; text++) {
        count += *text == wanted;
    }
    return count;
}

/* The next line that is not blank, as a string that is valid until the next call. NULL:
 * there is none. */
static char *next_line(const csv_table *table)
{
    csv_source *s = table->source;
    char *text, *newline, *stop;

    do {
        newline = memchr(s->text + s->begin, '\n', s->end - s->begin);
        while (newline == NULL && !s->is_over) {
            fill(table);
            newline = memchr(s->text, '\n', s->end);
        }
        if (newline == NULL && s->begin == s->end) {
            return NULL;
        }
        text = s->text + s->begin;
        stop = newline != NULL ? newline : s->text + s->end;
        s->begin = (size_t)(stop - s->text) + (newline != NULL ? 1 : 0);
        s->line++;
        end_line(table, s->line, text, stop);
    } while (is_blank(text));
    return text;
}

static void cut_fields(char *fields[], char *text)
{
    char *comma;

    *fields = text;
    while ((comma = strchr(*fields, ',')) != NULL) {
        *comma = '\0';
        *++fields = comma + 1;
    }
}

static void check_fields(const csv_table *table, size_t line, const char *text)
{
    const size_t count = 1 + count_of(',', text, text + strlen(text));

    if (count != table->n_columns) {
        csv_fail_line(table, line,
                      "%lu field%s where the header has %lu: look for a comma too few "
                      "or too many, or a decimal comma",
                      (unsigned long)count, count == 1 ? "" : "s",
                      (unsigned long)table->n_columns);
    }
}

static char *copy_of(const char *text)
{
    const size_t size = strlen(text) + 1;

    return memcpy(cli_alloc(size, 1), text, size);
}

static void read_header(csv_table *table)
{
    char *text = next_line(table);

    if (text == NULL) {
        csv_fail_line(table, 1, "there is no header line: the file is empty");
    }
    table->header_line = table->source->line;
    table->n_columns = 1 + count_of(',', text, text + strlen(text));
    table->columns = cli_alloc(table->n_columns, sizeof *table->columns);
    cut_fields(table->columns, copy_of(text));
}

void csv_open(csv_table *table, const char *path)
{
    enum { ROOM = 65536 };
    static const char BYTE_ORDER_MARK[] = "\xef\xbb\xbf";
    csv_source *s = cli_alloc(1, sizeof *s);
    const char *foreign;

    memset(table, 0, sizeof *table);
    table->path = path;
    table->source = s;
    s->room = ROOM;
    s->text = cli_alloc(s->room + 1, 1);
    s->file = cli_os_open(path);
    if (s->file == NULL) {
        cli_fail("cannot read %s: %s", path, strerror(errno));
    }
    fill(table);
    if (s->end >= 3 && strncmp(s->text, BYTE_ORDER_MARK, 3) == 0) {
        s->begin = 3;
    }
    foreign = cli_foreign(s->text + s->begin, s->end - s->begin);
    if (foreign != NULL) {
        csv_fail_line(table, 1, "%s", foreign);
    }
    read_header(table);
    table->cells = cli_alloc(table->n_columns, sizeof *table->cells);
    table->lines = cli_alloc(1, sizeof *table->lines);
}

/* The next row as a string that is valid until the next call. NULL: there is none. */
static char *next_row(csv_table *table)
{
    csv_source *s = table->source;
    char *text = next_line(table);

    if (text != NULL) {
        check_fields(table, s->line, text);
        table->n_rows++;
        return text;
    }
    if (table->n_rows == 0) {
        csv_fail_line(table, table->header_line,
                      "there are no data lines after the header");
    }
    fclose(s->file);
    cli_free(s->text);
    cli_free(s);
    table->source = NULL;
    return NULL;
}

int csv_next(csv_table *table)
{
    char *text = next_row(table);

    if (text == NULL) {
        return 0;
    }
    table->lines[0] = table->source->line;
    cut_fields(table->cells, text);
    return 1;
}

void csv_read(csv_table *table, const char *path)
{
    size_t room = 1;
    char *text;

    csv_open(table, path);
    while ((text = next_row(table)) != NULL) {
        const size_t row = table->n_rows - 1;

        if (row == room) {
            room *= 2;
            table->lines = cli_resize(table->lines, room, sizeof *table->lines);
            table->cells =
                cli_resize(table->cells, room * table->n_columns, sizeof *table->cells);
        }
        table->lines[row] = table->source->line;
        cut_fields(table->cells + row * table->n_columns, copy_of(text));
    }
}

/* ==== columns, cells ====================================================== */

static size_t find_column(const csv_table *table, const char *name)
{
    size_t column, found = CSV_NONE;

    for (column = 0; column < table->n_columns; column++) {
        if (strcmp(table->columns[column], name) != 0) {
            continue;
        }
        if (found != CSV_NONE) {
            csv_fail_line(table, table->header_line,
                          "column %s is there more than once: leave one", name);
        }
        found = column;
    }
    return found;
}

/* Refuses a column whose name is nearly this one. Otherwise it would be ignored without a
 * message. */
static void refuse_alike(const csv_table *table, const char *name)
{
    size_t column;

    for (column = 0; column < table->n_columns; column++) {
        if (cli_look_alike(table->columns[column], name)) {
            csv_fail_line(table, table->header_line, "column \"%s\" must be spelled %s",
                          table->columns[column], name);
        }
    }
}

size_t csv_optional(const csv_table *table, const char *name)
{
    const size_t column = find_column(table, name);

    if (column == CSV_NONE && table->form != NULL) {
        refuse_alike(table, name);
    }
    return column;
}

size_t csv_column(const csv_table *table, const char *name)
{
    const size_t column = csv_optional(table, name);
    const char *form;

    if (column != CSV_NONE) {
        return column;
    }
    if (table->form == NULL) {
        csv_fail_line(table, table->header_line, "there is no column %s", name);
    }
    form = cli_form(table);
    if (form != NULL && strcmp(form, table->form) != 0) {
        csv_fail_line(table, table->header_line,
                      "there is no column %s: this looks like %s, where %s is wanted", name,
                      form, table->form);
    }
    csv_fail_line(table, table->header_line,
                  "there is no column %s: examples/data/FORMAT.md lists those of %s", name,
                  table->form);
}

static const char *cell(const csv_table *table, size_t row, size_t column)
{
    const char *text = table->cells[row * table->n_columns + column];

    if (*text == '\0') {
        csv_fail(table, row, "column %s is empty: fill it in, or leave the line out",
                 table->columns[column]);
    }
    return text;
}

/* strtod would also accept blanks before the number, "inf", "nan" and hexadecimal. */
static int looks_decimal(const char *text)
{
    if (*text == '+' || *text == '-') {
        text++;
    }
    if (text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) {
        return 0;
    }
    return *text == '.' || (*text >= '0' && *text <= '9');
}

const char *cli_number(double *value, const char **problem, const char *text)
{
    char *end;

    *problem = NULL;
    if (!looks_decimal(text)) {
        *problem = "is not a number";
        return text;
    }
    *value = strtod(text, &end);
    if (end == text) {
        *problem = "is not a number";
    } else if (!(fabs(*value) <= REAL_MAX)) {
        *problem = "is too large";
    }
    return end;
}

double csv_number(const csv_table *table, size_t row, size_t column)
{
    const char *text = cell(table, row, column);
    const char *problem, *end;
    double value = 0;

    end = cli_number(&value, &problem, text);
    if (problem == NULL && *end != '\0') {
        problem = "is not a number";
    }
    if (problem != NULL) {
        csv_fail(table, row, "column %s: \"%s\" %s", table->columns[column], text, problem);
    }
    return value;
}

rigcal_real csv_real(const csv_table *table, size_t row, size_t column)
{
    return column == CSV_NONE ? 0 : (rigcal_real)csv_number(table, row, column);
}

int32_t csv_whole(const csv_table *table, size_t row, size_t column, int32_t least,
                  int32_t most)
{
    const double value = csv_number(table, row, column);

    if (!(value >= least && value <= most && floor(value) >= value)) {
        csv_fail(table, row, "column %s: \"%s\" is not a whole number from %ld to %ld",
                 table->columns[column], cell(table, row, column), (long)least, (long)most);
    }
    return (int32_t)value;
}

const char *csv_id(const csv_table *table, size_t row, size_t column)
{
    const char *text = cell(table, row, column);

    if (strpbrk(text, " \t\"") != NULL) {
        csv_fail(table, row,
                 "column %s: a name must have no blanks and no quotes, as [%s] has",
                 table->columns[column], text);
    }
    return text;
}
