/* cli_os.h - what the command line asks of the system: POSIX, or Windows. Nothing else of
 * the program depends on it. Paths and arguments are UTF-8 on both. Functions that fail
 * set errno. */
#ifndef RIGCAL_CLI_OS_H
#define RIGCAL_CLI_OS_H

#include <stdio.h>

/* First of all: the arguments in UTF-8, and streams that write bytes as they are. */
void cli_os_begin(int *argc, char ***argv);

/* Whether standard error is a terminal that can rub out a line ("\033[K"). */
int cli_os_is_terminal(void);

/* The next character of a text in UTF-8, a capital as its small letter; a byte that is no
 * UTF-8 is a character. *is_blank: it is white space. */
unsigned long cli_os_character(int *is_blank, const char **text);

/* ==== files =============================================================== */

/* To read; or to write a new file: it is not there yet. NULL: errno tells why not. */
FILE *cli_os_open(const char *path);
FILE *cli_os_create(const char *path);

/* 0 done, -1 not. cli_os_rename takes the place of a file that is there. */
int cli_os_rename(const char *from, const char *to);
int cli_os_remove(const char *path);
int cli_os_make_folder(const char *path);
int cli_os_remove_folder(const char *path);

/* A folder that nobody else uses: the XXXXXX at the end of the path become what makes it
 * new. cli_os_publish gives it the name and the permissions of an ordinary one. */
int cli_os_make_own_folder(char *path);
int cli_os_publish(const char *own, const char *folder);

/* What a path leads to. If to nothing, errno tells why. Links are followed, or not. */
enum { CLI_OS_NOTHING, CLI_OS_FOLDER, CLI_OS_OTHER };
int cli_os_look(const char *path);
int cli_os_look_at_link(const char *path);

/* Calls `tell` with the name of each thing in a folder. */
void cli_os_list(const char *folder, void (*tell)(const char *folder, const char *name));

/* Whether it stands between the names of a path; how long the part of a path is that no
 * folder can be made of: 1 at least. */
int cli_os_is_slash(char c);
size_t cli_os_root(const char *path);

/* ==== signals ============================================================= */

/* Those that would end the program wait from cli_os_hold_signals on until
 * cli_os_release_signals, where the program ends if one came. cli_os_must_end: one did. */
void cli_os_hold_signals(void);
int cli_os_must_end(void);
void cli_os_release_signals(void);

#endif
