/** @file
 * A strict reader of small YAML files: nested mappings of numbers and words,
 * compared with a table of keys. Internal to config.
 *
 * The table limits the depth of the file: a key that it does not contain is
 * refused at its place. Also refused: sequences but for one of mappings,
 * anchors, aliases, tags, a second document, a file without keys. */
#ifndef LUM_CONFIG_YAML_H
#define LUM_CONFIG_YAML_H

#include "host/key_table.h"
#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>

/** A text and its name. */
typedef struct lum_yaml_source {
    const char *text; /**< len bytes */
    size_t len;       /**< how many */
    const char *name; /**< for messages */
} lum_yaml_source;

/** Most bytes of a file with a list; of others, LUM_CONFIG_BYTES_MAX. */
#define LUM_YAML_LIST_BYTES_MAX (1u << 20)

/** A file in memory; a byte more than is accepted of any file shows that it is
 * longer. */
typedef struct lum_yaml_file {
    const char *name;                         /**< for messages */
    size_t len;                               /**< how many bytes */
    char bytes[LUM_YAML_LIST_BYTES_MAX + 1u]; /**< len of them */
} lum_yaml_file;

/** Read a file.
 * @param path lives as long as it; "-": standard input.
 * @return to be freed by lum_yaml_end(); NULL with the error set. */
lum_yaml_file *lum_yaml_load(const char *path, lum_error *error);

/** It was parsed: free it.
 * @return result. */
int lum_yaml_end(lum_yaml_file *file, int result);

/** Read a file's values.
 * @param values one for each index of the table; each is set as it is read,
 *               its place the line of its key. On failure some may have been.
 * @return 0, or -1 with the error set. */
LUM_MUST_CHECK int lum_yaml_read(const lum_yaml_source *source,
                                 const lum_key_table *table,
                                 lum_key_value *values, lum_error *error);

/** Takes a value that its rule allows, as text. LUM_OK, or `why` says what is
 * wrong.
 * @param path  of its key, in the file or in a mapping of its list.
 * @param value lives until this returns. */
typedef lum_result (*lum_yaml_take_text)(void *context, bool is_in_list,
                                         const char *path, const char *value,
                                         lum_key_refusal *why);

/** A sequence of mappings at a key of a table, such as "steps". */
typedef struct lum_yaml_list {
    const char *key;            /**< an entry of the file's table */
    const lum_key_table *table; /**< of each mapping */
    lum_key_value *values;      /**< of one mapping, by the indexes of that */
    size_t value_count;         /**< how many; zeroed before each */
    size_t max;                 /**< most mappings */
    /** Takes the values of a mapping, the number-th from 1 on, that begins at a
     * line. 0, or -1 with the error set. */
    int (*take)(void *context, unsigned number, unsigned line);
    void *context;                /**< its own */
    lum_yaml_take_text take_text; /**< gets all values, also of the file; or
                                       NULL */
} lum_yaml_list;

/** As lum_yaml_read(), of a file with a list. In messages, a key of the third
 * mapping of "steps" is "steps.3.power". */
LUM_MUST_CHECK int lum_yaml_read_list(const lum_yaml_source *source,
                                      const lum_key_table *table,
                                      lum_key_value *values,
                                      const lum_yaml_list *list,
                                      lum_error *error);

/** Set an error as NAME:LINE: KEY: message.
 * @param line 0: none.
 * @param key  full path, or NULL.
 * @return -1. */
LUM_PRINTF(5, 6)
int lum_yaml_fail(lum_error *error, const char *name, unsigned line,
                  const char *key, const char *format, ...);

#endif
