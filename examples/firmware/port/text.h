/* Lines of text without printf: put pieces, then end the line. */
#ifndef TEXT_H
#define TEXT_H

#include <stddef.h>
#include <stdint.h>

#define TEXT_MAX 128

/* A line being written; text that does not fit is cut. Begins as {0}. */
typedef struct text {
    char line[TEXT_MAX];
    size_t len;
} text;

void text_put(text *t, const char *s);
void text_put_number(text *t, uint64_t value);
void text_put_signed(text *t, int64_t value);
void text_put_hex(text *t, uint64_t value); /* 16 digits */
void text_pad(text *t, size_t column);      /* spaces up to there */

/* Writes the line, and begins another. */
void text_end(text *t);

#endif
