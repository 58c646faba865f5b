/** @file
 * The allowed values of a key, for reading and for messages. Internal to host
 * and config. */
#ifndef LUM_HOST_KEY_RULE_H
#define LUM_HOST_KEY_RULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* --- Text into an array that the caller provides, without a C library --- */

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

/* --- Rules --- */

/** A word that stands for a number. */
typedef struct lum_key_word {
    const char *text; /**< NULL after the last one */
    int64_t number;   /**< what the value becomes */
} lum_key_word;

/** What a value may be. */
typedef struct lum_key_rule {
    const lum_key_word *words; /**< or NULL */
    int64_t min;               /**< smallest number */
    int64_t max;               /**< largest number; below min: none allowed */
    int decimals;              /**< units of 10^-decimals of the text's unit */
    bool whole;                /**< no point, no exponent */
    bool pair;                 /**< two whole numbers, [LOW, HIGH] */
    bool rare;                 /**< not written where it is usual, so that
                                    earlier versions read the rest */
    int64_t usual;             /**< of a rare value */
    const char *unit;          /**< the text's unit, such as "deg"; or NULL */
    const char *allowed;       /**< the allowed numbers in words, if min and max
                                    do not describe them; or NULL */
    const char *(*check)(const char *text, size_t len); /**< of a text that is
                            no number: NULL, or why it is refused; its number
                            is 0. NULL: this is no such text */
    const char *refusal; /**< why the key may not be given; such a key is not
                            listed as allowed; or NULL */
} lum_key_rule;

/** A pair as one number, and its parts; both are 0 to 255. */
#define LUM_KEY_PAIR(low, high) ((low) | (high) << 8)
#define LUM_KEY_PAIR_LOW(pair)  ((pair)&0xff)
#define LUM_KEY_PAIR_HIGH(pair) ((pair) >> 8)

/** A value as it is given. */
typedef struct lum_key_given {
    const char *text; /**< len bytes; need not be terminated */
    size_t len;       /**< how many */
    bool is_quoted;   /**< it may be a word, but not a number */
} lum_key_given;

/** Read a value.
 * @param out written only on success.
 * @return NULL, or why it is refused: what follows "'VALUE' ". */
const char *lum_key_rule_read(const lum_key_rule *rule, lum_key_given given,
                              int64_t *out);

/** Add the value's text, as lum_key_rule_read() reads it. */
void lum_key_rule_add_value(const lum_key_rule *rule, int64_t number,
                            lum_key_text *text);

/** Whether a value is one of the words. */
bool lum_key_rule_is_word(const lum_key_rule *rule, int64_t number);

/** Whether numbers are allowed. */
bool lum_key_rule_takes_numbers(const lum_key_rule *rule);

/** Add what is allowed, such as "none, or 8 to 64". */
void lum_key_rule_add_allowed(const lum_key_rule *rule, lum_key_text *text);

/* --- Numbers: key_number.c --- */

/** How reading a number went. */
typedef enum lum_key_number {
    LUM_KEY_NUMBER_FINE,         /**< read */
    LUM_KEY_NUMBER_NONE,         /**< not a decimal number */
    LUM_KEY_NUMBER_NOT_WHOLE,    /**< has a point or an exponent */
    LUM_KEY_NUMBER_LEADING_ZERO, /**< some read it as octal, others as
                                      decimal */
    LUM_KEY_NUMBER_TOO_LARGE     /**< beyond 64 bits */
} lum_key_number;

/** Read `[+-]digits[.digits][e[+-]digits]`, nothing before or after it.
 * @param text     len bytes; need not be terminated.
 * @param decimals 0..12; the result counts units of 10^-decimals.
 * @param whole    refuse a point and an exponent.
 * @param out      the number, rounded to the unit, half away from zero; written
 *                 only on success. */
lum_key_number lum_key_number_parse(const char *text, size_t len, int decimals,
                                    bool whole, int64_t *out);

#endif
