/** @file
 * Where the bytes of a capture come from: a file, a pipe, memory, or a function
 * of the caller, for example one that reads from an object store.
 *
 * Only one thread at a time may use a source; two share nothing. */
#ifndef LUM_CAPTURE_SOURCE_H
#define LUM_CAPTURE_SOURCE_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A source of bytes, read from its start to its end, or from another place if
 * it allows that. */
typedef struct lum_source lum_source;

/** The functions of a source that a caller provides. All bytes except
 * struct_size and read may be 0. */
typedef struct lum_source_functions {
    size_t struct_size; /**< sizeof(lum_source_functions) */
    /** Read the next bytes. May wait for them; returns as soon as there are
     * any. Not called again after 0 or -1.
     * @param context as in lum_source_functions.
     * @param buffer  to be filled; room is at least 1.
     * @param error   gets the message on failure; never NULL.
     * @return how many bytes, at most room; 0 at the end; -1 on failure. */
    int64_t (*read)(void *context, void *buffer, size_t room, lum_error *error);
    /** Called once, when the source is closed; may be NULL. */
    void (*close)(void *context);
    void *context;  /**< given to these */
    uint64_t total; /**< bytes in all, for the progress of a reading; 0 if
                         that is not known */
    /** Go on reading from another place, for lum_reader_seek_frame() and the
     * like; also after read returned 0 or -1. NULL: cannot seek.
     * @param offset from the start, in bytes.
     * @param error  gets the message on failure; never NULL.
     * @return 0, or -1 on failure. */
    int (*seek)(void *context, uint64_t offset, lum_error *error);
} lum_source_functions;

/** Open a file.
 * @param path  a file, a pipe or a device, or "-" for standard input.
 * @param out   gets a source to be closed with lum_source_close(), unless a
 *              capture takes it over.
 * @param error gets the message on failure, with the system's reason.
 * @return 0, or -1; errno says why. */
LUM_MUST_CHECK int lum_source_open(const char *path, lum_source **out,
                                   lum_error *error);

/** A source of bytes in memory.
 * @param name  used as the file's name in messages; copied.
 * @param bytes not copied: keep them until the source is closed.
 * @return to be closed with lum_source_close(); NULL without memory. */
LUM_MUST_CHECK lum_source *lum_source_from_memory(const char *name,
                                                  const void *bytes,
                                                  size_t len);

/** A source that a function reads. Takes 512 KB.
 * @param name      used as the file's name in messages; copied.
 * @param functions copied.
 * @param error     may be NULL; gets the message on failure: struct_size or
 *                  read is not set, or there is no memory.
 * @return to be closed with lum_source_close(); NULL on failure, and then
 *         nothing is called. */
LUM_MUST_CHECK lum_source *lum_source_from_functions(
    const char *name, const lum_source_functions *functions, lum_error *error);

/** Close. NULL is allowed. */
void lum_source_close(lum_source *source);

#ifdef __cplusplus
}
#endif

#endif
