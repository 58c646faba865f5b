/** @file
 * Records of a capture, or of a socket, to the lines of each sensor
 * (docs/protocol.md, section 9).
 *
 * A sensor is an address on the side of port 5517 (or lum_demux_options.port)
 * that sent data. If several interfaces bring different data of one address,
 * each interface has its own sensor. Each sensor has its own assembler. Events
 * are returned as by lum_assembler_push().
 *
 * Only one thread at a time may use a demultiplexer. A sensor's assembler is
 * allocated at its first data: about 550 KB with the default constants. */
#ifndef LUM_CAPTURE_DEMUX_H
#define LUM_CAPTURE_DEMUX_H

#include "lum/assembler.h"
#include "lum/capture/capture.h"
#include "lum/packet.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most sensors in one stream; data of more counts as *other*. */
#define LUM_DEMUX_SENSORS_MAX 16u

/** A sensor that the options name, as wanted or left out. It never grows. */
typedef struct lum_demux_member {
    uint32_t address;         /**< host order */
    const char *interface;    /**< as lum_capture_interface() names it; NULL:
                                   the first sensor of that address that no
                                   other member names */
    const lum_layout *layout; /**< of its data packets; NULL: that of the
                                   options */
    bool is_left_out; /**< not wanted: its packets are recognised by its layout,
                           but not assembled */
} lum_demux_member;

/** Most members. */
#define LUM_DEMUX_MEMBERS_MAX 8u

/** Options of a demultiplexer. */
typedef struct lum_demux_options {
    size_t struct_size;          /**< sizeof(lum_demux_options) */
    lum_layout layout;           /**< of data packets */
    lum_assembler_config config; /**< for each sensor's assembler */
    bool has_sensor; /**< only one sensor is requested: data of others is not
                        assembled, and nothing of theirs is counted */
    uint32_t sensor; /**< its address, host order */
    uint16_t port;   /**< of sensors, if NAT has changed it; 0: ::LUM_PORT */
    const char
        *sensor_interface; /**< its interface, as lum_capture_interface() names
                         it; NULL: the first sensor of that address */
    bool records_are_single; /**< no record holds joined datagrams, so none is
                                  searched for them; true of lum_capture_next()
                                  and of a live sensor */
    const lum_demux_member *members; /**< the wanted sensors, and those left
                                          out; data of all others is neither
                                          assembled nor counted. No two have
                                          both address and interface in common.
                                          Not with has_sensor. NULL: no
                                          members */
    size_t member_count;             /**< at most LUM_DEMUX_MEMBERS_MAX */
} lum_demux_options;

/** What was counted, of one address or of all. */
typedef struct lum_demux_counters {
    size_t struct_size; /**< sizeof(lum_demux_counters), set by the caller */
    uint64_t packets[LUM_PACKET_KINDS]; /**< by ::lum_packet_kind */
    uint64_t angle_packets;             /**< of the data: angles */
    uint64_t range_packets;             /**< of the data: ranges */
    uint64_t cut_short;                 /**< datagrams captured in part */
    uint64_t other;                     /**< everything else, including dropped
                                             fragments */
    lum_assembly_counters assembly;     /**< of all the sensors' assemblers */
    uint64_t joined;       /**< packets that a receiving host had joined with
                                others */
    uint64_t out_of_order; /**< data packets whose records come after later
                                ones, by their times and by the sensor's clock,
                                and so were *late*, *stray* or taken for a jump
                                of the clock; if a few records come too early,
                                as many of those after them */
} lum_demux_counters;

/** A demultiplexer. */
typedef struct lum_demux lum_demux;

/** Make a demultiplexer.
 * @param options copied; the config is valid.
 * @param out     to be freed with lum_demux_free(); NULL on failure.
 * @param error   may be NULL; gets the message on failure: struct_size is not
 *                set, or there is no memory.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_demux_new(const lum_demux_options *options,
                                 lum_demux **out, lum_error *error);

/** Free it. NULL is allowed. */
void lum_demux_free(lum_demux *demux);

/** Set the interface of the records that are pushed next. At first it is
 * unknown.
 * @param name as of lum_capture_interface(), copied; NULL: unknown. Longer
 *             names are cut to 63 bytes. */
void lum_demux_set_interface(lum_demux *demux, const char *name);

