/* A walk over the sources of a capture that is read as one stream: what lies
 * between them. */
#ifndef LUM_TOOLS_SOURCE_WALK_H
#define LUM_TOOLS_SOURCE_WALK_H

#include "lum/capture/capture.h"
#include "lum/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Longer than a sensor with a session is silent: it answers every heartbeat. */
#define SOURCE_WALK_GAP_NS (INT64_C(2500000) * LUM_HEARTBEAT_MS)

/* More than packets of several queues of one network card are out of order. */
#define SOURCE_WALK_OVERLAP_NS INT64_C(10000000)

/* Room for what source_walk_text() writes of any usual name. */
#define SOURCE_WALK_TEXT_BYTES 4352u

/* Begun with the capture alone. */
struct source_walk {
    const lum_capture *capture;
    size_t next;
    lum_capture_source source; /* the present one */
    bool has_before;
    int64_t reach_ns; /* latest time of those before it */
    int64_t gap_ns;   /* from there; below 0: an overlap */
};

/* Go on to the next. False: there is no other. One of which no record was read
 * has no gap. */
bool source_walk_step(struct source_walk *walk);

/* Whether something is missing before the present one. */
bool source_walk_is_gap(const struct source_walk *walk);

/* Whether the present one begins before the end of those before it. */
bool source_walk_is_overlap(const struct source_walk *walk);

/* What the gap or the overlap before the present one is, without its seconds:
 * "seconds without a capture before r-2.pcap". Too long a name is cut. Returns
 * out. */
const char *source_walk_text(const struct source_walk *walk, char *out,
                             size_t room);

#endif
