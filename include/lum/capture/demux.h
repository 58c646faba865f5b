/** @file
 * Records of a capture, or of a socket, to the lines of each sensor
 * (docs/protocol.md, section 9).
 *
 * A sensor is the address on the side of port 5517, or of
 * lum_demux_options.port, that sent data, and where several interfaces each
 * bring data of their own under one address, the address on its interface. Each
 * has its own assembler. Events are returned as by lum_assembler_push().
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

/** A sensor that is known by name, and wanted or left out. It never grows. */
typedef struct lum_demux_member {
    uint32_t address;         /**< host order */
    const char *interface;    /**< as lum_capture_interface() names it; NULL:
                                   the first sensor of that address that no
                                   other member names */
    const lum_layout *layout; /**< of its data packets; NULL: that of the
                                   options */
    bool is_left_out; /**< it is not wanted: its packets are recognised by its
                           layout, and not assembled */
} lum_demux_member;

/** Most sensors that can be known by name. */
#define LUM_DEMUX_MEMBERS_MAX 8u

/** Options of a demultiplexer. */
typedef struct lum_demux_options {
    size_t struct_size;          /**< sizeof(lum_demux_options) */
    lum_layout layout;           /**< of data packets */
    lum_assembler_config config; /**< for each sensor's assembler */
    bool has_sensor; /**< only one sensor is requested: data of others is not
                        assembled, and nothing of theirs is counted */
    uint32_t sensor; /**< its address, host order */
    uint16_t port;   /**< of sensors, where something between has changed it
                        (NAT); 0: ::LUM_PORT */
    const char
        *sensor_interface; /**< its interface, as lum_capture_interface() names
                         it; NULL: the first sensor of that address */
    bool records_are_single; /**< no record holds joined datagrams, as those of
                                  lum_capture_next() and of a live sensor: none
                                  is looked through for them */
    const lum_demux_member *members; /**< only these sensors are wanted, but for
                               those that are left out: data of others is not
                               assembled, and nothing of theirs is counted. No
                               two have the same address and interface.
                               has_sensor does not go with them. NULL: none are
                               named */
    size_t member_count;             /**< at most LUM_DEMUX_MEMBERS_MAX */
} lum_demux_options;

/** What was counted, of one address or of all. */
typedef struct lum_demux_counters {
    size_t struct_size; /**< sizeof(lum_demux_counters), set by the caller */
    uint64_t packets[LUM_PACKET_KINDS]; /**< by ::lum_packet_kind */
    uint64_t angle_packets;             /**< of the data: angles */
    uint64_t range_packets;             /**< of the data: ranges */
    uint64_t cut_short;                 /**< datagrams captured in part */
    uint64_t other;                     /**< what is not ours, including
                                             dropped fragments */
    lum_assembly_counters assembly;     /**< of all the sensors' assemblers */
    uint64_t joined; /**< of the packets: those that came joined with others by
                          a receiving host */
    uint64_t out_of_order; /**< packets of data whose records stand behind
                                later ones, by their times and by the sensor's
                                clock alike, and were *late* or *stray* for
                                that, or taken for a jump of the clock; where
                                fewer stand too early than others behind them,
                                as many as those */
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

/** Say from which interface the records come that are pushed next. At first it
 * is not known.
 * @param name as of lum_capture_interface(), copied; NULL: it is not known.
 *             Longer names are cut to 63 bytes. */
void lum_demux_set_interface(lum_demux *demux, const char *name);

/** Take a record. A ::LUM_RECORD_DATAGRAM that holds several joined datagrams
 * (docs/protocol.md, section 9) is taken apart. When an address sends data on a
 * second interface, its data is held until it is clear whether that is another
 * sensor's: at most 4096 packets or 8 MiB, and 1 s of their times.
 * @param record its time is the arrival that lines are handed out with.
 * @param kind   may be NULL; gets the kind of the datagram if it is one of port
 *               5517 and counted, else LUM_PACKET_KINDS; of several joined ones
 *               that of the last one taken.
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
 * @return its name, which lives as long as the demultiplexer is neither pushed
 *         nor freed; NULL: it is not known. */
const char *lum_demux_interface(const lum_demux *demux, size_t i);

/** Whether another sensor has the address of the i-th.
 * @param i below lum_demux_sensor_count(). */
bool lum_demux_is_shared(const lum_demux *demux, size_t i);

/** Bytes of a sensor's name, with its NUL: an address, a % and
 * ::LUM_INTERFACE_BYTES. */
#define LUM_SENSOR_NAME_BYTES 80u

/** The name of the i-th sensor: its address, and behind a % its interface if
 * another sensor with this address came before: "10.42.0.37%eth1". It stays the
 * same.
 * @param i   below lum_demux_sensor_count().
 * @param out gets it.
 * @return out. */
const char *lum_demux_name(const lum_demux *demux, size_t i,
                           char out[LUM_SENSOR_NAME_BYTES]);

/** Which member the i-th sensor is.
 * @param i below lum_demux_sensor_count().
 * @return its place in lum_demux_options.members; 0 of a sensor that was
 *         requested; -1: it is none. */
int lum_demux_member_of(const lum_demux *demux, size_t i);

/** Whether the i-th sensor is the one that was requested or a member that is
 * not left out, or none was named.
 * @param i below lum_demux_sensor_count(). */
bool lum_demux_is_requested(const lum_demux *demux, size_t i);

/** Whether the last record is of the sensor that was requested, or none was. Of
 * one that is held, it is the best guess. */
bool lum_demux_is_wanted(const lum_demux *demux);

/** Counters of the i-th sensor; other is always 0.
 * @param i   below lum_demux_sensor_count().
 * @param out struct_size is set by the caller; as much of the rest is
 *            overwritten as that holds.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_demux_count(const lum_demux *demux, size_t i,
                           lum_demux_counters *out);

/** Counters of the whole stream, without those of sensors that were not
 * requested.
 * @param out as for lum_demux_count().
 * @return as lum_demux_count(). */
lum_result lum_demux_total(const lum_demux *demux, lum_demux_counters *out);

/** What is odd about a stream, each with its cause and what to do: packets of a
 * G2 that are on another port, in the capture only in part, wrapped in what is
 * not read, or dropped since records stand out of order; and sensors that were
 * left out, as the requested one has their address. Of members: each wanted one
 * that sent no data, and why if that is known, and the sensors that are none.
 * Complete at the end of the stream.
 * @param capture that was read; NULL: the records were others.
 * @param demux   that took them; NULL: none did, and what it counts is left
 *                out.
 * @param port    without demux, the sensors' port that was read; 0:
 *                ::LUM_PORT.
 * @param i       from 0 on.
 * @param out     gets it: one line, without the capture's name.
 * @return false behind the last: then out is not set. */
LUM_MUST_CHECK bool lum_capture_remark(const lum_capture *capture,
                                       const lum_demux *demux, uint16_t port,
                                       size_t i, lum_error *out);

#ifdef __cplusplus
}
#endif

#endif
