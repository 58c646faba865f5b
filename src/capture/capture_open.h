/** @file
 * Opening a capture in any way. Internal. */
#ifndef LUM_CAPTURE_CAPTURE_OPEN_H
#define LUM_CAPTURE_CAPTURE_OPEN_H

#include "base/go_on.h"
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

#endif
