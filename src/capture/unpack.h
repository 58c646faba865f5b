/** @file
 * Compressed captures, as functions of a source. Internal to the capture room.
 * Each compression has a file of its own; unpack_none.c is for those that a
 * build lacks. */
#ifndef LUM_CAPTURE_UNPACK_H
#define LUM_CAPTURE_UNPACK_H

#include "source_internal.h"

/** Bytes to be unpacked, and room for what they unpack to. */
typedef struct lum_unpack_step {
    const uint8_t *in;
    size_t in_len; /**< 0: there are no more */
    uint8_t *out;
    size_t room;
    size_t taken;    /**< of in; 0 before */
    size_t given;    /**< of out; 0 before */
    bool is_between; /**< nothing of a frame is under way now */
    const char *why; /**< of a failure: what is wrong with "the data" */
} lum_unpack_step;

/** A library that unpacks from memory to memory. */
typedef struct lum_unpacker {
    const char *name;
    void *(*make)(void); /**< its state; NULL without memory */
    bool (*step)(void *state,
                 lum_unpack_step *step); /**< false: it cannot go on */
    void (*free)(void *state);
} lum_unpacker;

/** Of gzip, zstd, lz4 and bzip2 data, also of several members or frames. NULL:
 * not in this build. */
extern const lum_unpacker *const lum_unpack_gzip;
extern const lum_unpacker *const lum_unpack_zstd;
extern const lum_unpacker *const lum_unpack_lz4;
extern const lum_unpacker *const lum_unpack_bz2;

/** Make functions that unpack a source's bytes; they need the source as long as
 * they are used. They give the readable part of damaged or cut data, then the
 * failure with its byte.
 * @param packed borrowed; stays open.
 * @param out    its close frees all but packed; written only on success.
 * @return 0; -1 without memory. */
LUM_MUST_CHECK int lum_unpack_by(const lum_unpacker *unpacker,
                                 lum_source *packed, lum_source_functions *out);

/** What unpacks a compression, by its name: gzip, zstd, lz4 or bz2.
 * @param library gets that which it needs; NULL: the name is not known.
 * @return NULL: not known, or not in this build. */
const lum_unpacker *lum_unpack_named(const char *name, const char **library);

/** Replace *source by its unpacked bytes, if it is compressed in a way that
 * this build reads. Waits for the first bytes.
 * @param source on failure as it was.
 * @return 0; -1 without memory, with the reason in error. */
LUM_MUST_CHECK int lum_unpack(lum_source **source, lum_error *error);

/** Bytes that every text of lum_unpack_hint() fits, the NUL included. */
#define LUM_UNPACK_HINT_BYTES 96u

/** Advice for a source of which nothing was taken, that is not a capture but is
 * often taken for one: "; it is ...", or "".
 * @return out. */
const char *lum_unpack_hint(lum_source *source,
                            char out[LUM_UNPACK_HINT_BYTES]);

#endif
