/* cli.h - the commands of the command line, and what they share. */
#ifndef RIGCAL_CLI_H
#define RIGCAL_CLI_H

#include <stdio.h>

#include "cli_input.h"

enum {
    OPTION_CAMERAS,
    OPTION_OBSERVATIONS,
    OPTION_OUT,
    OPTION_RIG,
    OPTION_TARGETS,
    OPTION_SIGMA,
    OPTION_FROM,
    OPTION_TO,
    OPTION_PIXEL,
    OPTION_DEPTH,
    OPTION_METHOD,
    OPTION_ROBUST,
    OPTION_THRESHOLD,
    OPTION_SEED,
    OPTION_HOLD, /* all cameras that are named, separated by commas */
    OPTION_PRIOR,
    OPTION_PROBABILITY,
    OPTION_CANDIDATES,
    OPTION_MATCHES,
    OPTION_TIMES,
    OPTION_ARL0,
    OPTION_COMMON,
    OPTION_WRONG,
    OPTION_WALK,
    OPTION_CLOCKS,
    OPTION_DRIFT,
    OPTION_SIGMA_TIME,
    OPTION_INTRINSICS_SIGMA,
    OPTION_ESTIMATE_INTRINSICS,
    OPTION_PROGRESS,
    OPTION_WEIGH,
    OPTION_COUNT
};

/* Runs a command. option[] has the text of each option: NULL if the option is not given, ""
 * if it takes no text. Returns the exit status. */
typedef int cli_command(const char *const option[OPTION_COUNT]);
cli_command cli_calibrate, cli_triangulate, cli_line, cli_monitor;

/* Significant digits written to files, so that nothing measured is lost. */
enum { CLI_DIGITS = sizeof(rigcal_real) == sizeof(double) ? 12 : 9 };

/* The column names ",R11,...,tz". */
#define CLI_TRANSFORM_COLUMNS "R11,R12,R13,R21,R22,R23,R31,R32,R33,tx,ty,tz"
void cli_write_numbers(FILE *file, const rigcal_real numbers[], size_t count);
/* Writes ",number", or "," if the number is not known. */
void cli_write_known(FILE *file, rigcal_real number, int known);
void cli_write_transform(FILE *file, const rigcal_transform *transform);

/* Reads the numbers of an option: exactly `count` of them, separated by commas. */
void cli_numbers(double numbers[], size_t count, const char *option, const char *text);

/* A number of pixels from `least` to a million. The option --sigma: the noise of one pixel
 * coordinate. */
double cli_pixels(const char *option, const char *text, double least);
double cli_sigma(const char *text);

/* Ends the program, with a message that ends with `consequence`, if something that
 * was printed could not be written. */
void cli_flush_stdout(const char *consequence);

/* A set of files that appears in a folder as a whole or not at all. The folder and its
 * parents are made. If anything fails, the program ends and everything is as it was. The
 * text `name` must stay valid. */
enum { CLI_OUTPUT_MAX = 10 };
typedef struct cli_output cli_output;
cli_output *cli_output_begin(const char *folder);
FILE *cli_output_file(cli_output *output, const char *name);
void cli_output_finish(cli_output *output);

#endif
