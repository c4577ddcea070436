/* count.c - a QEMU plugin (API version 1, QEMU 4.2 to 8.x): executed instructions
 * between two marks of the emulated program, the same in every run.
 *
 *   gcc -O2 -shared -fPIC count.c -o count.so
 *   qemu-... -plugin ./count.so,out=FILE
 *
 * The program calls jobs_begin() before and jobs_end() after what is to be counted.
 * FILE gets a line "interval COUNT" for each such pair, then "symbol COUNT NAME"
 * for each function that ran in between. Neither mark's own instructions count. The
 * declarations below are of QEMU's interface, whose header Debian does not ship. */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORTED __attribute__((visibility("default")))

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void tb_callback(plugin_id, struct qemu_plugin_tb *);
typedef void exec_callback(unsigned, void *);
typedef void exit_callback(plugin_id, void *);

enum { NO_REGISTERS = 0, INLINE_ADD = 0 };

extern void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, tb_callback *);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *,
                                                        size_t);
extern const char *qemu_plugin_insn_symbol(const struct qemu_plugin_insn *);
extern void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn *, int,
                                                       void *, uint64_t);
extern void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *,
                                                   exec_callback *, int, void *);
extern void qemu_plugin_register_atexit_cb(plugin_id, exit_callback *, void *);

EXPORTED int qemu_plugin_version = 1;
EXPORTED int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv);

enum { SYMBOLS_MAX = 4096 };

static struct {
    char *name;
    uint64_t now, at_begin, inside;
} symbols[SYMBOLS_MAX];
static int n_symbols, is_inside;
static uint64_t total, total_at_begin;
static FILE *out;

static uint64_t *counter_of(const char *name)
{
    int i = 0;
    while (i < n_symbols && strcmp(symbols[i].name, name) != 0) {
        i++;
    }
    if (i == SYMBOLS_MAX) {
        fprintf(stderr, "count.so: more than %d functions\n", SYMBOLS_MAX);
        exit(1);
    }
    if (i == n_symbols) {
        symbols[n_symbols++].name = strdup(name);
    }
    return &symbols[i].now;
}

/* Called for each instruction of the two marks. The interval is from the last instruction
 * of jobs_begin to the first of jobs_end. */
static void at_begin(unsigned cpu, void *data)
{
    (void)cpu, (void)data;
    is_inside = 1;
    total_at_begin = total;
    for (int i = 0; i < n_symbols; i++) {
        symbols[i].at_begin = symbols[i].now;
    }
}

static void at_end(unsigned cpu, void *data)
{
    (void)cpu, (void)data;
    if (!is_inside) {
        return;
    }
    is_inside = 0;
    fprintf(out, "interval %" PRIu64 "\n", total - total_at_begin);
    for (int i = 0; i < n_symbols; i++) {
        symbols[i].inside += symbols[i].now - symbols[i].at_begin;
        symbols[i].at_begin = symbols[i].now;
    }
}

static void translated(plugin_id id, struct qemu_plugin_tb *tb)
{
    (void)id;
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(tb); i++) {
        struct qemu_plugin_insn *const insn = qemu_plugin_tb_get_insn(tb, i);
        const char *name = qemu_plugin_insn_symbol(insn);
        name = (name == NULL) ? "?" : name;
        if (strcmp(name, "jobs_begin") == 0) {
            qemu_plugin_register_vcpu_insn_exec_cb(insn, at_begin, NO_REGISTERS, NULL);
        } else if (strcmp(name, "jobs_end") == 0) {
            qemu_plugin_register_vcpu_insn_exec_cb(insn, at_end, NO_REGISTERS, NULL);
        } else {
            qemu_plugin_register_vcpu_insn_exec_inline(insn, INLINE_ADD, &total, 1);
            qemu_plugin_register_vcpu_insn_exec_inline(insn, INLINE_ADD, counter_of(name),
                                                       1);
        }
    }
}

static void finished(plugin_id id, void *data)
{
    (void)id, (void)data;
    for (int i = 0; i < n_symbols; i++) {
        if (symbols[i].inside > 0) {
            fprintf(out, "symbol %" PRIu64 " %s\n", symbols[i].inside, symbols[i].name);
        }
    }
    fclose(out);
}

int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv)
{
    (void)info;
    if (argc != 1 || strncmp(argv[0], "out=", 4) != 0) {
        fprintf(stderr, "count.so: wants out=FILE\n");
        return 1;
    }
    out = fopen(argv[0] + 4, "w");
    if (out == NULL) {
        perror(argv[0] + 4);
        return 1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, finished, NULL);
    return 0;
}
