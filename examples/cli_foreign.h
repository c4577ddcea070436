/* cli_foreign.h - recognises files of other programs. */
#ifndef RIGCAL_CLI_FOREIGN_H
#define RIGCAL_CLI_FOREIGN_H

#include "cli_csv.h"

/* Says what a NUL-terminated text is if it is not a file of rigcal: "this looks like ..: do
 * this". NULL: unknown. */
const char *cli_foreign(const char *text, size_t length);

/* The name of rigcal's file that has these columns, or NULL. */
const char *cli_form(const csv_table *table);

#endif
