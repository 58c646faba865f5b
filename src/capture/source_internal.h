/** @file
 * A source's bytes through a window: bytes in the window are read in place, and
 * move only when more are requested. Internal to the capture room. */
#ifndef LUM_CAPTURE_SOURCE_INTERNAL_H
#define LUM_CAPTURE_SOURCE_INTERNAL_H

#include "base/go_on.h"
#include "lum/capture/source.h"

#include <stdbool.h>

/** Most bytes that may be asked for at a time. */
#define LUM_SOURCE_WINDOW_MAX ((size_t)32 * 1024 * 1024)

struct lum_source {
    const uint8_t *at; /**< the first byte that was not taken */
    size_t left;       /**< how many are at hand from there */
    uint64_t end;      /**< where the last one at hand ends in the stream */
    lum_source_functions functions;
    uint8_t *memory; /**< that buffer lies in; NULL: the bytes are in memory */
    uint8_t *buffer; /**< 2 * half bytes, from the start of a page */
    size_t half;     /**< left-over bytes end and new bytes begin here */
    char *name;      /**< for messages */
    lum_source *packed; /**< what functions unpack, and close; or NULL */
    lum_go_on *go_on;   /**< asked before each reading; or NULL */
    bool (*wait)(void *context, int ms); /**< for bytes; returns whether to
                                              read. NULL: reading never waits
                                              for long */
    bool has_ended;                      /**< there is nothing more to read */
    bool has_failed;                     /**< and error says why */
    lum_error error;
};

/** Read until this many bytes are in the window, fewer only at the end. The
 * bytes that at pointed to have moved. At most LUM_SOURCE_WINDOW_MAX bytes.
 * @return whether there are this many. */
LUM_MUST_CHECK bool lum_source_fill(lum_source *source, size_t bytes);

/** Take bytes that need not be in the window.
 * @return whether there were this many. */
LUM_MUST_CHECK bool lum_source_skip(lum_source *source, uint64_t bytes);

/** Bytes read and total bytes, of the compressed stream if it is compressed; a
 * total of 0: not known. */
void lum_source_progress(const lum_source *source, uint64_t *done,
                         uint64_t *total);

/** Whether it can be read from another place: it is in memory or has a function
 * for that, and is not unpacked. */
bool lum_source_can_seek(const lum_source *source);

/** Go on from another place, whether or not it has ended or failed.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_source_seek(lum_source *source, uint64_t offset,
                                   lum_error *error);

/** Whether this many bytes are in the window. */
static inline bool lum_source_has(lum_source *source, size_t bytes)
{
    return source->left >= bytes || lum_source_fill(source, bytes);
}

/** Take bytes of the window. They stay in place until more are requested. */
static inline void lum_source_take(lum_source *source, size_t bytes)
{
    source->at += bytes;
    source->left -= bytes;
}

/** Where in the stream the first byte is that was not taken. */
static inline uint64_t lum_source_offset(const lum_source *source)
{
    return source->end - source->left;
}

#endif
