/* The only file that depends on the operating system. */
#if !defined(_WIN32)
#define _XOPEN_SOURCE 700
#endif

#include "cli_os.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#if !defined(_WIN32)

#include <dirent.h>
#include <locale.h>
#include <signal.h>
#include <unistd.h>
#include <wchar.h>
#include <wctype.h>

/* ==== POSIX =============================================================== */

/* NOLINTNEXTLINE(readability-non-const-parameter): Windows writes them */
void cli_os_begin(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    if (setlocale(LC_CTYPE, "C.UTF-8") == NULL) { /* for cli_os_character */
        setlocale(LC_CTYPE, "");
    }
}

int cli_os_is_terminal(void)
{
    return isatty(STDERR_FILENO);
}

unsigned long cli_os_character(int *is_blank, const char **text)
{
    mbstate_t state;
    wchar_t c = 0;
    size_t length;

    memset(&state, 0, sizeof state);
    length = mbrtowc(&c, *text, strlen(*text), &state);
    if (length == (size_t)-1 || length == (size_t)-2 || length == 0) {
        c = (unsigned char)**text;
        length = 1;
    }
    *text += length;
    *is_blank = iswspace((wint_t)c) != 0;
    return (unsigned long)towlower((wint_t)c);
}

FILE *cli_os_open(const char *path)
{
    return fopen(path, "rb");
}

FILE *cli_os_create(const char *path)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0666);
    FILE *file = fd < 0 ? NULL : fdopen(fd, "w");

    if (fd >= 0 && file == NULL) {
        const int reason = errno;

        close(fd);
        unlink(path);
        errno = reason;
    }
    return file;
}

int cli_os_rename(const char *from, const char *to)
{
    return rename(from, to);
}

int cli_os_remove(const char *path)
{
    return unlink(path);
}

int cli_os_make_folder(const char *path)
{
    return mkdir(path, 0777);
}

int cli_os_remove_folder(const char *path)
{
    return rmdir(path);
}

int cli_os_make_own_folder(char *path)
{
    return mkdtemp(path) == NULL ? -1 : 0;
}

int cli_os_publish(const char *own, const char *folder)
{
    const mode_t withheld = umask(0);
    struct stat there;

    umask(withheld);
    return stat(own, &there) == 0 &&
                   chmod(own, (there.st_mode & S_ISGID) | (0777 & ~withheld)) == 0 &&
                   rename(own, folder) == 0
               ? 0
               : -1;
}

static int kind_of(const struct stat *there)
{
    return S_ISDIR(there->st_mode) ? CLI_OS_FOLDER : CLI_OS_OTHER;
}

int cli_os_look(const char *path)
{
    struct stat there;

    return stat(path, &there) == 0 ? kind_of(&there) : CLI_OS_NOTHING;
}

int cli_os_look_at_link(const char *path)
{
    struct stat there;

    return lstat(path, &there) == 0 ? kind_of(&there) : CLI_OS_NOTHING;
}

void cli_os_list(const char *folder, void (*tell)(const char *folder, const char *name))
{
    DIR *list = opendir(folder);
    const struct dirent *entry;

    while (list != NULL && (entry = readdir(list)) != NULL) {
        tell(folder, entry->d_name);
    }
    if (list != NULL) {
        closedir(list);
    }
}

int cli_os_is_slash(char c)
{
    return c == '/';
}

size_t cli_os_root(const char *path)
{
    (void)path;
    return 1;
}

static const int SIGNALS[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGPIPE, SIGALRM,
                              SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ};
enum { N_SIGNALS = sizeof SIGNALS / sizeof SIGNALS[0] };

static sigset_t mask_of_before;

void cli_os_hold_signals(void)
{
    sigset_t held;
    size_t i;

    sigemptyset(&held);
    for (i = 0; i < N_SIGNALS; i++) {
        sigaddset(&held, SIGNALS[i]);
    }
    sigprocmask(SIG_BLOCK, &held, &mask_of_before);
}

int cli_os_must_end(void)
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

void cli_os_release_signals(void)
{
    sigprocmask(SIG_SETMASK, &mask_of_before, NULL);
}

#else

/* ==== Windows ============================================================= */

#include <direct.h>
#include <io.h>
#include <windows.h>

#include <shellapi.h>

static void *room(size_t size)
{
    void *memory = malloc(size);

    if (memory == NULL) {
        fputs("rigcal: out of memory\n", stderr);
        exit(2);
    }
    return memory;
}

static char *narrow(const wchar_t *text)
{
    const int size = WideCharToMultiByte(CP_UTF8, 0, text, -1, NULL, 0, NULL, NULL);
    char *copy = room((size_t)size);

    WideCharToMultiByte(CP_UTF8, 0, text, -1, copy, size, NULL, NULL);
    return copy;
}

