/** @file
 * Texts that are kept. Internal. */
#ifndef LUM_BASE_TEXT_COPY_H
#define LUM_BASE_TEXT_COPY_H

/** A copy of a text, which ISO C has no function for.
 * @return to be freed with free(); NULL without memory. */
char *lum_text_copy(const char *text);

#endif
