/** @file
 * One address on several interfaces of a capture: data is held until it is
 * known whether it is of one sensor or of several (docs/protocol.md, section
 * 9). Internal to the demultiplexer. */
#ifndef LUM_CAPTURE_DEMUX_INTERFACES_H
#define LUM_CAPTURE_DEMUX_INTERFACES_H

#include "demux_sensors.h"

/** Whether its address has a sensor on another interface, and nothing says yet
 * whose data it brings. */
bool lum_demux_is_doubtful(const lum_demux *demux,
                           const lum_demux_entry *entry);

/** End the trials that have come to something; is_over: all. */
void lum_demux_judge_trials(lum_demux *demux, int64_t now_ns, bool is_over);

/** Hold a packet until it is known whose it is.
 * @return false without memory. */
bool lum_demux_enqueue(lum_demux *demux, const lum_record *record,
                       lum_demux_entry *entry);

/** Where a sensor's interface has no name, only the first
 * LUM_DEMUX_LOOK_PACKETS of each LUM_DEMUX_LOOK_EVERY packets are remembered,
 * to be compared with each other: there is no other interface's data to be
 * compared with. */
#define LUM_DEMUX_LOOK_PACKETS 5120u
#define LUM_DEMUX_LOOK_EVERY   65536u

/** The turn-th packet of LUM_DEMUX_LOOK_EVERY is remembered. */
void lum_demux_look_at_sent(const lum_demux *demux, lum_demux_entry *sensor,
                            const lum_record *record, uint32_t turn);

/** Remember a packet of a sensor. */
static inline void lum_demux_note_sent(const lum_demux *demux,
                                       lum_demux_entry *sensor,
                                       const lum_record *record)
{
    const uint32_t turn = sensor->sent++ % LUM_DEMUX_LOOK_EVERY;
    if (turn < LUM_DEMUX_LOOK_PACKETS || *sensor->interface != '\0') {
        lum_demux_look_at_sent(demux, sensor, record, turn);
    }
}

/** Those on trial under a sensor's address meet its packet.
 * @return whether it has to wait: others of its address do. */
bool lum_demux_meet_trials(lum_demux *demux, const lum_record *record,
                           const lum_demux_entry *sensor);

/** Data that is on trial.
 * @return LUM_OK, or LUM_E_SPACE without memory. */
lum_result lum_demux_try(lum_demux *demux, const lum_record *record,
                         lum_demux_entry *entry);

/** The next packet that was held becomes the one at hand.
 * @return LUM_OK, or LUM_E_SPACE without memory: then it stays held. */
lum_result lum_demux_give_held(lum_demux *demux);

#endif
