/** @file
 * What is odd about a capture's records: where packets of a G2 are that are not
 * read, and why. Internal to capture; lum_capture_remark() says it. */
#ifndef LUM_CAPTURE_REMARKS_H
#define LUM_CAPTURE_REMARKS_H

#include "lum/capture/demux.h"
#include "pcap.h"

/** Most places of hidden packets, and most ways from UDP port to UDP port, that
 * are told apart; and the most of these from one port, to others than the
 * first. */
#define LUM_REMARKS_HIDDEN  6u
#define LUM_REMARKS_WAYS    64u
#define LUM_REMARKS_WAYS_OF 4u

/** What was seen. All bytes 0: nothing. */
typedef struct lum_remarks {
    struct {
        uint32_t link_type;
        size_t at; /* lum_link_find_hidden() */
        uint64_t count;
    } hidden[LUM_REMARKS_HIDDEN];
    size_t hidden_count;
    struct {
        uint16_t from;
        uint16_t to;    /* 0: to any further port */
        uint64_t count; /* packets of a G2 that may be data */
    } ways[LUM_REMARKS_WAYS];
    size_t way_count;
    uint32_t held_max; /* bytes of records that were cut; 0: none was */
} lum_remarks;

/** Look at a record.
 * @param from as the file has it.
 * @param out  what was read of it. */
void lum_remarks_take(lum_remarks *remarks, const lum_pcap_record *from,
                      const lum_record *out);

/** As lum_capture_remark().
 * @param remarks NULL: of no capture. */
LUM_MUST_CHECK bool lum_remarks_get(const lum_remarks *remarks,
                                    const lum_demux *demux, uint16_t port,
                                    size_t i, lum_error *out);

#endif
