/* A line to packets. */
#ifndef LUM_FRAME_PACKET_CUT_H
#define LUM_FRAME_PACKET_CUT_H

#include "lum/frame/packet_writer.h"

#include <stdbool.h>

/* One packet of a line, which is still to be encoded. */
typedef struct lum_cut_packet {
    lum_raw_packet head; /* order: 0 where it is not known */
    uint32_t first;      /* its first word: in the line, or in lum_cut.samples;
                            angles: the pixel */
} lum_cut_packet;

/* The packets of a line, in the order in which they are sent. */
typedef struct lum_cut {
    lum_cut_packet *packets;
    size_t count;
    size_t room;
    bool is_anew;      /* its own packets are not known, or do not fit */
    bool is_placed;    /* words stand in samples, each at its place */
    uint32_t *samples; /* LUM_RAW_PLACES_MAX; NULL: none were needed yet */
} lum_cut;

void lum_cut_free(lum_cut *cut);

/* Cut a line. layout: of the packets. -1 with the reason in error. */
LUM_MUST_CHECK int lum_cut_line(lum_cut *cut, const lum_layout *layout,
                                const lum_raw_line *line, lum_error *error);

/* Encode a packet of it.
 * out: the bytes that lum_cut_bytes() tells. */
LUM_MUST_CHECK int lum_cut_encode(const lum_cut *cut, const lum_layout *layout,
                                  const lum_raw_line *line,
                                  const lum_cut_packet *packet, uint8_t *out,
                                  lum_error *error);

/* A datagram holds at most so many. */
#define LUM_CUT_BYTES_MAX 65507u

size_t lum_cut_bytes(const lum_layout *layout, const lum_cut_packet *packet);

/* --- Clocks: packet_clock.c. from: the layout that a line came with; NULL:
 * that of the file. --- */

/* Whether ticks of its packets are what the file's packets need. */
bool lum_cut_keeps_clock(const lum_layout *to, const lum_layout *from);

/* The lowest tick that is this many microseconds. Where a tick is longer than
 * one, the last before it. */
uint64_t lum_cut_ticks(const lum_layout *layout, int64_t clock_us);

/* The ticks nearest to others that a clock as sent can stand for; 0: there is
 * no clock. */
uint64_t lum_cut_extend(const lum_layout *layout, uint64_t near_ticks,
                        uint64_t clock_raw);

/* Move packets that are as they were by as much as the line's clock and arrival
 * differ from those of the first. to: the file's layout. */
void lum_cut_move(lum_cut *cut, const lum_layout *to, const lum_raw_line *line);

/* Whether a reader can tell its clock. before_us: of the line before; NULL:
 * there is none. */
LUM_MUST_CHECK int lum_cut_check_clock(const lum_layout *layout,
                                       const lum_raw_line *line,
                                       const int64_t *before_us,
                                       lum_error *error);

/* Whether a capture can hold when its packets came. */
LUM_MUST_CHECK int lum_cut_check_time(const lum_cut *cut,
                                      const lum_raw_line *line,
                                      lum_error *error);

/* The name of an eye, for messages. */
static inline const char *lum_cut_eye(uint8_t eye)
{
    return eye == LUM_EYE_BLUE ? "blue" : "green";
}

#endif
