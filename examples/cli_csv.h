/* cli_csv.h - tables of comma-separated text, read with exact complaints.
 *
 * Whatever is wrong with a file ends the program with "file:line: what is wrong"
 * and exit status 2, so that callers only see tables that can be used. */
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

/* Exit status: done; some of it could not be computed; wrong use or files. */
enum { CLI_DONE = 0, CLI_GEOMETRY = 1, CLI_USAGE = 2 };

/* "rigcal: " and the message on stderr, or only a part of a line;
 * cli_fail then exits with CLI_USAGE. */
void cli_say(const char *format, ...) CLI_PRINTF(1, 2);
void cli_say_part(const char *format, ...) CLI_PRINTF(1, 2);
CLI_NORETURN void cli_fail(const char *format, ...) CLI_PRINTF(1, 2);

/* Messages wait from cli_hold on; cli_release shows them. Where the program ends by
 * cli_fail, they are shown before its message. */
void cli_hold(void);
void cli_release(void);

/* A text of cli_alloc. */
char *cli_text(const char *format, ...) CLI_PRINTF(1, 2);

/* A line on stderr that the next one takes the place of; every message removes it. It is
 * shown only on a terminal, and only for work on so many views that it can be long. */
void cli_progress(size_t n_views, const char *format, ...) CLI_PRINTF(2, 3);
void cli_progress_end(void);

/* From now on each is a line that begins with "rigcal-progress: ", wherever it goes, and of
 * work of any length. */
void cli_progress_lines(void);

/* Zeroed memory for count things; never NULL. It is freed when the program ends,
 * which for a program that ends soon, and may end anywhere, is soon enough. */
void *cli_alloc(size_t count, size_t size);

/* The same for memory of cli_alloc: as many things as it held before stay, what is added is
 * not zeroed. It is freed before the program ends. */
void *cli_resize(void *memory, size_t count, size_t size);
void cli_free(void *memory);

/* The number a text begins with: decimal, finite and within rigcal_real, else
 * *problem says what it is not. Returns where the number ends. */
const char *cli_number(double *value, const char **problem, const char *text);

typedef struct csv_source csv_source;

typedef struct {
    const char *path;
    const char *form; /* what it should be, "cameras.csv" and the like; NULL: any */
    char **columns;   /* n_columns names */
    char **cells;     /* of the rows that are held, n_columns each */
    size_t *lines;    /* line in the file, of each */
    size_t header_line;
    size_t n_columns, n_rows; /* at least 1 of each */
    csv_source *source;       /* while the file is read */
} csv_table;

/* All of a file. */
void csv_read(csv_table *table, const char *path);

/* Row by row, for a file that is large: csv_open reads the header. csv_next reads the next
 * row, and returns 0 if there is none; that row is number 0, and the ones before it have
 * gone. */
void csv_open(csv_table *table, const char *path);
int csv_next(csv_table *table);

/* Column of that name. It must be there; optional ones give CSV_NONE if not. */
#define CSV_NONE ((size_t)-1)
size_t csv_column(const csv_table *table, const char *name);
size_t csv_optional(const csv_table *table, const char *name);

/* One cell: a number (0 where the column is CSV_NONE), a whole number from least
 * to most, or an id. */
rigcal_real csv_real(const csv_table *table, size_t row, size_t column);
double csv_number(const csv_table *table, size_t row, size_t column);
int32_t csv_whole(const csv_table *table, size_t row, size_t column, int32_t least,
                  int32_t most);
const char *csv_id(const csv_table *table, size_t row, size_t column);

/* Ends the program with "file:line: " of that row and the message. */
CLI_NORETURN void csv_fail(const csv_table *table, size_t row, const char *format, ...)
    CLI_PRINTF(3, 4);

/* The same by the number of the line. */
CLI_NORETURN void csv_fail_line(const csv_table *table, size_t line, const char *format,
                                ...) CLI_PRINTF(3, 4);

#endif
