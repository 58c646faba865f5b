/** @file
 * What other rooms of the SDK and its tools know of captures beside
 * lum/capture/capture.h: opening one in any way, its place, its file. Internal.
 */
#ifndef LUM_CAPTURE_CAPTURE_INTERNAL_H
#define LUM_CAPTURE_CAPTURE_INTERNAL_H

#include "base/go_on.h"
#include "base/pack.h"
#include "lum/capture/capture.h"

/** Where a capture comes from: a source, or paths. */
typedef struct lum_capture_from {
    lum_source *source;       /**< taken over, also on failure; or NULL */
    const char *const *paths; /**< as for lum_capture_open_several() */
    size_t count;             /**< of the paths */
    lum_go_on *go_on; /**< kept: asked while it opens, reads or waits; once it
                           says no, reading fails. NULL: nobody is asked */
} lum_capture_from;

/** As lum_capture_open_source() or lum_capture_open_several(). */
LUM_MUST_CHECK int lum_capture_open_from(const lum_capture_from *from,
                                         lum_capture **out, lum_error *error);

/* --- The place in a capture, to go on from it later --- */

/** Whether lum_capture_pack() is possible: it is one source, not compressed,
 * that can be read from any place. */
bool lum_capture_can_seek(const lum_capture *capture);

/** The place of the next record, with all that is needed to read it, in either
 * direction. Bytes that are read must be of this capture.
 * @return 0; -1 with the reason in error, which is empty if the bytes mean
 *         nothing: then only another place can be read. */
LUM_MUST_CHECK int lum_capture_pack(lum_capture *capture, lum_pack *pack,
                                    lum_error *error);

/* --- A capture that is written: capture_writer.c --- */

/** A descriptor of its file, for lum_outfile_sync_copy(); -1: it is none. */
int lum_capture_writer_copy(const lum_capture_writer *writer);

/** Its name, for messages. */
const char *lum_capture_writer_name(const lum_capture_writer *writer);

#endif
