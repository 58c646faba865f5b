/** @file
 * Text into an array that the caller provides, without a C library. Internal to
 * host and config. */
#ifndef LUM_HOST_KEY_TEXT_H
#define LUM_HOST_KEY_TEXT_H

#include <stddef.h>
#include <stdint.h>

/** A text that grows; text that does not fit is cut, and counted. */
typedef struct lum_key_text {
    char *out;   /**< size bytes, always terminated; NULL if size is 0 */
    size_t size; /**< how many */
    size_t len;  /**< bytes of the whole text, also of what was cut */
} lum_key_text;

/** Begin with an empty text. */
lum_key_text lum_key_text_begin(char *out, size_t size);

/** Add a string. */
void lum_key_text_add(lum_key_text *text, const char *string);

/** Add len bytes as they are. */
void lum_key_text_add_bytes(lum_key_text *text, const char *bytes, size_t len);

/** Add number x 10^-decimals, without zeros at the end of its fraction.
 * @param decimals 0..12. */
void lum_key_text_add_number(lum_key_text *text, int64_t number, int decimals);

/** Add a piece of the input, as plain ASCII, cut if it is long. */
void lum_key_text_add_quoted(lum_key_text *text, const char *bytes, size_t len);

/** Bytes of a string before its end. */
size_t lum_key_text_length(const char *string);

#endif
