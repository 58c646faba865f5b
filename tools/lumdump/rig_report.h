/* Which sensors a capture and a rig have in common, and what is said of the
 * others. */
#ifndef LUMDUMP_RIG_REPORT_H
#define LUMDUMP_RIG_REPORT_H

#include "rig_run.h"
#include "summary.h"

#include <stdio.h>

/* Room for any of these texts. */
#define RIG_TEXT_BYTES 1600u

/* The name of the framer's i-th sensor in the rig, of those that are not read
 * too; NULL: the rig does not name it. */
const char *rig_name_of(const struct rig *rig, const lum_framer *framer,
                        size_t i);

/* Whether the k-th sensor that is read sent data. */
bool rig_has_data(const struct rig *rig, const lum_framer *framer, size_t k);

/* Whether any did. */
bool rig_has_any_data(const struct rig *rig, const lum_framer *framer);

/* A sentence on those that are read and sent none, with those that the capture
 * has. False: there are none. */
bool rig_tell_missing(const struct rig *rig, const lum_framer *framer,
                      char out[RIG_TEXT_BYTES]);

/* A line of a rig's file for the framer's i-th sensor. Returns out. */
const char *rig_line_for(const lum_framer *framer, size_t i,
                         char out[RIG_TEXT_BYTES]);

/* Note a record that is of no sensor of the rig, if it is one of a sensor: of
 * their port. interface: NULL: not known. */
void rig_others_note(struct rig_others *others, const struct options *options,
                     const lum_demux *demux, const lum_record *record,
                     const char *interface);

/* How many came of the framer's i-th sensor. */
uint64_t rig_others_packets(const struct rig_others *others,
                            const lum_framer *framer, size_t i);

#endif
