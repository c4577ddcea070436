/* table.h - the CSV files that the figures are drawn from, and medians in them. */
#ifndef PAPER_TABLE_H
#define PAPER_TABLE_H

#include <stdio.h>

/* Where the tables go; set once by main. */
extern const char *table_folder;

/* The fraction of the long tables that is made: one depth of fig06_share, or resolution of
 * fig09 and fig10-14, in this many. 1: all. main sets it once. */
extern int table_every;

/* Opens NAME.csv in that folder. The program ends if it cannot be written. */
FILE *table_open(const char *name);
void table_close(FILE *file);

enum { SAMPLE_MAX = 8000 };

/* The value is infinite if a method gave no result. */
typedef struct {
    double value[SAMPLE_MAX];
    int n;
} sample;

void sample_add(sample *s, double value);

/* Prints ",q25,median,q75". */
void sample_print(FILE *file, sample *s);

#endif
