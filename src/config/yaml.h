/** @file
 * A strict reader of small YAML files: nested mappings of numbers and words,
 * compared with a table of keys. Internal to config.
 *
 * The table limits the depth of the file: a key that it does not contain is
 * refused at its place. Also refused: sequences, anchors, aliases, tags, a
 * second document, a file without keys. */
#ifndef LUM_CONFIG_YAML_H
#define LUM_CONFIG_YAML_H

#include "host/key_table.h"
#include "lum/base/error.h"
#include "lum/result.h"

#include <stddef.h>

/** A text and its name. */
typedef struct lum_yaml_source {
    const char *text; /**< len bytes */
    size_t len;       /**< how many */
    const char *name; /**< for messages */
} lum_yaml_source;

/** Read a file's values.
 * @param values one for each index of the table; each is set as it is read,
 *               its place the line of its key. On failure some may have been.
 * @return 0, or -1 with the error set. */
LUM_MUST_CHECK int lum_yaml_read(const lum_yaml_source *source,
                                 const lum_key_table *table,
                                 lum_key_value *values, lum_error *error);

/** Set an error as NAME:LINE: KEY: message.
 * @param line 0: none.
 * @param key  full path, or NULL.
 * @return -1. */
LUM_PRINTF(5, 6)
int lum_yaml_fail(lum_error *error, const char *name, unsigned line,
                  const char *key, const char *format, ...);

#endif
