/** @file
 * A YAML file in memory. Internal to config. */
#ifndef LUM_CONFIG_FILE_TEXT_H
#define LUM_CONFIG_FILE_TEXT_H

#include "lum/base/error.h"
#include "yaml.h"

#include <stddef.h>

/** Its text; a byte more than is accepted of any file shows that it is
 * longer. */
typedef struct lum_file_text {
    const char *name;                         /**< for messages */
    size_t len;                               /**< how many bytes */
    char bytes[LUM_YAML_LIST_BYTES_MAX + 1u]; /**< len of them */
} lum_file_text;

/** Read a file.
 * @param path lives as long as the text; "-": standard input.
 * @return to be freed with lum_file_text_free(); NULL with the error set. */
lum_file_text *lum_file_text_load(const char *path, lum_error *error);

/** Free it. */
void lum_file_text_free(lum_file_text *text);

#endif
