/* A folder as rosbag2 makes one: MCAP files, and metadata.yaml, which says what
 * is in them. */
#ifndef LUMDUMP_BAG_FOLDER_H
#define LUMDUMP_BAG_FOLDER_H

#include "lum/base/error.h"
#include "lum/cloud/writer.h"

#include <stdbool.h>
#include <stddef.h>

struct bag_folder;

/* Make the folder, which may not be there yet. NULL with the reason in error.
 * path: kept. */
struct bag_folder *bag_folder_new(const char *path, lum_error *error);

/* The name of its next file: drive/drive_0.mcap and so on. False: too long. */
bool bag_folder_next_name(struct bag_folder *folder, char *out, size_t size);

/* A file is about to be finished: remember what it has. number: from 0, as they
 * were named. 0, or -1 with the reason in error. */
int bag_folder_note(struct bag_folder *folder, size_t number,
                    const lum_writer *file, lum_error *error);

/* All files are finished: write metadata.yaml. 0, or -1 with the reason in
 * error. */
int bag_folder_finish(const struct bag_folder *folder, lum_error *error);

/* Free it; a folder without any file is removed. NULL is allowed. */
void bag_folder_free(struct bag_folder *folder);

#endif