/* A path in the form that Windows wants. The caller frees it. */
static wchar_t *wide(const char *path)
{
    const int size = MultiByteToWideChar(CP_UTF8, 0, path, -1, NULL, 0);
    wchar_t *copy = room((size_t)size * sizeof *copy), *c;

    MultiByteToWideChar(CP_UTF8, 0, path, -1, copy, size);
    for (c = copy; *c != 0; c++) {
        *c = *c == L'/' ? L'\\' : *c;
    }
    return copy;
}

/* The console shows UTF-8 while this program runs. */
static UINT page_of_before;

static void restore_console(void)
{
    SetConsoleOutputCP(page_of_before);
}

void cli_os_begin(int *argc, char ***argv)
{
    wchar_t **given = CommandLineToArgvW(GetCommandLineW(), argc);
    int i;

    *argv = room(((size_t)*argc + 1) * sizeof **argv);
    for (i = 0; i < *argc; i++) {
        (*argv)[i] = narrow(given[i]);
    }
    (*argv)[*argc] = NULL;
    LocalFree(given);
    _setmode(_fileno(stdout), _O_BINARY);
    _setmode(_fileno(stderr), _O_BINARY);
    page_of_before = GetConsoleOutputCP();
    if (page_of_before != 0 && SetConsoleOutputCP(CP_UTF8)) {
        atexit(restore_console);
    }
}

int cli_os_is_terminal(void)
{
    enum { RUBS_OUT = 4 }; /* ENABLE_VIRTUAL_TERMINAL_PROCESSING */
    HANDLE console = GetStdHandle(STD_ERROR_HANDLE);
    DWORD mode;

    return GetConsoleMode(console, &mode) && SetConsoleMode(console, mode | RUBS_OUT);
}

/* Number of bytes of the UTF-8 character that begins with this byte; 0 if none does. */
static int length_of(unsigned char first)
{
    return first < 0x80   ? 1
           : first < 0xc2 ? 0
           : first < 0xe0 ? 2
           : first < 0xf0 ? 3
           : first < 0xf5 ? 4
                          : 0;
}

unsigned long cli_os_character(int *is_blank, const char **text)
{
    const int length = length_of((unsigned char)**text);
    wchar_t c[2] = {0};
    WORD kind = 0;
    int count = 0;

    if (length > 0 && strlen(*text) >= (size_t)length) {
        count = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, *text, length, c, 2);
    }
    if (count == 0) {
        c[0] = (unsigned char)**text;
    }
    *text += count == 0 ? 1 : length;
    GetStringTypeW(CT_CTYPE1, c, 1, &kind);
    *is_blank = (kind & C1_SPACE) != 0 && c[0] != 0xa0;
    CharLowerBuffW(c, count == 2 ? 2 : 1);
    return count == 2 ? 0x10000UL + (((unsigned long)c[0] & 0x3ff) << 10) + (c[1] & 0x3ffU)
                      : c[0];
}

/* ---- files ---------------------------------------------------------------- */

FILE *cli_os_open(const char *path)
{
    wchar_t *name = wide(path);
    FILE *file = _wfopen(name, L"rb");

    free(name);
    return file;
}

FILE *cli_os_create(const char *path)
{
    wchar_t *name = wide(path);
    const int fd =
        _wopen(name, _O_WRONLY | _O_CREAT | _O_EXCL | _O_BINARY, _S_IREAD | _S_IWRITE);

    free(name);
    return fd < 0 ? NULL : _fdopen(fd, "wb");
}

/* The errno for an error of GetLastError. */
static int reason_of(DWORD error)
{
    switch (error) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
        return ENOENT;
    case ERROR_ALREADY_EXISTS:
    case ERROR_FILE_EXISTS:
        return EEXIST;
    case ERROR_DISK_FULL:
        return ENOSPC;
    case ERROR_ACCESS_DENIED:
    case ERROR_SHARING_VIOLATION:
        return EACCES;
    default:
        return EIO;
    }
}

/* Virus scanners and the like hold a new file open for a moment. Then the call is tried
 * again. */
int cli_os_rename(const char *from, const char *to)
{
    enum { TRIES = 20, PAUSE_MS = 50 };
    wchar_t *old = wide(from), *name = wide(to);
    int tries, done = 0;

    for (tries = 0; tries < TRIES && !done; tries++) {
        done = MoveFileExW(old, name, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH);
        errno = done ? 0 : reason_of(GetLastError());
        if (!done && errno != EACCES) {
            break;
        }
        if (!done) {
            Sleep(PAUSE_MS);
        }
    }
    free(name);
    free(old);
    return done ? 0 : -1;
}

