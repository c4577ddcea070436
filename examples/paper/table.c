#include "table.h"

#include <math.h>
#include <stdlib.h>

#include "scene.h"

const char *table_folder;
int table_every = 1;

FILE *table_open(const char *name)
{
    char path[1000];
    FILE *file;

    paper_expect((size_t)snprintf(path, sizeof path, "%s/%s.csv", table_folder, name) <
                     sizeof path,
                 "the folder's name is too long");
    file = fopen(path, "w");
    if (file == NULL) {
        perror(path);
        exit(1);
    }
    return file;
}

void table_close(FILE *file)
{
    paper_expect(!ferror(file) && fclose(file) == 0, "a file is not written");
}

/* ---- medians and quartiles ---------------------------------------------- */

void sample_add(sample *s, double value)
{
    paper_expect(s->n < SAMPLE_MAX, "a sample is full");
    s->value[s->n++] = value;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* A quantile of the sorted values. It does not interpolate, so infinite values stay
 * infinite. */
static double quantile(const sample *s, double part)
{
    return s->n > 0 ? s->value[(int)(part * (s->n - 1) + 0.5)] : HUGE_VAL;
}

void sample_print(FILE *file, sample *s)
{
    qsort(s->value, (size_t)s->n, sizeof s->value[0], by_size);
    for (int k = 1; k <= 3; k++) {
        fprintf(file, ",%.4g", quantile(s, k / 4.0));
    }
}
