/* cli_foreign.h - files of other programs, told by how they look. */
#ifndef RIGCAL_CLI_FOREIGN_H
#define RIGCAL_CLI_FOREIGN_H

#include "cli_csv.h"

/* What a file that ends with a NUL is, if it is none of ours: "this looks like ..: do
 * this", or NULL. */
const char *cli_foreign(const char *text, size_t length);

/* Which of our files has these columns, or NULL. */
const char *cli_form(const csv_table *table);

#endif
