#define _XOPEN_SOURCE 700

#include "cli_csv.h"

#include "cli_foreign.h"
#include "cli_input.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#if RIGCAL_USE_FLOAT
#define REAL_MAX ((double)FLT_MAX)
#else
#define REAL_MAX DBL_MAX
#endif

/* ==== complaints, memory ================================================== */

static int is_progress_shown;

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

    if (n_views < LEAST || !isatty(STDERR_FILENO)) {
        return;
    }
    cli_progress_end();
    va_start(arguments, format);
    fputs("rigcal: ", stderr);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fflush(stderr);
    is_progress_shown = 1;
}

static void complain(const char *format, va_list arguments)
{
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
}

void cli_say(const char *format, ...)
{
    va_list arguments;

    cli_progress_end();
    va_start(arguments, format);
    fputs("rigcal: ", stderr);
    complain(format, arguments);
    va_end(arguments);
}

void cli_say_part(const char *format, ...)
{
    va_list arguments;

    cli_progress_end();
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
}

void cli_fail(const char *format, ...)
{
    va_list arguments;

    cli_progress_end();
    va_start(arguments, format);
    fputs("rigcal: ", stderr);
    complain(format, arguments);
    va_end(arguments);
    exit(CLI_USAGE);
}

CLI_NORETURN static void fail_line(const csv_table *table, size_t line, const char *format,
                                   ...) CLI_PRINTF(3, 4);

static void fail_line(const csv_table *table, size_t line, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    fprintf(stderr, "%s:%lu: ", table->path, (unsigned long)line);
    complain(format, arguments);
    va_end(arguments);
    exit(CLI_USAGE);
}

void csv_fail(const csv_table *table, size_t row, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    fprintf(stderr, "%s:%lu: ", table->path, (unsigned long)table->lines[row]);
    complain(format, arguments);
    va_end(arguments);
    exit(CLI_USAGE);
}

/* All memory there is, to be freed at the end. */
static void **blocks;
static size_t n_blocks;

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
    void **list = realloc(blocks, (n_blocks + 1) * sizeof *blocks);

    if (n_blocks == 0) {
        atexit(free_blocks);
    }
    if (list != NULL) {
        blocks = list;
        blocks[n_blocks++] = memory;
    }
    if (memory == NULL || list == NULL) {
        cli_fail("out of memory");
    }
    return memory;
}

/* ==== the file, its lines, its fields ===================================== */

/* The whole file and a NUL behind it. */
static char *read_all(const char *path, size_t *length)
{
    size_t room = 65536;
    char *text = cli_alloc(room, 1), *larger;
    FILE *file = fopen(path, "rb");

    if (file == NULL) {
        cli_fail("cannot read %s: %s", path, strerror(errno));
    }
    *length = fread(text, 1, room, file);
    while (*length == room) {
        larger = cli_alloc(2 * room, 1);
        memcpy(larger, text, room);
        text = larger;
        room *= 2;
        *length += fread(text + *length, 1, room - *length, file);
    }
    if (ferror(file)) {
        cli_fail("cannot read %s: %s", path, strerror(errno));
    }
    fclose(file);
    text[*length] = '\0';
    return text;
}

/* Makes a string of the line from text to stop, without its CR. Control
 * characters are refused: they tell a file that is no text. */
static void end_line(const csv_table *table, size_t line, const char *text, char *stop)
{
    const char *c;

    if (stop > text && stop[-1] == '\r') {
        stop--;
    }
    *stop = '\0';
    for (c = text; c < stop; c++) {
        if (((unsigned char)*c < ' ' && *c != '\t') || *c == 0x7f) {
            fail_line(table, line, "byte %u does not belong in text: is this a CSV file?",
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

/* Lists the lines that are not blank, the header first. Returns how many. */
static size_t cut_lines(csv_table *table, char *starts[], char *text, char *end)
{
    size_t line, count = 0;

    for (line = 1; text != NULL; line++) {
        char *newline = memchr(text, '\n', (size_t)(end - text));

        end_line(table, line, text, newline != NULL ? newline : end);
        if (!is_blank(text)) {
            table->lines[count] = line;
            starts[count++] = text;
        }
        text = newline != NULL ? newline + 1 : NULL;
    }
    return count;
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
        fail_line(table, line,
                  "%lu field%s where the header has %lu: look for a comma too few "
                  "or too many, or a decimal comma",
                  (unsigned long)count, count == 1 ? "" : "s",
                  (unsigned long)table->n_columns);
    }
}

static void cut_table(csv_table *table, char *starts[], size_t n_lines)
{
    size_t i;

    if (n_lines == 0) {
        fail_line(table, 1, "there is no header line: the file is empty");
    }
    table->header_line = table->lines[0];
    table->n_columns = 1 + count_of(',', starts[0], starts[0] + strlen(starts[0]));
    if (n_lines == 1) {
        fail_line(table, table->header_line, "there are no data lines after the header");
    }
    table->n_rows = n_lines - 1;
    for (i = 1; i < n_lines; i++) {
        check_fields(table, table->lines[i], starts[i]);
        table->lines[i - 1] = table->lines[i];
    }
    table->columns = cli_alloc(table->n_columns, sizeof *table->columns);
    table->cells = cli_alloc(table->n_rows, table->n_columns * sizeof *table->cells);
    cut_fields(table->columns, starts[0]);
    for (i = 0; i < table->n_rows; i++) {
        cut_fields(table->cells + i * table->n_columns, starts[i + 1]);
    }
}

static void refuse_foreign(const csv_table *table, const char *text, size_t length)
{
    const char *foreign = cli_foreign(text, length);

    if (foreign != NULL) {
        fail_line(table, 1, "%s", foreign);
    }
}

void csv_read(csv_table *table, const char *path)
{
    static const char BYTE_ORDER_MARK[] = "\xef\xbb\xbf";
    size_t length, n_lines;
    char *begin, *end, **starts;

    memset(table, 0, sizeof *table);
    table->path = path;
    begin = read_all(path, &length);
    end = begin + length;
    if (strncmp(begin, BYTE_ORDER_MARK, 3) == 0) {
        begin += 3;
    }
    refuse_foreign(table, begin, (size_t)(end - begin));
    n_lines = 1 + count_of('\n', begin, end);
    table->lines = cli_alloc(n_lines, sizeof *table->lines);
    starts = cli_alloc(n_lines, sizeof *starts);
    cut_table(table, starts, cut_lines(table, starts, begin, end));
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
            fail_line(table, table->header_line,
                      "column %s is there more than once: leave one", name);
        }
        found = column;
    }
    return found;
}

/* A column with nearly this name would be ignored in silence. */
static void refuse_alike(const csv_table *table, const char *name)
{
    size_t column;

    for (column = 0; column < table->n_columns; column++) {
        if (cli_look_alike(table->columns[column], name)) {
            fail_line(table, table->header_line, "column \"%s\" must be spelled %s",
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
        fail_line(table, table->header_line, "there is no column %s", name);
    }
    form = cli_form(table);
    if (form != NULL && strcmp(form, table->form) != 0) {
        fail_line(table, table->header_line,
                  "there is no column %s: this looks like %s, where %s is wanted", name,
                  form, table->form);
    }
    fail_line(table, table->header_line,
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

/* strtod also takes blanks before the number, "inf", "nan" and hexadecimal. */
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

static double number(const csv_table *table, size_t row, size_t column)
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
    return column == CSV_NONE ? 0 : (rigcal_real)number(table, row, column);
}

int32_t csv_whole(const csv_table *table, size_t row, size_t column, int32_t least,
                  int32_t most)
{
    const double value = number(table, row, column);

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
