#include "cli.h"

#include "cli_os.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ==== numbers ============================================================= */

void cli_write_numbers(FILE *file, const rigcal_real numbers[], size_t count)
{
    size_t i;

    for (i = 0; i < count; i++) { /* + 0 turns -0 into 0 */
        fprintf(file, ",%.*g", CLI_DIGITS, (double)numbers[i] + 0);
    }
}

void cli_write_known(FILE *file, rigcal_real number, int known)
{
    if (known) {
        cli_write_numbers(file, &number, 1);
    } else {
        fputc(',', file);
    }
}

void cli_write_transform(FILE *file, const rigcal_transform *transform)
{
    cli_write_numbers(file, transform->R, 9);
    cli_write_numbers(file, transform->t, 3);
}

/* ==== standard output ===================================================== */

void cli_flush_stdout(const char *consequence)
{
    errno = 0;
    if (fflush(stdout) != 0 || ferror(stdout)) {
        cli_fail("cannot write to standard output: %s%s",
                 errno != 0 ? strerror(errno) : "an earlier write failed", consequence);
    }
}

/* ==== a set of files ======================================================
 *
 * The files are made in a folder of their own, `work`. If the folder that is wanted
 * does not exist, it is this one, renamed when all files are in it. If it exists, its
 * earlier files are first moved into `work`, and then the new ones out of it. If the
 * program is killed in between, files are missing, but new and earlier ones are never
 * side by side, and `work` holds what is missing. Other signals are held until the
 * files are there, or are given up. */

struct cli_output {
    char *folder, *work; /* work: NULL until it is made */
    int is_new;          /* whether `work` becomes the folder */
    char **made;         /* folders made above it */
    size_t n_made;
    size_t count;
    const char *name[CLI_OUTPUT_MAX];
    FILE *file[CLI_OUTPUT_MAX]; /* NULL if closed */
};

#define UNFINISHED "rigcal-unfinished-"

static char *join(const char *folder, const char *before, const char *name)
{
    const size_t room = strlen(folder) + strlen(before) + strlen(name) + 2;
    char *path = cli_alloc(room, 1);

    snprintf(path, room, "%s/%s%s", folder, before, name);
    return path;
}

/* Removes the folders and files that were made. */
static void clean_up(cli_output *output)
{
    size_t i;

    for (i = 0; i < output->count; i++) {
        if (output->file[i] != NULL) {
            fclose(output->file[i]);
        }
        cli_os_remove(join(output->work, "", output->name[i]));
    }
    if (output->work != NULL) {
        cli_os_remove_folder(output->work);
    }
    while (output->n_made > 0) {
        cli_os_remove_folder(output->made[--output->n_made]);
    }
}

static CLI_NORETURN void give_up(cli_output *output, const char *path)
{
    const int reason = errno;

    clean_up(output);
    cli_fail("cannot write %s: %s; no file was written", path, strerror(reason));
}

/* The path without slashes at its end. */
static char *trimmed(const char *path)
{
    const size_t root = cli_os_root(path);
    size_t length = strlen(path);
    char *copy = cli_alloc(length + 1, 1);

    while (length > root && cli_os_is_slash(path[length - 1])) {
        length--;
    }
    memcpy(copy, path, length);
    copy[length] = '\0';
    return copy;
}

/* Ends the program unless the path is a folder. errno says why it could not be made. */
static void want_folder(cli_output *output, const char *path)
{
    const int reason = errno;
    const int is = cli_os_look(path);

    if (is == CLI_OS_NOTHING) {
        errno = reason == EEXIST ? ENOENT : reason;
        give_up(output, path);
    }
    if (is != CLI_OS_FOLDER) {
        errno = ENOTDIR;
        give_up(output, path);
    }
}

/* Makes the parent folders of the path. */
static void make_parents(cli_output *output)
{
    const size_t room = strlen(output->folder) + 1;
    size_t i;

    output->made = cli_alloc(room, sizeof *output->made);
    for (i = cli_os_root(output->folder); output->folder[i] != '\0'; i++) {
        if (cli_os_is_slash(output->folder[i]) && !cli_os_is_slash(output->folder[i - 1])) {
            char *parent = cli_alloc(room, 1);

            memcpy(parent, output->folder, i);
            if (cli_os_make_folder(parent) == 0) {
                output->made[output->n_made++] = parent;
            } else {
                want_folder(output, parent);
            }
        }
    }
}

/* Names folders of earlier runs that were killed while they replaced the files of this
 * folder. */
static void name_unfinished(const char *folder, const char *name)
{
    if (strncmp(name, UNFINISHED, sizeof UNFINISHED - 1) == 0) {
        cli_say("%s/%s is of a run that was killed, or that still runs: files missing "
                "from %s are in it",
                folder, name, folder);
    }
}

