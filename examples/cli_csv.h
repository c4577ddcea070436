/* cli_csv.h - tables of comma-separated text, read with messages that name file and line.
 * Any error in a file ends the program with "file:line: what is wrong" and exit status 2.
 * So callers get only tables that can be used. */
#ifndef RIGCAL_CLI_CSV_H
#define RIGCAL_CLI_CSV_H

#include <stddef.h>

#include "rigcal.h"

#if defined(__GNUC__)
#define CLI_NORETURN __attribute__((noreturn))
#define CLI_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define CLI_NORETURN
#define CLI_PRINTF(text, first)
#endif

/* Exit status: done; some results could not be computed; wrong options or files. */
enum { CLI_DONE = 0, CLI_GEOMETRY = 1, CLI_USAGE = 2 };

/* Prints "rigcal: " and the message to stderr. The message may also be part of a line.
 * cli_fail then exits with CLI_USAGE. */
void cli_say(const char *format, ...) CLI_PRINTF(1, 2);
void cli_say_part(const char *format, ...) CLI_PRINTF(1, 2);
CLI_NORETURN void cli_fail(const char *format, ...) CLI_PRINTF(1, 2);

/* From cli_hold on, messages are held back; cli_release shows them. If cli_fail ends the
 * program, they are shown before its message. */
void cli_hold(void);
void cli_release(void);

/* A message that `say` makes when it is shown. Where there may be very many, holding their
 * text would take much memory. There is one function and context for all of them. */
typedef void cli_later(const void *context, size_t number);
void cli_say_later(cli_later *say, const void *context, size_t number);

/* A formatted text in memory of cli_alloc. */
char *cli_text(const char *format, ...) CLI_PRINTF(1, 2);

/* Shows a line on stderr that the next such line replaces, and that every message removes.
 * It is shown only on a terminal, and only for so many views that the work can take
 * long. */
void cli_progress(size_t n_views, const char *format, ...) CLI_PRINTF(2, 3);
void cli_progress_end(void);

/* After this call each progress message is a line of its own that begins with
 * "rigcal-progress: ", on a terminal or not, for work of any length. */
void cli_progress_lines(void);

/* Zeroed memory for `count` things; never NULL. It is freed when the program ends: the
 * program is short-lived and may end at any place. */
void *cli_alloc(size_t count, size_t size);

/* Resizes memory of cli_alloc. What it held stays; what is added is not zeroed. The result
 * is freed when the program ends. */
void *cli_resize(void *memory, size_t count, size_t size);
void cli_free(void *memory);

/* The same as cli_alloc for little memory that is never resized or freed by itself. Many
 * pieces share a block. */
void *cli_keep(size_t size);

/* Reads the decimal number at the begin of a text. If it is not finite and within
 * rigcal_real, *problem says what is wrong. Returns where the number ends. */
const char *cli_number(double *value, const char **problem, const char *text);

typedef struct csv_source csv_source;

typedef struct {
    const char *path;
    const char *form; /* what the file should be, such as "cameras.csv"; NULL: any */
    char **columns;   /* the n_columns names */
    char **cells;     /* cells of the rows in memory, n_columns each */
    size_t *lines;    /* for each row: its line in the file */
    size_t header_line;
    size_t n_columns, n_rows; /* at least 1 column and 1 row */
    csv_source *source;       /* while the file is read */
} csv_table;

/* Reads a whole file. */
void csv_read(csv_table *table, const char *path);

/* Reads a large file row by row. csv_open reads the header. csv_next reads the next row,
 * which becomes row 0 in place of the last one, and returns 0 if there is none. */
void csv_open(csv_table *table, const char *path);
int csv_next(csv_table *table);

/* The number of the column with that name. A column that must be there ends the program if
 * it is missing; for an optional one the result is then CSV_NONE. */
#define CSV_NONE ((size_t)-1)
size_t csv_column(const csv_table *table, const char *name);
size_t csv_optional(const csv_table *table, const char *name);

/* One cell as a number (0 if the column is CSV_NONE), as a whole number from least to most,
 * or as an id. */
rigcal_real csv_real(const csv_table *table, size_t row, size_t column);
double csv_number(const csv_table *table, size_t row, size_t column);
int32_t csv_whole(const csv_table *table, size_t row, size_t column, int32_t least,
                  int32_t most);
const char *csv_id(const csv_table *table, size_t row, size_t column);

/* Ends the program with "file:line: " and the message, for the line of that row. */
CLI_NORETURN void csv_fail(const csv_table *table, size_t row, const char *format, ...)
    CLI_PRINTF(3, 4);

/* The same, by the number of the line. */
CLI_NORETURN void csv_fail_line(const csv_table *table, size_t line, const char *format,
                                ...) CLI_PRINTF(3, 4);

#endif