int cli_os_remove(const char *path)
{
    wchar_t *name = wide(path);
    const int failed = _wunlink(name);

    free(name);
    return failed;
}

int cli_os_make_folder(const char *path)
{
    wchar_t *name = wide(path);
    const int failed = _wmkdir(name);

    free(name);
    return failed;
}

int cli_os_remove_folder(const char *path)
{
    wchar_t *name = wide(path);
    const int failed = _wrmdir(name);

    free(name);
    return failed;
}

int cli_os_make_own_folder(char *path)
{
    static const char LETTERS[] = "abcdefghijklmnopqrstuvwxyz0123456789";
    enum { LENGTH = 6, TRIES = 100 };
    char *end = path + strlen(path) - LENGTH;
    unsigned long seed = GetCurrentProcessId() * 2654435761UL + GetTickCount();
    int tries, i;

    for (tries = 0; tries < TRIES; tries++) {
        for (i = 0; i < LENGTH; i++) {
            seed = (seed * 1664525UL + 1013904223UL) & 0xffffffffUL;
            end[i] = LETTERS[(seed >> 16) % (sizeof LETTERS - 1)];
        }
        if (cli_os_make_folder(path) == 0 || errno != EEXIST) {
            return cli_os_look(path) == CLI_OS_FOLDER ? 0 : -1;
        }
    }
    return -1;
}

int cli_os_publish(const char *own, const char *folder)
{
    return cli_os_rename(own, folder);
}

int cli_os_look(const char *path)
{
    wchar_t *name = wide(path);
    const DWORD there = GetFileAttributesW(name);

    free(name);
    if (there == INVALID_FILE_ATTRIBUTES) {
        errno = reason_of(GetLastError());
        return CLI_OS_NOTHING;
    }
    return there & FILE_ATTRIBUTE_DIRECTORY ? CLI_OS_FOLDER : CLI_OS_OTHER;
}

int cli_os_look_at_link(const char *path)
{
    return cli_os_look(path);
}

void cli_os_list(const char *folder, void (*tell)(const char *folder, const char *name))
{
    const size_t length = strlen(folder);
    char *all = room(length + 3);
    wchar_t *pattern;
    WIN32_FIND_DATAW entry;
    HANDLE list;

    memcpy(all, folder, length);
    strcpy(all + length, "/*");
    pattern = wide(all);
    list = FindFirstFileW(pattern, &entry);
    if (list != INVALID_HANDLE_VALUE) {
        do {
            char *name = narrow(entry.cFileName);

            tell(folder, name);
            free(name);
        } while (FindNextFileW(list, &entry));
        FindClose(list);
    }
    free(pattern);
    free(all);
}

int cli_os_is_slash(char c)
{
    return c == '/' || c == '\\';
}

/* Length of the root of a path: "C:\" or "C:", "\\computer\share". */
size_t cli_os_root(const char *path)
{
    size_t i = 2;
    int names;

    if (path[0] != '\0' && path[1] == ':') {
        return cli_os_is_slash(path[2]) ? 3 : 2;
    }
    if (!cli_os_is_slash(path[0]) || !cli_os_is_slash(path[1])) {
        return 1;
    }
    for (names = 0; names < 2; names++) {
        for (; path[i] != '\0' && !cli_os_is_slash(path[i]); i++) {
        }
        i += path[i] != '\0';
    }
    return i;
}

/* ---- Ctrl C and the like -------------------------------------------------- */

enum { ENDED_BY_CONTROL_C = -1073741510 }; /* STATUS_CONTROL_C_EXIT, 0xC000013A */

static volatile LONG has_signal;

/* Runs in a thread of its own. For all events except Ctrl C and Ctrl Break, the system ends
 * the program when this function returns. So it waits until the program has ended by
 * itself. */
static BOOL WINAPI hear(DWORD signal)
{
    InterlockedExchange(&has_signal, 1);
    if (signal != CTRL_C_EVENT && signal != CTRL_BREAK_EVENT) {
        Sleep(INFINITE);
    }
    return TRUE;
}

void cli_os_hold_signals(void)
{
    SetConsoleCtrlHandler(hear, TRUE);
}

int cli_os_must_end(void)
{
    return InterlockedExchangeAdd(&has_signal, 0) != 0;
}

void cli_os_release_signals(void)
{
    SetConsoleCtrlHandler(hear, FALSE);
    if (cli_os_must_end()) {
        exit(ENDED_BY_CONTROL_C);
    }
}

#endif
