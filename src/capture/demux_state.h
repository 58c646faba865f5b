/** @file
 * The state of a demultiplexer's sensors, to go on from a place in the middle
 * of a capture. Internal. */
#ifndef LUM_CAPTURE_DEMUX_STATE_H
#define LUM_CAPTURE_DEMUX_STATE_H

#include "base/pack.h"
#include "lum/capture/demux.h"

/** What decides which lines there are: only to be compared. */
void lum_demux_pack_options(const lum_demux *demux, lum_pack *pack);

/** The interface that a sensor is named with; empty: none, as it came before
 * others with its address. */
const char *lum_demux_further(const lum_demux *demux, size_t sensor);

/** Forget all sensors and counters, as after lum_demux_new(). */
void lum_demux_restart(lum_demux *demux);

/** An address on an interface, and whose data it brings. */
typedef struct lum_demux_origin {
    uint32_t address;
    char interface[LUM_INTERFACE_BYTES]; /**< empty: it is not known */
    uint32_t sensor; /**< its index; LUM_DEMUX_SENSORS_MAX: a sensor too many */
    uint64_t since;  /**< the number of a record: records from it on, but none
                          before, showed whose it is */
} lum_demux_origin;

/** Know one before its first data: a new sensor's if its index is the next. */
void lum_demux_admit(lum_demux *demux, const lum_demux_origin *origin);

/** Most that can be known. */
#define LUM_DEMUX_ORIGINS_MAX 64u

/** How many are known. It only rises. */
size_t lum_demux_origin_count(const lum_demux *demux);

/** One of them, in the order in which they became known.
 * @param i below lum_demux_origin_count(). */
lum_demux_origin lum_demux_origin_at(const lum_demux *demux, size_t i);

/** Number the records that are pushed next. */
void lum_demux_set_record(lum_demux *demux, uint64_t number);

/** Records were passed over: what was sent of late is not known. */
void lum_demux_interrupt(lum_demux *demux);

/** Whether an origin is to be found out from records some of which were passed
 * over: its data is dropped. */
bool lum_demux_is_unsure(const lum_demux *demux);

/** Whether packets are held until it is known whose they are, or such were
 * given with the last record: then its assemblers are not where the capture is.
 */
bool lum_demux_is_behind(const lum_demux *demux);

/** Packets of sensors as one of which the data of two seems to come. */
typedef struct lum_demux_mixture {
    uint32_t compared;      /**< with those next to them in time, of all */
    uint32_t contradicting; /**< of these; 0: no sensor seems to be two */
} lum_demux_mixture;

/** Those of the sensors that were asked for. */
lum_demux_mixture lum_demux_mixed(const lum_demux *demux);

/** Pass over the data of a sensor, which may not be known yet, or no longer. */
void lum_demux_hold(lum_demux *demux, size_t sensor, bool is_held);

/** The sensor that the last record was of.
 * @return false: of none, or of one whose data is not assembled. */
bool lum_demux_sender(const lum_demux *demux, size_t *sensor);

/** The sensor whose data came last.
 * @return false: there is none. */
bool lum_demux_last(const lum_demux *demux, size_t *sensor);

/** The highest frame that a packet of a sensor has begun.
 * @return false: none. */
bool lum_demux_newest(const lum_demux *demux, size_t sensor, uint32_t *frame);

/** The state of a sensor's assembler, but for its counters, in either
 * direction. No event is under way.
 * @param from the first frame whose lines matter: of those before, only what
 *             decides which packets are accepted is kept, without the values of
 *             angles and words.
 * @return false, and what was read is of no use, if something failed. */
bool lum_demux_pack_sensor(lum_demux *demux, size_t sensor, uint32_t from,
                           lum_pack *pack);

/** The same of an assembler with all its storage, begun and empty where it is
 * read. */
bool lum_assembler_pack(lum_assembler *a, uint32_t from, lum_pack *pack);

/** A packet that an assembler has taken or dropped. */
typedef struct lum_demux_taken {
    lum_result result; /**< of lum_assembler_push(); LUM_OK: it was accepted */
    size_t sensor;     /**< its index */
    const lum_assembler *assembler; /**< its sensor's */
    const lum_layout *layout;       /**< that it was decoded with */
    const lum_group *group;         /**< with its samples */
    size_t len;                     /**< of the whole datagram */
    int64_t time_ns;                /**< when it came */
} lum_demux_taken;

typedef void (*lum_demux_watcher)(void *context, const lum_demux_taken *packet);

/** Be told of each packet once its assembler has taken or dropped it. Where
 * nobody asked it costs a branch a packet.
 * @param watcher may be NULL: nobody is told. */
void lum_demux_watch(lum_demux *demux, lum_demux_watcher watcher,
                     void *context);

/** Whether the frame of the line that an assembler has just handed out was
 * decided: two packets of it were accepted. */
bool lum_assembler_line_is_decided(const lum_assembler *a);

#endif
