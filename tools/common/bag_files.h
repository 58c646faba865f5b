/* The captures in a folder that rosbag2 made, or that lumdump made so. */
#ifndef LUM_TOOLS_BAG_FILES_H
#define LUM_TOOLS_BAG_FILES_H

#include "lum/base/error.h"

#include <stddef.h>

/* The .mcap files in a folder, in the order of their names, which does not
 * matter where captures are read by their times; one block holds all: free().
 * metadata.yaml is not read, because a recording that was killed has none. NULL
 * with the reason in error: there is no such file in it, only those of SQLite,
 * it cannot be read, or there is no memory. */
char **bag_files_list(const char *folder, size_t *count, lum_error *error);

#endif
