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

/* The capture to name in the command that finds the layout: one is enough. A
 * source that can be read once is "CAPTURE". */
const char *misfit_capture(const struct sources *sources);

/* The commands that find the layout, as a sentence. source: a sensor, which has
 * to be recorded first, where there is no capture. */
void misfit_advise(const char *source, const char *capture, char *out,
                   size_t room);

#endif
