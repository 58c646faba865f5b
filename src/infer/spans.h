/** @file
 * How long lines last by the sensor's clock. Internal. */
#ifndef LUM_INFER_SPANS_H
#define LUM_INFER_SPANS_H

#include "infer/ticks.h"

#include "lum/assembler.h"

/** A line must last less than this (docs/protocol.md, "Reassembly"). */
#define LUM_INFER_GAP_US ((double)LUM_GAP_US)

/** Measure lines, and set line_span_us. The line, the eye and the clock are
 * known. */
void lum_infer_measure_lines(lum_infer_state *state, lum_infer_ticks *ticks);

#endif
