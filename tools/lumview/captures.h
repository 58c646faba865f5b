/* The captures that are played, as one stream. Files can be read any number of
 * times; others, for example standard input, once. */
#ifndef LUMVIEW_CAPTURES_H
#define LUMVIEW_CAPTURES_H

#include "../common/provenance.h"
#include "../common/sources.h"
#include "base/go_on.h"
#include "lum/base/error.h"
#include "lum/capture/capture.h"
#include "stage.h"

#include <stdbool.h>

struct captures;

/* If a source cannot be opened, this is reported at once, with its name.
 * sources: kept. rig: the file of one that is used in place of what they say of
 * themselves; or NULL. 0, or -1 with the reason in error. */
int captures_new(const struct sources *sources, const char *rig, bool is_quiet,
                 struct captures **out, lum_error *error);

/* To be called when no thread reads any more. NULL is allowed. */
void captures_free(struct captures *captures);

/* Whether all of them can be read again. */
bool captures_are_files(const struct captures *captures);

/* Begins to read from their beginning. go_on: kept; asked while it waits, NULL:
 * nobody is. 0, or -1 with the reason in error, which may be NULL. */
int captures_open(const struct captures *captures, lum_go_on *go_on,
                  lum_capture **out, lum_error *error);

/* Tell the stage whose calibration or profile is not used, of what was read so
 * far; what has been told stays. said: of the files. */
void captures_tell_others(const struct captures *captures,
                          const lum_capture *capture,
                          const struct provenance_source *said,
                          struct stage *stage);

/* That, where a recording is missing between those that were read so far or
 * where they overlap, and what is odd about the records or could not be read of
 * them. demux: what took them. */
void captures_tell(const struct captures *captures, const lum_capture *capture,
                   const lum_demux *demux, const struct provenance_source *said,
                   struct stage *stage);

/* The latter two on standard error, once all is read, unless they are quiet. */
void captures_warn(const struct captures *captures, const lum_capture *capture,
                   const lum_demux *demux);

#endif
