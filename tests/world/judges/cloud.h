/* Lines and points of the datagrams that a program read, after
 * docs/protocol.md, sections 6 and 7, alone: nothing is shared with the tools.
 */
#ifndef WORLD_CLOUD_H
#define WORLD_CLOUD_H

#include "record.h"

struct cloud {
    uint64_t data, angle_packets, range_packets;
    uint64_t frames, lines, words, points, no_angle, no_range;
    uint64_t lost_words, missing_angles, skipped, bad_words;
    uint64_t late, duplicate, conflict, stray, malformed;
    double range_m; /* of all points */
};

/* Of the first datagrams that a tool kept (record_keep). False: some are not
 * kept, or lines are longer than what this takes. */
bool cloud_of(const record_tool *tool, uint64_t datagrams, struct cloud *out);

#endif
