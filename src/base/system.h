/** @file
 * Small facts of the system. Internal. */
#ifndef LUM_BASE_SYSTEM_H
#define LUM_BASE_SYSTEM_H

#include <stdbool.h>
#include <stdint.h>

/** The last part of a path, by this system's separators. */
const char *lum_system_base(const char *path);

/** This process's number. */
long lum_system_process(void);

/** Bytes that this process can still write to the disk of a file's folder.
 * @return whether that is known. */
bool lum_system_free_bytes(const char *path, uint64_t *out);

#if !defined(_WIN32)
/** Wait until what was written to a file is on the disk. What cannot be asked
 * for it, as some file systems, counts as done.
 * @return 0, or an errno. */
int lum_system_sync(int fd);

/** Wait until the name of a file is on the disk: its directory holds the name.
 * A directory that this process may not read cannot be asked, and counts as
 * done.
 * @return 0, or an errno. */
int lum_system_sync_name(const char *path);
#endif

#endif
