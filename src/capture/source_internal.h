/** @file
 * A source's bytes through a window: what is at hand is looked at in place, and
 * moves only when more is asked for. Internal to the capture room. */
#ifndef LUM_CAPTURE_SOURCE_INTERNAL_H
#define LUM_CAPTURE_SOURCE_INTERNAL_H

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
    size_t half;     /**< what is left over ends here, what is read begins */
    char *name;      /**< for messages */
    lum_source *packed; /**< what functions unpack, and close; or NULL */
    bool has_ended;     /**< there is nothing more to read */
    bool has_failed;    /**< and error says why */
    lum_error error;
};

/** Read until so many bytes are at hand, fewer only at the end. What at pointed
 * to has moved. At most LUM_SOURCE_WINDOW_MAX bytes.
 * @return whether there are so many. */
LUM_MUST_CHECK bool lum_source_fill(lum_source *source, size_t bytes);

/** Take bytes that need not be at hand.
 * @return whether there were so many. */
LUM_MUST_CHECK bool lum_source_skip(lum_source *source, uint64_t bytes);

/** Bytes read, and in all, of what the stream was unpacked from if it was; a
 * total of 0: not known. */
void lum_source_progress(const lum_source *source, uint64_t *done,
                         uint64_t *total);

/** Whether so many bytes are at hand. */
static inline bool lum_source_has(lum_source *source, size_t bytes)
{
    return source->left >= bytes || lum_source_fill(source, bytes);
}

/** Take bytes that are at hand. They stay where they are until others are asked
 * for. */
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
