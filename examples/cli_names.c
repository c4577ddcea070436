/* Names, numbered in order of first appearance, and names that look alike. */
#include "cli_input.h"
#include "cli_os.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void cli_names_open(cli_names *names)
{
    enum { ROOM = 16 };

    memset(names, 0, sizeof *names);
    names->room = ROOM;
    names->n_slots = 2 * names->room + 1;
    names->slots = cli_alloc(names->n_slots, sizeof *names->slots);
    names->name = cli_alloc(names->room, sizeof *names->name);
}

/* The FNV-1a hash of a name. */
static uint32_t hash_of(const char *text)
{
    uint32_t hash = 2166136261U;

    for (; *text != '\0'; text++) {
        hash = (hash ^ (unsigned char)*text) * 16777619U;
    }
    return hash;
}

/* The slot of the name, or the free slot in which it belongs. */
static size_t slot_of(const cli_names *names, const char *name)
{
    size_t slot;

    for (slot = hash_of(name) % names->n_slots; names->slots[slot] != 0;
         slot = (slot + 1) % names->n_slots) {
        if (strcmp(names->name[names->slots[slot] - 1], name) == 0) {
            break;
        }
    }
    return slot;
}

size_t cli_names_find(const cli_names *names, const char *name)
{
    const size_t number = names->slots[slot_of(names, name)];

    return number > 0 ? number - 1 : CLI_UNKNOWN;
}

/* A copy of the name that is never moved. Many names share a block of memory. */
static const char *keep(cli_names *names, const char *name)
{
    enum { BLOCK = 4096 };
    const size_t size = strlen(name) + 1;
    char *copy;

    if (size > names->text_left) {
        names->text_left = size > BLOCK ? size : BLOCK;
        names->text = cli_alloc(names->text_left, 1);
    }
    copy = memcpy(names->text, name, size);
    names->text += size;
    names->text_left -= size;
    return copy;
}

/* Makes room for twice as many names. */
static void enlarge(cli_names *names)
{
    size_t i;

    names->room *= 2;
    names->name = cli_resize(names->name, names->room, sizeof *names->name);
    cli_free(names->slots);
    names->n_slots = 2 * names->room + 1;
    names->slots = cli_alloc(names->n_slots, sizeof *names->slots);
    for (i = 0; i < names->count; i++) {
        names->slots[slot_of(names, names->name[i])] = (uint32_t)(i + 1);
    }
}

size_t cli_names_add(cli_names *names, const char *name)
{
    size_t slot = slot_of(names, name);

    if (names->slots[slot] != 0) {
        return names->slots[slot] - 1;
    }
    if (names->count == names->room) {
        enlarge(names);
        slot = slot_of(names, name);
    }
    names->name[names->count++] = keep(names, name);
    names->slots[slot] = (uint32_t)names->count;
    return names->count - 1;
}

void cli_names_close(cli_names *names)
{
    if (names->slots == NULL) {
        return;
    }
    cli_free(names->slots);
    names->slots = NULL;
    names->name = cli_resize(names->name, names->count, sizeof *names->name);
    names->room = names->count;
}

/* ==== names that look alike =============================================== */

/* Characters that a key leaves out: blanks, also invisible ones, and quotes. */
static int is_ignored(unsigned long c, int is_blank)
{
    return is_blank || c == 0xa0 || (c >= 0x200b && c <= 0x200d) || c == 0x2060 ||
           c == 0xfeff || c == '"' || c == '\'';
}

/* Whether the name is a number that a double holds exactly. *value is that number. */
static int is_number(double *value, const char *name)
{
    const char *problem, *end = cli_number(value, &problem, name);

    return problem == NULL && *end == '\0' && strlen(name) <= 15;
}

/* A key that is the same for names that look alike: 5, 05 and 5.0; cam1, Cam1 and CAM01.
 * The caller frees it. */
static char *key_of(const char *name)
{
    enum { DIGITS = 9 };
    char *key = cli_alloc(DIGITS * strlen(name) + 32, 1), *end = key;
    int after_digit = 0, is_blank;
    double value;

    if (is_number(&value, name)) {
        sprintf(key, "%.17g", value + 0);
        return key;
    }
    while (*name != '\0') {
        const unsigned long c = cli_os_character(&is_blank, &name);
        const int is_leading_zero =
            c == '0' && !after_digit && *name >= '0' && *name <= '9';

        if (!is_ignored(c, is_blank) && !is_leading_zero) {
            end += sprintf(end, "%lx.", c);
            after_digit = c >= '0' && c <= '9';
        }
    }
    return key;
}

int cli_look_alike(const char *a, const char *b)
{
    char *key_a = key_of(a), *key_b = key_of(b);
    const int is_alike = strcmp(key_a, key_b) == 0;

    cli_free(key_b);
    cli_free(key_a);
    return is_alike;
}

const char *cli_names_alike(const cli_names *names, const char *name)
{
    size_t i;

    for (i = 0; i < names->count; i++) {
        if (cli_look_alike(names->name[i], name)) {
            return names->name[i];
        }
    }
    return NULL;
}

/* Names by their keys. Only the hashes of keys are held, because there may be millions of
 * names. */
typedef struct {
    const cli_names *names;
    uint32_t *hash;  /* of each name's key */
    uint32_t *slots; /* hash table: number + 1, or 0 */
    size_t n_slots;
} keyed_names;

/* The first name that has the key of name i; i if no earlier name has it. The names before
 * i must have been asked for. */
static size_t first_alike(keyed_names *keyed, size_t i)
{
    const cli_names *names = keyed->names;
    char *key = key_of(names->name[i]);
    const uint32_t hash = hash_of(key);
    size_t slot = hash % keyed->n_slots;

    cli_free(key);
    for (; keyed->slots[slot] != 0; slot = (slot + 1) % keyed->n_slots) {
        const size_t other = keyed->slots[slot] - 1;

        if (keyed->hash[other] == hash &&
            cli_look_alike(names->name[other], names->name[i])) {
            return other;
        }
    }
    keyed->hash[i] = hash;
    keyed->slots[slot] = (uint32_t)(i + 1);
    return i;
}

void cli_names_tell_alike(const cli_names *names, const char *kind, const char *path)
{
    enum { TOLD = 3 };
    const size_t n = names->count;
    keyed_names keyed = {names, cli_alloc(n, sizeof *keyed.hash),
                         cli_alloc(2 * n + 1, sizeof *keyed.slots), 2 * n + 1};
    size_t i, n_alike = 0;

    for (i = 0; i < n; i++) {
        const size_t first = first_alike(&keyed, i);

        if (first != i && ++n_alike <= TOLD) {
            cli_say("%s: %ss %s and %s are taken as two different %ss: if they are "
                    "one, spell them alike",
                    path, kind, names->name[first], names->name[i], kind);
        }
    }
    if (n_alike > TOLD) {
        cli_say("%s: so are %lu more pairs of %ss", path, (unsigned long)(n_alike - TOLD),
                kind);
    }
    cli_free(keyed.slots);
    cli_free(keyed.hash);
}
