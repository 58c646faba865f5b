/* Small files that outlive the program, in the user's folder of states. Only
 * their user may read them. */
#ifndef LUMCTL_STATE_FILE_H
#define LUMCTL_STATE_FILE_H

#include "lum/base/error.h"

#include <stddef.h>
#include <stdint.h>

#define STATE_PATH_BYTES 1024

/* The folder, which need not be there: $XDG_STATE_HOME/lumsdk/sensors, or that
 * in ~/.local/state; on Windows in %LOCALAPPDATA%. 0, or -1 where there is no
 * home, with the reason in error. */
int state_folder(char out[STATE_PATH_BYTES], lum_error *error);

/* Makes the folder if it does not exist, and waits for the lock on it at most
 * this long: while it is held, no other lumctl changes the files. A descriptor
 * for state_unlock(), or -1 with the reason in error. */
int state_lock(const char *folder, int64_t wait_ns, lum_error *error);
void state_unlock(int lock);

/* Reads a file of less than size bytes and ends it with a NUL: 1; 0 if it is
 * not there; -1 with the reason in error. */
int state_read(const char *path, char *out, size_t size, lum_error *error);

/* Replaces a file as a whole, with the lock held: a reader sees the old one or
 * the new one. 0, or -1 with the reason in error. */
int state_write(const char *path, const char *text, size_t len,
                lum_error *error);

#endif