/** Take a record. A ::LUM_RECORD_DATAGRAM that holds several joined datagrams
 * (docs/protocol.md, section 9) is split. When an address sends data on a
 * second interface, that data is held until it is clear whether it comes from
 * another sensor: at most 4096 packets or 8 MiB, and 1 s of their times.
 * @param record its time is the arrival that lines are handed out with.
 * @param kind   may be NULL; gets the kind of the datagram if it is of port
 *               5517 and counted, else LUM_PACKET_KINDS; for joined ones, the
 *               kind of the last one taken.
 * @return LUM_OK: consumed. LUM_LINE_READY, LUM_FRAME_READY: an event of
 *         lum_demux_current(); push the same record again. LUM_E_SPACE: no
 *         memory for one more sensor. */
LUM_MUST_CHECK lum_result lum_demux_push(lum_demux *demux,
                                         const lum_record *record,
                                         lum_packet_kind *kind);

/** The end of the stream. Call until it returns LUM_OK.
 * @return LUM_LINE_READY or LUM_FRAME_READY, then LUM_OK; LUM_E_SPACE as for
 *         lum_demux_push(). */
LUM_MUST_CHECK lum_result lum_demux_flush(lum_demux *demux);

/** The assembler whose event was returned last: for lum_assembler_line() and
 * lum_assembler_frame(). */
const lum_assembler *lum_demux_current(const lum_demux *demux);

/** Which sensor that is: an index for lum_demux_address() and
 * lum_demux_count(). */
size_t lum_demux_current_index(const lum_demux *demux);

/** How many sensors sent data so far. If one sensor is requested, the others
 * count too: they are known, but not decoded. */
size_t lum_demux_sensor_count(const lum_demux *demux);

/** The address of the i-th sensor, in order of their first data.
 * @param i below lum_demux_sensor_count().
 * @return the address, in host order. */
uint32_t lum_demux_address(const lum_demux *demux, size_t i);

/** The interface on which the i-th sensor sent its first data.
 * @param i below lum_demux_sensor_count().
 * @return its name, which lives until the next push; NULL: unknown. */
const char *lum_demux_interface(const lum_demux *demux, size_t i);

/** Whether another sensor has the address of the i-th.
 * @param i below lum_demux_sensor_count(). */
bool lum_demux_is_shared(const lum_demux *demux, size_t i);

/** Bytes of a sensor's name, with its NUL: an address, a % and
 * ::LUM_INTERFACE_BYTES. */
#define LUM_SENSOR_NAME_BYTES 80u

/** The name of the i-th sensor: its address; if another sensor with this
 * address came before, also a % and its interface: "10.42.0.37%eth1". It never
 * changes.
 * @param i   below lum_demux_sensor_count().
 * @param out gets it.
 * @return out. */
const char *lum_demux_name(const lum_demux *demux, size_t i,
                           char out[LUM_SENSOR_NAME_BYTES]);

/** Which member the i-th sensor is.
 * @param i below lum_demux_sensor_count().
 * @return its place in lum_demux_options.members; 0 for a requested sensor; -1:
 *         it is no member. */
int lum_demux_member_of(const lum_demux *demux, size_t i);

/** Whether the i-th sensor was requested or is a member that is not left out;
 * true if the options name none.
 * @param i below lum_demux_sensor_count(). */
bool lum_demux_is_requested(const lum_demux *demux, size_t i);

/** Whether the last record is of a requested sensor; true if none was
 * requested. For a record that is held, a best guess. */
bool lum_demux_is_wanted(const lum_demux *demux);

/** Counters of the i-th sensor; other is always 0.
 * @param i   below lum_demux_sensor_count().
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_demux_count(const lum_demux *demux, size_t i,
                           lum_demux_counters *out);

/** Counters of the whole stream, without those of sensors that were not
 * requested.
 * @param out as for lum_demux_count().
 * @return as lum_demux_count(). */
lum_result lum_demux_total(const lum_demux *demux, lum_demux_counters *out);

/** Warnings about a stream, each with its cause and fix: packets of a G2
 * that are on another port, cut by the capture, wrapped in a protocol that is
 * not read, or dropped because records are out of order; and sensors left out
 * because they share the requested one's address. With members: each wanted one
 * that sent no data, with the reason if known, and sensors that are no member.
 * Complete at the end of the stream.
 * @param capture the capture that was read; NULL: records of another source.
 * @param demux   the demultiplexer; NULL: none, and warnings from its counters
 *                are left out.
 * @param port    without demux, the sensors' port that was read; 0:
 *                ::LUM_PORT.
 * @param i       from 0 on.
 * @param out     gets it: one line, without the capture's name.
 * @return false after the last: then out is not set. */
LUM_MUST_CHECK bool lum_capture_remark(const lum_capture *capture,
                                       const lum_demux *demux, uint16_t port,
                                       size_t i, lum_error *out);

#ifdef __cplusplus
}
#endif

#endif
