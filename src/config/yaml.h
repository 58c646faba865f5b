/** @file
 * A strict reader of small YAML files: nested mappings of numbers and words,
 * held against tables. Internal to config.
 *
 * A table gives the keys of a mapping; a key has a rule for a scalar, a table
 * for a mapping, or both; a rule gives the numbers and words that are allowed,
 * for the reader and for its messages alike. Whatever a table does not name is
 * refused where it stands, so the tables bound the depth of what is read. Also
 * refused: sequences, anchors, aliases, tags, a second document, a file without
 * keys. */
#ifndef LUM_CONFIG_YAML_H
#define LUM_CONFIG_YAML_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Most keys of one table. */
#define LUM_YAML_KEYS_MAX 16

/** A value as the file gives it. */
typedef struct lum_yaml_value {
    int64_t number; /**< in the rule's units, or the word's number */
    unsigned line;  /**< where its key stands; 0: the file does not name it */
} lum_yaml_value;

/** A word that stands for a number. */
typedef struct lum_yaml_word {
    const char *text; /**< NULL behind the last one */
    int64_t number;   /**< what the value becomes */
} lum_yaml_word;

/** What a scalar may be. */
typedef struct lum_yaml_rule {
    const lum_yaml_word *words; /**< or NULL */
    int64_t min;                /**< smallest number */
    int64_t max;                /**< largest number; below min: none allowed */
    int decimals;               /**< units of 10^-decimals of the file's */
    bool whole;                 /**< no point, no exponent */
    const char *unit;           /**< the file's unit, such as " deg" */
    const char *allowed;        /**< the numbers in words, if min and max do
                                     not say it all; or NULL */
    const char *refusal;        /**< why no file may have the key, which then is
                                     not among those allowed; or NULL */
} lum_yaml_rule;

/** A key of a mapping. */
typedef struct lum_yaml_key {
    const char *name;                   /**< as it stands in the file */
    unsigned index;                     /**< of its value, or of the first
                                             value of its table, counted from
                                             the table's own first value */
    const lum_yaml_rule *rule;          /**< for a scalar; or NULL */
    const struct lum_yaml_table *table; /**< for a mapping; or NULL */
} lum_yaml_key;

/** The keys of a mapping. */
typedef struct lum_yaml_table {
    const lum_yaml_key *keys; /**< count of them */
    size_t count;             /**< at most LUM_YAML_KEYS_MAX */
} lum_yaml_table;

/** A text and its name. */
typedef struct lum_yaml_source {
    const char *text; /**< len bytes */
    size_t len;       /**< how many */
    const char *name; /**< for messages */
} lum_yaml_source;

/** Read a file's values.
 * @param values one for each index; those that the file does not name are left
 *               alone. On failure some may have been written.
 * @return 0, or -1 with the error set. */
LUM_MUST_CHECK int lum_yaml_read(const lum_yaml_source *source,
                                 const lum_yaml_table *root,
                                 lum_yaml_value *values, lum_error *error);

/** Say what is allowed for a key.
 * @param out size bytes, gets a terminated string, cut where it is full. */
void lum_yaml_allowed(const lum_yaml_key *key, char *out, size_t size);

/** Set an error as NAME:LINE: KEY: message.
 * @param line 0: none.
 * @param key  full path, or NULL.
 * @return -1. */
LUM_PRINTF(5, 6)
int lum_yaml_fail(lum_error *error, const char *name, unsigned line,
                  const char *key, const char *format, ...);

#endif
