/* Small files that outlive the program, in the user's folder of states. */
#ifndef LUMCTL_STORE_H
#define LUMCTL_STORE_H

#include "lum/base/error.h"

#include <stddef.h>
#include <stdint.h>

#define STORE_PATH_BYTES 1024

/* A lock on the folder: while it is held, no other lumctl changes the files. */
struct store_lock {
    intptr_t handle;
};

/* The folder, which need not be there: $XDG_STATE_HOME/lumsdk/sensors, or that
 * in ~/.local/state; on Windows in %LOCALAPPDATA%. 0, or -1 where there is no
 * home, with the reason in error. */
int store_folder(char out[STORE_PATH_BYTES], lum_error *error);

/* Makes the folder if it does not exist, and waits for the lock at most this
 * long. 0, or -1 with the reason in error. */
int store_lock(const char *folder, int64_t wait_ns, struct store_lock *out,
               lum_error *error);
void store_unlock(const struct store_lock *lock);

/* Reads a file of less than size bytes and ends it with a NUL: 1; 0 if it is
 * not there; -1 with the reason in error. */
int store_read(const char *path, char *out, size_t size, lum_error *error);

/* Replaces a file as a whole: a reader sees the old one or the new one. 0, or
 * -1 with the reason in error. */
int store_write(const char *path, const char *text, size_t len,
                lum_error *error);

/* Removes a file; one that is not there is none of its troubles. */
void store_remove(const char *path);

#endif
