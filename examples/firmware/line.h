/* line.h - a line of text for the serial line, without printf. */
#ifndef LINE_H
#define LINE_H

#include "rigcal.h"

/* An empty line has n = 0. Text that does not fit is left out. */
typedef struct {
    char text[320];
    size_t n;
} line;

void put_text(line *out, const char *text);

/* Appends six decimals; see README.md. */
void put_micro(line *out, rigcal_real x);

/* Appends a name and a number. */
void put_count(line *out, const char *name, uint32_t x);
void put_vector(line *out, const char *name, const rigcal_real x[3]);
void put_status(line *out, rigcal_status status);

/* Sends the line with CR LF at its end. */
void send_line(line *out);

#endif /* LINE_H */
