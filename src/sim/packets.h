/** @file
 * Rendered lines to the datagrams that a sensor sends. */
#ifndef LUM_SIM_PACKETS_H
#define LUM_SIM_PACKETS_H

#include "lum/profile.h"
#include "lum/result.h"
#include "render.h"

#include <stddef.h>
#include <stdint.h>

/** Most bytes of a datagram: those that fit in Ethernet's 1500 after IP and
 * UDP. */
#define LUM_PACKET_BYTES_MAX 1472u

/** Most packets of one eye's line: 3 of angles, the rest of ranges. */
#define LUM_PACKETS_LINE_MAX 64u

/** One datagram. */
typedef struct lum_sim_packet {
    int64_t time_ns; /**< when it leaves, on the sensor clock */
    size_t len;      /**< of bytes */
    unsigned sender; /**< for the caller: lum_packets_build() sets it to 0 */
    uint8_t bytes[LUM_PACKET_BYTES_MAX]; /**< UDP payload */
} lum_sim_packet;

/** The datagrams of one eye's line. */
typedef struct lum_packet_batch {
    size_t count;                                 /**< of packets */
    lum_sim_packet packets[LUM_PACKETS_LINE_MAX]; /**< in their order */
} lum_packet_batch;

/** Bits that the numbers of a field need in packets of frames with this many
 * lines; 0: it has none of its own.
 * @param field an ::lum_group_field.
 * @param lines at least 1. */
unsigned lum_packets_bits(unsigned field, uint32_t lines);

/** The first field of a layout that is too narrow for them.
 * @param lines at least 1.
 * @return an ::lum_group_field; LUM_GROUP_FIELDS if none is. */
unsigned lum_packets_narrow(const lum_layout *layout, uint32_t lines);

/** Whether the packets of frames with this many lines fit the fields of a
 * layout.
 * @param lines at least 1.
 * @return LUM_OK; LUM_E_VALUE if a field is too narrow. */
LUM_MUST_CHECK lum_result lum_packets_check(const lum_layout *layout,
                                            uint32_t lines);

/** The clock that a decoder hands out for a line: counted from the first line's
 * clock as the layout's field holds it; 0 where there is no field. */
int64_t lum_packets_clock_us(const lum_layout *layout,
                             const lum_sim_line *line);

/** Make the packets of one eye's line: angles cut 334, 334, 332, then ranges in
 * packets as full as can be without cutting a pixel. All leave at once, when
 * the line begins.
 * @param out caller-owned, overwritten; content undefined on failure.
 * @return LUM_OK; LUM_E_VALUE if a value does not fit the layout's field. */
LUM_MUST_CHECK lum_result lum_packets_build(const lum_layout *layout,
                                            const lum_sim_line *line,
                                            lum_packet_batch *out);

/** Append the angle packets of a line, the first part of lum_packets_build().
 * @return as lum_packets_build(). */
LUM_MUST_CHECK lum_result lum_packets_add_angles(const lum_layout *layout,
                                                 const lum_sim_line *line,
                                                 lum_packet_batch *out);

/** Append the range packets of a line, the second part. */
LUM_MUST_CHECK lum_result lum_packets_add_ranges(const lum_layout *layout,
                                                 const lum_sim_line *line,
                                                 lum_packet_batch *out);

/** Set the clock of a data packet, in the layout's ticks; does nothing if it
 * has no clock.
 * @param clock_us 0 to 2^53. */
void lum_packets_set_clock(const lum_layout *layout, int64_t clock_us,
                           uint8_t *packet);

/** Spread the packets of both eyes over the time of a line: the eyes take
 * turns, at even distances.
 * @param batches one of each ::lum_eye; their time_ns change.
 * @param line_ns how long the line lasts.
 * @param order   gets the packets in the order they leave; room for LUM_EYES x
 *                LUM_PACKETS_LINE_MAX.
 * @return how many there are. */
size_t lum_packets_spread(lum_packet_batch batches[LUM_EYES], double line_ns,
                          lum_sim_packet **order);

#endif
