/** @file
 * Compressed captures, as functions of a source. Internal to the capture room.
 * Each compression has a file of its own, and one for builds without it. */
#ifndef LUM_CAPTURE_UNPACK_H
#define LUM_CAPTURE_UNPACK_H

#include "source_internal.h"

/** Make functions that unpack a source's bytes; they need the source as long as
 * they are used. They give the readable part of damaged or cut data, then the
 * failure with its byte.
 * @param packed borrowed; stays open.
 * @param out    its close frees all but packed; written only on success.
 * @return 0; -1 without memory. */
typedef int lum_unpacker(lum_source *packed, lum_source_functions *out);

/** Of gzip data, also with several members. NULL: not in this build. */
extern lum_unpacker *const lum_unpack_gzip;

/** Of zstd data, also of several frames. NULL: not in this build. */
extern lum_unpacker *const lum_unpack_zstd;

/** Replace *source by its unpacked bytes, if it is compressed in a way that
 * this build reads. Waits for the first bytes.
 * @param source on failure as it was.
 * @return 0; -1 without memory, with the reason in error. */
LUM_MUST_CHECK int lum_unpack(lum_source **source, lum_error *error);

/** Advice for a source that is not a capture but is often taken for one: "; it
 * is ...", or "". */
const char *lum_unpack_hint(lum_source *source);

#endif
