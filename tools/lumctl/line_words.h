/* A typed line to words. */
#ifndef LUMCTL_LINE_WORDS_H
#define LUMCTL_LINE_WORDS_H

/* Takes white space off both ends, in place. */
void words_trim(char *text);

/* Cuts into words in place: white space parts them, but not inside '...' or
 * "...". Returns how many, -1 if a quote is not closed or there are more than
 * max. */
int words_cut(char *text, char **words, int max);

#endif
