/** @file
 * Compressed captures, as functions of a source. Internal to the capture room.
 * Each compression has a file of its own, and one for builds without it. */
#ifndef LUM_CAPTURE_UNPACK_H
#define LUM_CAPTURE_UNPACK_H

#include "source_internal.h"

/** Make the functions that unpack a source's bytes, which then need it. What
 * was readable of damaged or cut data is given, then the failure with the byte
 * where it was.
 * @param packed borrowed; stays open.
 * @param out    its close frees all but packed; written only on success.
 * @return 0; -1 without memory. */
typedef int lum_unpacker(lum_source *packed, lum_source_functions *out);

/** Of gzip data, also of several one behind another. NULL: not in this build.
 */
extern lum_unpacker *const lum_unpack_gzip;

/** Of zstd data, also of several frames. NULL: not in this build. */
extern lum_unpacker *const lum_unpack_zstd;

/** What unpacks a source, as its first bytes tell.
 * @return NULL: it is not compressed, or not in a way that this build reads. */
LUM_MUST_CHECK lum_unpacker *lum_unpacker_find(lum_source *source);

/** What to do about a source that is no capture but often taken for one:
 * "; it is ...", or "". */
const char *lum_unpack_hint(lum_source *source);

#endif
