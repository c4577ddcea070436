#define _XOPEN_SOURCE 700

#include "cli.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ==== numbers ============================================================= */

void cli_write_numbers(FILE *file, const rigcal_real numbers[], size_t count)
{
    size_t i;

    for (i = 0; i < count; i++) { /* + 0: no minus before a zero */
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
    sigset_t mask;       /* of before */
    char *folder, *work; /* work: NULL until made */
    int is_new;          /* work becomes the folder */
    char **made;         /* folders made on the way to it */
    size_t n_made;
    size_t count;
    const char *name[CLI_OUTPUT_MAX];
    FILE *file[CLI_OUTPUT_MAX]; /* NULL when closed */
};

static const int SIGNALS[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGPIPE, SIGALRM,
                              SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ};
enum { N_SIGNALS = sizeof SIGNALS / sizeof SIGNALS[0] };

#define UNFINISHED "rigcal-unfinished-"

static void hold_signals(cli_output *output)
{
    sigset_t held;
    size_t i;

    sigemptyset(&held);
    for (i = 0; i < N_SIGNALS; i++) {
        sigaddset(&held, SIGNALS[i]);
    }
    sigprocmask(SIG_BLOCK, &held, &output->mask);
}

/* Whether a signal is held that will end the program. */
static int must_end(void)
{
    sigset_t waiting;
    struct sigaction action;
    size_t i;

    sigpending(&waiting);
    for (i = 0; i < N_SIGNALS; i++) {
        if (sigismember(&waiting, SIGNALS[i]) &&
            sigaction(SIGNALS[i], NULL, &action) == 0 && action.sa_handler != SIG_IGN) {
            return 1;
        }
    }
    return 0;
}

static char *join(const char *folder, const char *before, const char *name)
{
    const size_t room = strlen(folder) + strlen(before) + strlen(name) + 2;
    char *path = cli_alloc(room, 1);

    snprintf(path, room, "%s/%s%s", folder, before, name);
    return path;
}

/* Removes what was made on the way. */
static void clean_up(cli_output *output)
{
    size_t i;

    for (i = 0; i < output->count; i++) {
        if (output->file[i] != NULL) {
            fclose(output->file[i]);
        }
        unlink(join(output->work, "", output->name[i]));
    }
    if (output->work != NULL) {
        rmdir(output->work);
    }
    while (output->n_made > 0) {
        rmdir(output->made[--output->n_made]);
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
    size_t length = strlen(path);
    char *copy = cli_alloc(length + 1, 1);

    while (length > 1 && path[length - 1] == '/') {
        length--;
    }
    memcpy(copy, path, length);
    copy[length] = '\0';
    return copy;
}

/* Gives up unless the path is a folder; errno tells why it could not be made. */
static void want_folder(cli_output *output, const char *path)
{
    struct stat there;
    const int reason = errno;

    if (stat(path, &there) != 0) {
        errno = reason == EEXIST ? ENOENT : reason;
        give_up(output, path);
    }
    if (!S_ISDIR(there.st_mode)) {
        errno = ENOTDIR;
        give_up(output, path);
    }
}

/* The folders that lead to the last one. */
static void make_parents(cli_output *output)
{
    const size_t room = strlen(output->folder) + 1;
    size_t i;

    output->made = cli_alloc(room, sizeof *output->made);
    for (i = 1; output->folder[i] != '\0'; i++) {
        if (output->folder[i] == '/' && output->folder[i - 1] != '/') {
            char *parent = cli_alloc(room, 1);

            memcpy(parent, output->folder, i);
            if (mkdir(parent, 0777) == 0) {
                output->made[output->n_made++] = parent;
            } else {
                want_folder(output, parent);
            }
        }
    }
}

/* Earlier runs that were killed while they replaced the files of this folder. */
static void name_unfinished(const char *folder)
{
    DIR *list = opendir(folder);
    const struct dirent *entry;

    while (list != NULL && (entry = readdir(list)) != NULL) {
        if (strncmp(entry->d_name, UNFINISHED, sizeof UNFINISHED - 1) == 0) {
            cli_say("%s/%s is of a run that was killed, or that still runs: files "
                    "missing from %s are in it",
                    folder, entry->d_name, folder);
        }
    }
    if (list != NULL) {
        closedir(list);
    }
}

static void make_work(cli_output *output)
{
    static const char NAME[] = UNFINISHED "XXXXXX";
    const char *slash = strrchr(output->folder, '/');
    const size_t parent = slash != NULL ? (size_t)(slash - output->folder) + 1 : 0;
    char *work = cli_alloc(strlen(output->folder) + sizeof NAME + 2, 1);

    if (output->is_new) {
        memcpy(work, output->folder, parent);
        strcpy(work + parent, NAME);
    } else {
        strcpy(work, output->folder);
        strcat(work, "/");
        strcat(work, NAME);
    }
    if (mkdtemp(work) == NULL) {
        give_up(output, output->folder);
    }
    output->work = work;
}

cli_output *cli_output_begin(const char *folder)
{
    cli_output *output = cli_alloc(1, sizeof *output);
    struct stat there;

    if (*folder == '\0') {
        cli_fail("--out names no folder: give the one to write the files to");
    }
    hold_signals(output);
    output->folder = trimmed(folder);
    make_parents(output);
    output->is_new = stat(output->folder, &there) != 0 && errno == ENOENT;
    if (!output->is_new) {
        want_folder(output, output->folder);
        name_unfinished(output->folder);
    }
    make_work(output);
    return output;
}

FILE *cli_output_file(cli_output *output, const char *name)
{
    const size_t i = output->count;
    const int fd =
        open(join(output->work, "", name), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0666);

    if (fd < 0) {
        give_up(output, join(output->folder, "", name));
    }
    output->name[i] = name;
    output->count++;
    output->file[i] = fdopen(fd, "w");
    if (output->file[i] == NULL) {
        close(fd);
        give_up(output, join(output->folder, "", name));
    }
    return output->file[i];
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

/* Gives up if a folder has the name of one of the files. */
static void check_places(cli_output *output)
{
    struct stat there;
    size_t i;

    for (i = 0; i < output->count; i++) {
        const char *path = join(output->folder, "", output->name[i]);

        if (lstat(path, &there) == 0 && S_ISDIR(there.st_mode)) {
            errno = EISDIR;
            give_up(output, path);
        }
    }
}

/* Moves a file of the folder into work, or out of it; 0 done, or not there. */
static int put_away(const cli_output *output, size_t i)
{
    const int failed = rename(join(output->folder, "", output->name[i]),
                              join(output->work, "earlier-", output->name[i]));

    return failed != 0 && errno != ENOENT ? -1 : 0;
}

static int take_back(const cli_output *output, size_t i)
{
    const int failed = rename(join(output->work, "earlier-", output->name[i]),
                              join(output->folder, "", output->name[i]));

    return failed != 0 && errno != ENOENT ? -1 : 0;
}

/* Puts the earlier files back, where the first n_new places hold new ones. */
static CLI_NORETURN void undo(cli_output *output, size_t n_new, const char *path)
{
    const int reason = errno;
    size_t i;

    for (i = 0; i < n_new; i++) {
        unlink(join(output->folder, "", output->name[i]));
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
        if (rename(join(output->work, "", output->name[i]),
                   join(output->folder, "", output->name[i])) != 0) {
            undo(output, i, join(output->folder, "", output->name[i]));
        }
    }
    for (i = 0; i < output->count; i++) {
        unlink(join(output->work, "earlier-", output->name[i]));
    }
    rmdir(output->work);
}

static void rename_folder(cli_output *output)
{
    const mode_t withheld = umask(0);
    struct stat there;

    umask(withheld);
    if (stat(output->work, &there) != 0 ||
        chmod(output->work, (there.st_mode & S_ISGID) | (0777 & ~withheld)) != 0 ||
        rename(output->work, output->folder) != 0) {
        give_up(output, output->folder);
    }
}

void cli_output_finish(cli_output *output)
{
    size_t i;

    for (i = 0; i < output->count; i++) {
        close_file(output, i);
    }
    if (must_end()) {
        clean_up(output);
        sigprocmask(SIG_SETMASK, &output->mask, NULL); /* and it does */
        exit(CLI_USAGE);
    }
    if (output->is_new) {
        rename_folder(output);
    } else {
        replace_files(output);
    }
    sigprocmask(SIG_SETMASK, &output->mask, NULL);
}
