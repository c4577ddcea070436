/* table.h - the CSV files that the figures are drawn from, and medians in them. */
#ifndef PAPER_TABLE_H
#define PAPER_TABLE_H

#include <stdio.h>

/* Where the tables go; set once by main. */
extern const char *table_folder;

/* Of the depths of fig06_share, and of the resolutions of fig09 and of fig10-14, one in so
 * many is done: 1, all; set once by main. */
extern int table_every;

/* NAME.csv there; a file that cannot be written ends the program. */
FILE *table_open(const char *name);
void table_close(FILE *file);

enum { SAMPLE_MAX = 8000 };

/* Infinite where a method gave nothing. */
typedef struct {
    double value[SAMPLE_MAX];
    int n;
} sample;

void sample_add(sample *s, double value);

/* ",q25,median,q75" */
void sample_print(FILE *file, sample *s);

#endif