static void make_work(cli_output *output)
{
    static const char NAME[] = UNFINISHED "XXXXXX";
    size_t parent = strlen(output->folder);
    char *work;

    if (output->is_new) {
        while (parent > 0 && !cli_os_is_slash(output->folder[parent - 1])) {
            parent--;
        }
        work = cli_text("%.*s%s", (int)parent, output->folder, NAME);
    } else {
        work = cli_text("%s/%s", output->folder, NAME);
    }
    if (cli_os_make_own_folder(work) != 0) {
        give_up(output, output->folder);
    }
    output->work = work;
}

cli_output *cli_output_begin(const char *folder)
{
    cli_output *output = cli_alloc(1, sizeof *output);

    if (*folder == '\0') {
        cli_fail("--out names no folder: give the one to write the files to");
    }
    cli_os_hold_signals();
    output->folder = trimmed(folder);
    make_parents(output);
    output->is_new = cli_os_look(output->folder) == CLI_OS_NOTHING && errno == ENOENT;
    if (!output->is_new) {
        want_folder(output, output->folder);
        cli_os_list(output->folder, name_unfinished);
    }
    make_work(output);
    return output;
}

FILE *cli_output_file(cli_output *output, const char *name)
{
    FILE *file = cli_os_create(join(output->work, "", name));

    if (file == NULL) {
        give_up(output, join(output->folder, "", name));
    }
    output->name[output->count] = name;
    output->file[output->count++] = file;
    return file;
}

static void close_file(cli_output *output, size_t i)
{
    FILE *file = output->file[i];
    const int failed = fflush(file) != 0 || ferror(file);
    const int reason = errno;

    output->file[i] = NULL;
    if (fclose(file) != 0 || failed) {
        errno = failed ? reason : errno;
        give_up(output, join(output->folder, "", output->name[i]));
    }
}

/* Ends the program if a folder has the name of one of the files. */
static void check_places(cli_output *output)
{
    size_t i;

    for (i = 0; i < output->count; i++) {
        const char *path = join(output->folder, "", output->name[i]);

        if (cli_os_look_at_link(path) == CLI_OS_FOLDER) {
            errno = EISDIR;
            give_up(output, path);
        }
    }
}

/* Moves a file of the folder into `work`, or back. Returns 0 if done, or if there is no
 * such file. */
static int put_away(const cli_output *output, size_t i)
{
    const int failed = cli_os_rename(join(output->folder, "", output->name[i]),
                                     join(output->work, "earlier-", output->name[i]));

    return failed != 0 && errno != ENOENT ? -1 : 0;
}

static int take_back(const cli_output *output, size_t i)
{
    const int failed = cli_os_rename(join(output->work, "earlier-", output->name[i]),
                                     join(output->folder, "", output->name[i]));

    return failed != 0 && errno != ENOENT ? -1 : 0;
}

/* Puts the earlier files back, after the first n_new places already got new ones. */
static CLI_NORETURN void undo(cli_output *output, size_t n_new, const char *path)
{
    const int reason = errno;
    size_t i;

    for (i = 0; i < n_new; i++) {
        cli_os_remove(join(output->folder, "", output->name[i]));
    }
    for (i = 0; i < output->count; i++) {
        if (take_back(output, i) != 0) {
            cli_say("cannot move %s back to %s: %s; it is in %s", output->name[i],
                    output->folder, strerror(errno),
                    join(output->work, "earlier-", output->name[i]));
        }
    }
    errno = reason;
    give_up(output, path);
}

static void replace_files(cli_output *output)
{
    size_t i;

    check_places(output);
    for (i = 0; i < output->count; i++) {
        if (put_away(output, i) != 0) {
            undo(output, 0, join(output->folder, "", output->name[i]));
        }
    }
    for (i = 0; i < output->count; i++) {
        if (cli_os_rename(join(output->work, "", output->name[i]),
                          join(output->folder, "", output->name[i])) != 0) {
            undo(output, i, join(output->folder, "", output->name[i]));
        }
    }
    for (i = 0; i < output->count; i++) {
        cli_os_remove(join(output->work, "earlier-", output->name[i]));
    }
    cli_os_remove_folder(output->work);
}

void cli_output_finish(cli_output *output)
{
    size_t i;

    for (i = 0; i < output->count; i++) {
        close_file(output, i);
    }
    if (cli_os_must_end()) {
        clean_up(output);
        cli_os_release_signals(); /* and it does */
        exit(CLI_USAGE);
    }
    if (!output->is_new) {
        replace_files(output);
    } else if (cli_os_publish(output->work, output->folder) != 0) {
        give_up(output, output->folder);
    }
    cli_os_release_signals();
}
