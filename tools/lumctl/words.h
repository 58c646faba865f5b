/* A typed line to words, and bytes of a sensor to printable text. */
#ifndef LUMCTL_WORDS_H
#define LUMCTL_WORDS_H

#include <stddef.h>
#include <stdint.h>

/* Takes white space off both ends, in place. */
void words_trim(char *text);

/* Cuts into words in place: white space parts them, but not inside '...' or
 * "...". Returns how many, -1 if a quote is not closed or there are more than
 * max. */
int words_cut(char *text, char **words, int max);

/* Bytes of the wire as text for a terminal: what is not printable ASCII
 * becomes '?'. Cut to size - 1 characters. */
void words_printable(const uint8_t *bytes, size_t len, char *out, size_t size);

#endif
