/* cli_os.h - what the command line asks of the system: POSIX, or Windows. Nothing else of
 * the program depends on it. Paths and arguments are UTF-8 on both. Functions that fail
 * set errno. */
#ifndef RIGCAL_CLI_OS_H
#define RIGCAL_CLI_OS_H

#include <stdio.h>

/* The first call of the program: gives the arguments in UTF-8, and makes streams write
 * bytes unchanged. */
void cli_os_begin(int *argc, char ***argv);

/* Whether standard error is a terminal that can rub out a line ("\033[K"). */
int cli_os_is_terminal(void);

/* The next character of a UTF-8 text, with capitals as small letters. A byte that is not
 * UTF-8 counts as a character. *is_blank: whether it is white space. */
unsigned long cli_os_character(int *is_blank, const char **text);

/* ==== files =============================================================== */

/* Opens a file to read, or a new file to write, which must not exist. NULL: errno says why
 * it failed. */
FILE *cli_os_open(const char *path);
FILE *cli_os_create(const char *path);

/* Return 0 if done, -1 if not. cli_os_rename replaces an existing file. */
int cli_os_rename(const char *from, const char *to);
int cli_os_remove(const char *path);
int cli_os_make_folder(const char *path);
int cli_os_remove_folder(const char *path);

/* Makes a folder that nobody else uses: XXXXXX at the end of the path is replaced by a new
 * name. cli_os_publish gives it its final name and the permissions of an ordinary
 * folder. */
int cli_os_make_own_folder(char *path);
int cli_os_publish(const char *own, const char *folder);

/* What a path leads to. If it leads to nothing, errno says why. The second argument says
 * whether links are followed. */
enum { CLI_OS_NOTHING, CLI_OS_FOLDER, CLI_OS_OTHER };
int cli_os_look(const char *path);
int cli_os_look_at_link(const char *path);

/* Calls `tell` with the name of each thing in a folder. */
void cli_os_list(const char *folder, void (*tell)(const char *folder, const char *name));

/* Whether the character separates the names of a path. The length of the part of a path
 * that cannot be created as a folder, at least 1. */
int cli_os_is_slash(char c);
size_t cli_os_root(const char *path);

/* ==== signals ============================================================= */

/* From cli_os_hold_signals on, signals that would end the program wait until
 * cli_os_release_signals. There the program ends if one came. cli_os_must_end: whether one
 * came. */
void cli_os_hold_signals(void);
int cli_os_must_end(void);
void cli_os_release_signals(void);

#endif
