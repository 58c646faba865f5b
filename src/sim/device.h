/** @file
 * What a sensor does (docs/protocol.md, section 10), as a state machine of
 * datagrams and time: no sockets, no clock, no allocation.
 *
 * The caller brings datagrams and the time, and does what the answer says: send
 * a reply, move to a new address, stream. Times are monotonic nanoseconds, the
 * same clock in every call, and do not go back. */
#ifndef LUM_SIM_DEVICE_H
#define LUM_SIM_DEVICE_H

#include "lum/calibration.h"
#include "lum/group.h"
#include "lum/host/yscan.h"
#include "lum/laser.h"
#include "lum/profile.h"
#include "lum/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Longest reply. */
#define LUM_DEVICE_REPLY_BYTES 1472u

/** Time without a heartbeat after which laser and data stop. */
#define LUM_DEVICE_TIMEOUT_NS (LUM_HEARTBEAT_TIMEOUT_MS * INT64_C(1000000))

/** Time after which the returns have full strength. */
#define LUM_DEVICE_WARM_UP_NS INT64_C(3000000000)

/** Lines of a Y-scan table that are kept; a longer table is refused. */
#define LUM_DEVICE_YSCAN_MAX 700u

/** An address and a port, host order. */
typedef struct lum_device_peer {
    uint32_t address; /**< IPv4 */
    uint16_t port;    /**< UDP */
} lum_device_peer;

/** The settings; a new sensor has those of lum_device_init(). */
typedef struct lum_device_settings {
    uint16_t power;               /**< percent */
    uint16_t threshold[LUM_EYES]; /**< percent, by ::lum_eye */
    uint16_t offset[LUM_EYES];    /**< 0..30 */
    uint16_t holdoff;             /**< 150..250 */
    uint16_t lines;               /**< 640 or 64 */
    uint16_t fov_deg;   /**< of a uniform Y scan; 0: the whole span; no effect
                           while there is a table */
    size_t yscan_count; /**< lines of the table; 0: none */
    int16_t yscan[LUM_DEVICE_YSCAN_MAX]; /**< raw elevations */
} lum_device_settings;

/** A sensor. Fields may be read; functions change them. */
typedef struct lum_device {
    lum_layout layout;            /**< numbers of TLVs, order of addresses */
    lum_device_settings settings; /**< as commanded */
    uint16_t status;              /**< laser status bits */
    bool has_client;              /**< a heartbeat has come since boot */
    bool is_streaming;            /**< data goes to client */
    lum_device_peer client;       /**< sender of the last heartbeat */
    int64_t heartbeat_ns;         /**< time of the last heartbeat */
    int64_t boot_ns;              /**< when its clock was 0 */
    int64_t laser_ns;             /**< when the laser last came up */
    uint64_t malformed;           /**< packets and TLVs that could not be */
    uint64_t ignored;             /**< not ours, or not for a sensor */
} lum_device;

/** What came of a datagram or of time. */
typedef struct lum_device_effects {
    bool has_reply;         /**< send reply to the sender of the datagram */
    bool has_address;       /**< move to a new address at once */
    bool settings_changed;  /**< look at settings again */
    bool geometry_changed;  /**< of these: lines, fov or table */
    bool status_changed;    /**< status is not what it was */
    bool laser_changed;     /**< it came up or went down */
    bool streaming_changed; /**< data begins, ends, or goes to another client */
    uint32_t address;       /**< the new one, host order */
    size_t reply_len;       /**< bytes of reply */
    uint8_t reply[LUM_DEVICE_REPLY_BYTES]; /**< the packet */
    char note[256]; /**< what was done, for a log: "u", "50p", "refused 50q",
                         "status poll"; NUL-terminated, printable ASCII */
} lum_device_effects;

/** The usual status at boot: nobody sends heartbeats, and no command came. */
#define LUM_DEVICE_BOOT_STATUS LUM_LASER_HEARTBEAT_TIMEOUT

/** Boot: laser off, clock 0, no client, default settings: power 100, thresholds
 * 50, offsets 0, holdoff 200, given lines, the whole span.
 * @param layout copied.
 * @param lines  640 or 64.
 * @param status bits of the status; without HEARTBEAT_TIMEOUT, 3 s pass before
 *               it is set. TLV_CMD_ON is left out.
 * @param clock_us what the clock shows at now_ns, 0 for a fresh boot. */
void lum_device_init(lum_device *out, const lum_layout *layout, uint16_t lines,
                     uint16_t status, uint32_t clock_us, int64_t now_ns);

/** Take a datagram: any bytes, any length. Time passes first, as in
 * lum_device_tick(), but a change that this causes only shows in the effects:
 * to get its alert, call lum_device_tick() before.
 * @param out overwritten. */
void lum_device_receive(lum_device *device, int64_t now_ns,
                        lum_device_peer from, const void *bytes, size_t len,
                        lum_device_effects *out);

/** Let time pass: the heartbeat's timeout.
 * @param out overwritten; no reply except an alert to the client with a changed
 *            status. */
void lum_device_tick(lum_device *device, int64_t now_ns,
                     lum_device_effects *out);

/** When lum_device_tick() has something to do next; INT64_MAX: never. */
int64_t lum_device_next_ns(const lum_device *device);

/** Set and clear bits of the status, as faults of the hardware would;
 * HEARTBEAT_TIMEOUT, TLV_CMD_ON and TLV_CMD_OFF do not change. A laser that a
 * command has switched on comes up again when the last hazard ends. The effects
 * are those of lum_device_tick(): an alert to the client with the status. */
void lum_device_set_hazards(lum_device *device, uint16_t set, uint16_t clear,
                            int64_t now_ns, lum_device_effects *out);

/** The sensor's clock, 32 bits of microseconds since boot. */
uint32_t lum_device_clock_us(const lum_device *device, int64_t now_ns);

/** The same before it wraps. */
int64_t lum_device_since_boot_us(const lum_device *device, int64_t now_ns);

/** Whether the laser is up: switched on by a command, and no bit of
 * LUM_LASER_ALL_DOWN set. */
bool lum_device_laser_is_up(const lum_device *device);

/** Strength of returns: power, times how far the laser has warmed up, 0..1. */
float lum_device_gain(const lum_device *device, int64_t now_ns);

/** Where the lines of an eye lie: the uniform scan or the table, inside the
 * eye's calibrated span.
 * @param eye      checked.
 * @param out_udeg room for settings->lines; millionths of a degree, as
 *                 lum_render_options.elevations_udeg takes them.
 * @return false, and nothing is written, when the lines cover the whole span.
 */
bool lum_device_elevations(const lum_device_settings *settings,
                           const lum_layout *layout,
                           const lum_eye_calibration *eye, int32_t *out_udeg);

#endif
