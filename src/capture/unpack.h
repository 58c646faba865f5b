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

/** Let *source be the unpacked bytes of what it is, if it is compressed in a
 * way that this build reads. Waits for the first bytes.
 * @param source on failure as it was.
 * @return 0; -1 without memory, with the reason in error. */
LUM_MUST_CHECK int lum_unpack(lum_source **source, lum_error *error);

/** What to do about a source that is no capture but often taken for one:
 * "; it is ...", or "". */
const char *lum_unpack_hint(lum_source *source);

#endif
