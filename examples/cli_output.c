#define _POSIX_C_SOURCE 200809L

#include "cli.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

/* Leaves the folder as it was, and ends the program. */
static CLI_NORETURN void give_up(cli_output *output, const char *path)
{
    const int reason = errno;
    size_t i;

    for (i = 0; i < output->count; i++) {
        if (output->file[i] != NULL) {
            fclose(output->file[i]);
        }
        remove(output->temporary[i]);
    }
    if (output->made_folder) {
        rmdir(output->folder);
    }
    cli_fail("%s: %s", path, strerror(reason));
}

void cli_output_begin(cli_output *output, const char *folder)
{
    memset(output, 0, sizeof *output);
    output->folder = folder;
    output->made_folder = mkdir(folder, 0777) == 0;
    if (!output->made_folder && errno != EEXIST) {
        give_up(output, folder);
    }
}

FILE *cli_output_file(cli_output *output, const char *name)
{
    const size_t room = strlen(output->folder) + strlen(name) + 32;
    const size_t i = output->count++;
    struct stat there;

    output->path[i] = cli_alloc(room, 1);
    output->temporary[i] = cli_alloc(room, 1);
    snprintf(output->path[i], room, "%s/%s", output->folder, name);
    snprintf(output->temporary[i], room, "%s/%s.%ld", output->folder, name,
             (long)getpid());
    if (stat(output->path[i], &there) == 0 && S_ISDIR(there.st_mode)) {
        errno = EISDIR;
        give_up(output, output->path[i]);
    }
    output->file[i] = fopen(output->temporary[i], "w");
    if (output->file[i] == NULL) {
        give_up(output, output->temporary[i]);
    }
    return output->file[i];
}

static void close_file(cli_output *output, size_t i)
{
    const int failed = ferror(output->file[i]);
    const int not_closed = fclose(output->file[i]);

    output->file[i] = NULL;
    if (failed || not_closed) {
        give_up(output, output->path[i]);
    }
}

void cli_output_finish(cli_output *output)
{
    size_t i;

    for (i = 0; i < output->count; i++) {
        close_file(output, i);
    }
    for (i = 0; i < output->count; i++) {
        if (rename(output->temporary[i], output->path[i]) != 0) {
            give_up(output, output->path[i]);
        }
    }
}
