/** @file
 * Our reader of captures against libpcap's.
 *
 * As long as libpcap reads on, ours gives the same records: time, lengths,
 * bytes, link type; and where libpcap comes to the end, so does ours. What
 * libpcap refuses, ours may read. Meant to differ, where libpcap reads on:
 *
 * - A record of a pcap file that is all zeros ends the reading: it is what a
 *   file holds that was not written to its end.
 * - A record above the file's snap length is as long as it says itself; libpcap
 *   cuts it.
 * - A file's first section header is checked as every block is: its length is a
 *   multiple of 4 and stands at its end again. A second one before the first
 *   interface is a section, too.
 * - Packets of D-Bus, USBPcap and EBHSCR above 262,144 bytes are refused; for
 *   these three links libpcap's limit is another.
 * - Times are held at +-4.5 * 10^9 s. Whole seconds are unsigned, and sums of
 *   them and an offset that have more than 64 bits are not cut to them.
 * - Fractions of a second in units of 2^-35 s and smaller are converted without
 *   an overflow.
 * - Headers of USB, NFLOG, PFLOG and cooked CAN within packets are left in the
 *   byte order of the file, and USB's lengths as they are.
 * - More than 65,536 interfaces in a section are refused. */
#ifndef JUDGE_H
#define JUDGE_H

#include "lum/base/error.h"

#include <stddef.h>
#include <stdint.h>

/** What a comparison came to. */
typedef struct judge_result {
    uint64_t records; /**< that both gave */
    int opened;       /**< whether libpcap took it for a capture */
    int ended;        /**< whether libpcap came to its end */
} judge_result;

/** Compare.
 * @return 0, or -1 with the difference in error. */
int judge_compare(const uint8_t *bytes, size_t len, judge_result *out,
                  lum_error *error);

#endif
