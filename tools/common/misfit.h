/* Whether packets of a sensor look as if their layout were another one. */
#ifndef LUM_TOOLS_MISFIT_H
#define LUM_TOOLS_MISFIT_H

#include "sources.h"

#include "lum/capture/demux.h"

#include <stdbool.h>
#include <stddef.h>

/* Says what does not fit, as a part of a sentence. False: too little of it, as
 * corruption may bring it, and out is empty. */
bool misfit_find(const lum_demux_counters *counters, char *out, size_t room);

/* Bytes of a capture's name in a command that are enough for nearly all. */
#define MISFIT_CAPTURE_BYTES 1024u

/* Bytes of an advice beyond the name in it. */
#define MISFIT_ADVICE_BYTES 240u

/* The capture to name in the command that finds the layout, as a word of a
 * shell: one is enough. out may hold it. A source that can be read once, or
 * whose name does not fit, is "CAPTURE". */
const char *misfit_capture(const struct sources *sources, char *out,
                           size_t room);

/* The commands that find the layout, as a sentence. source: a sensor, which has
 * to be recorded first, where there is no capture. capture: a word of a shell.
 */
void misfit_advise(const char *source, const char *capture, char *out,
                   size_t room);

#endif
