/* Makes one call of the C library fail, or lets something happen before it: loaded before
 * a program with LD_PRELOAD. FAULT=rename:2:5 makes the second rename fail with errno 5.
 * FAULT=rename:2:-9 sends signal 9 before it. FAULT=rename:2:-1000 moves the folder
 * FAULT_FOLDER away before it. "any" in place of a function counts all of them. At the end
 * the number of calls is written to the file FAULT_COUNT.
 *
 * The files that the program writes, and standard output, are streams of this library: it
 * could not catch the writes that the C library makes for a stream. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { VANISH = -1000 };

static int calls;

/* Finds the function of the C library that would have been called. */
#define REAL(result, name, ...) \
    result (*real)(__VA_ARGS__); \
    *(void **)&real = dlsym(RTLD_NEXT, #name)

static void vanish(void)
{
    const char *folder = getenv("FAULT_FOLDER");
    char gone[4096];
    REAL(int, rename, const char *, const char *);
    snprintf(gone, sizeof gone, "%s-gone", folder);
    real(folder, gone);
}

/* Whether this call must fail. Then errno is set. */
static int strikes(const char *function)
{
    const char *fault = getenv("FAULT");
    const char *end = fault == NULL ? NULL : strchr(fault, ':');
    int at = 0, what = 0;

    if (end == NULL ||
        (strncmp(fault, "any:", 4) != 0 &&
         (strncmp(fault, function, (size_t)(end - fault)) != 0 ||
          function[end - fault] != '\0')) ||
        sscanf(end, ":%d:%d", &at, &what) != 2 || ++calls != at) {
        return 0;
    }
    if (what == VANISH) {
        const int before = errno;

        vanish();
        errno = before;
        return 0;
    }
    if (what < 0) {
        kill(getpid(), -what);
        return 0;
    }
    errno = what;
    return 1;
}

/* ---- streams ------------------------------------------------------------------ */

static ssize_t write_some(void *fd, const char *bytes, size_t n)
{
    return strikes("write") ? 0 : write((int)(intptr_t)fd, bytes, n);
}

static int close_it(void *fd)
{
    const int failed = close((int)(intptr_t)fd);
    return strikes("close") ? -1 : failed;
}

static FILE *stream(int fd)
{
    const cookie_io_functions_t functions = {NULL, write_some, NULL, close_it};
    return fopencookie((void *)(intptr_t)fd, "w", functions);
}

FILE *fdopen(int fd, const char *mode)
{
    REAL(FILE *, fdopen, int, const char *);
    if (strikes("fdopen")) {
        return NULL;
    }
    return mode[0] == 'w' ? stream(fd) : real(fd, mode);
}

__attribute__((constructor)) static void begin(void)
{
    if (fcntl(STDOUT_FILENO, F_GETFD) >= 0) {
        stdout = stream(STDOUT_FILENO);
    }
}

__attribute__((destructor)) static void end(void)
{
    const char *path = getenv("FAULT_COUNT");
    const int n = calls;
    FILE *file = path == NULL ? NULL : fopen(path, "w");

    if (file != NULL) {
        fprintf(file, "%d\n", n);
        fclose(file);
    }
}

/* ---- the rest ------------------------------------------------------------------- */

int open(const char *path, int flags, ...)
{
    va_list rest;
    mode_t mode;
    REAL(int, open, const char *, int, ...);
    va_start(rest, flags);
    mode = flags & O_CREAT ? (mode_t)va_arg(rest, unsigned) : 0;
    va_end(rest);
    return strikes("open") ? -1 : real(path, flags, mode);
}

int rename(const char *from, const char *to)
{
    REAL(int, rename, const char *, const char *);
    return strikes("rename") ? -1 : real(from, to);
}

int chmod(const char *path, mode_t mode)
{
    REAL(int, chmod, const char *, mode_t);
    return strikes("chmod") ? -1 : real(path, mode);
}

int mkdir(const char *path, mode_t mode)
{
    REAL(int, mkdir, const char *, mode_t);
    return strikes("mkdir") ? -1 : real(path, mode);
}

char *mkdtemp(char *name)
{
    REAL(char *, mkdtemp, char *);
    return strikes("mkdtemp") ? NULL : real(name);
}

int unlink(const char *path)
{
    REAL(int, unlink, const char *);
    return strikes("unlink") ? -1 : real(path);
}

int rmdir(const char *path)
{
    REAL(int, rmdir, const char *);
    return strikes("rmdir") ? -1 : real(path);
}
