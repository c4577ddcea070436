/* Makes one call of the C library fail, or sends a signal before it: loaded before a
 * program with LD_PRELOAD. FAULT=rename:2:5 makes the second rename fail with errno
 * 5; FAULT=rename:2:-9 sends signal 9 before it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Whether this call must fail; errno is set then. */
static int strikes(const char *function)
{
    static int calls;
    const char *fault = getenv("FAULT");
    const size_t length = strlen(function);
    int at = 0, what = 0;

    if (fault == NULL || strncmp(fault, function, length) != 0 ||
        sscanf(fault + length, ":%d:%d", &at, &what) != 2 || ++calls != at) {
        return 0;
    }
    if (what < 0) {
        kill(getpid(), -what);
        return 0;
    }
    errno = what;
    return 1;
}

/* The function that would have been called. */
#define REAL(result, name, ...) \
    result (*real)(__VA_ARGS__); \
    *(void **)&real = dlsym(RTLD_NEXT, #name)

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

char *mkdtemp(char *name)
{
    REAL(char *, mkdtemp, char *);
    return strikes("mkdtemp") ? NULL : real(name);
}

FILE *fdopen(int fd, const char *mode)
{
    REAL(FILE *, fdopen, int, const char *);
    return strikes("fdopen") ? NULL : real(fd, mode);
}
