/* The captures that are played, as one stream. Files are read as often as is
 * wanted; what can be read once, such as standard input, is handed on by a pump
 * of its own. */
#ifndef LUMVIEW_CAPTURES_H
#define LUMVIEW_CAPTURES_H

#include "../common/provenance.h"
#include "../common/sources.h"
#include "lum/base/error.h"
#include "lum/capture/capture.h"
#include "stage.h"

#include <stdbool.h>
#include <stddef.h>

struct captures;

/* What cannot be opened is told at once, and which of them it is. sources:
 * kept. 0, or -1 with the reason in error. */
int captures_new(const struct sources *sources, struct captures **out,
                 lum_error *error);

/* Reading comes to an end soon, though nothing comes. NULL is allowed. */
void captures_stop(struct captures *captures);

/* Nobody reads any more. NULL is allowed. */
void captures_free(struct captures *captures);

/* Whether they can be read again. */
bool captures_are_files(const struct captures *captures);

/* From their beginning. 0, or -1 with the reason in error, which may be NULL.
 */
int captures_open(const struct captures *captures, lum_capture **out,
                  lum_error *error);

/* As lum_capture_next(). */
int captures_next(const struct captures *captures, lum_capture *capture,
                  lum_record *out, lum_error *error);

/* Where a recording is missing between those that were read so far, as text;
 * "": nowhere. Returns out. */
const char *captures_gaps(const struct captures *captures,
                          const lum_capture *capture, char *out, size_t room);

/* Tell the stage whose calibration or profile is not used, of what was read so
 * far; what has been told stays. said: of the files. */
void captures_tell_others(const struct captures *captures,
                          const lum_capture *capture,
                          const struct provenance_source *said,
                          struct stage *stage);

#endif
