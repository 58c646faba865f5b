/* A gateway beside a sensor, for a controller without an operating system:
 * datagrams in, heartbeats out, and whether the machine has to stop. Needs only
 * the core; no heap, no floating point, and of a C library only mem*.
 *
 *   interrupt of the network   ring_claim(), ring_commit()
 *   interrupt of a timer       gateway_tick(), then sets the relay
 *   main loop                  gateway_receive(), then opens the relay if there
 *                              is a reason, and kicks the watchdog if
 *                              gateway_may_kick()
 *
 * Each side watches the other: the timer stops the machine and the heartbeats
 * when the main loop hangs, and the watchdog resets when the timer is dead.
 * They share words that only one side writes, and so does the ring; no lock is
 * needed. The gateway never switches the laser on. It is an example, not a
 * safety function. */
#ifndef GATEWAY_H
#define GATEWAY_H

#include "age.h"
#include "heart.h"
#include "look.h"
#include "ring.h"
#include "zone.h"

#include "lum/assembler.h"
#include "lum/calibration.h"
#include "lum/packet.h"
#include "lum/points_fixed.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef GATEWAY_OPEN_LINES
#define GATEWAY_OPEN_LINES 2u /* of each eye */
#endif
#ifndef GATEWAY_REORDER_LINES
#define GATEWAY_REORDER_LINES 8u /* how far packets pass each other */
#endif
#ifndef GATEWAY_LINE_WORDS
#define GATEWAY_LINE_WORDS 4000u /* pixels x returns x edges */
#endif
#define GATEWAY_BLOCK   16u /* points that are projected at a time */
#define GATEWAY_FRAMES  4u  /* frames whose lines may be under way at once */
#define GATEWAY_REASONS 4u  /* bits of ::gateway_reason */

#if GATEWAY_OPEN_LINES < 1 || GATEWAY_OPEN_LINES > 16
#error "GATEWAY_OPEN_LINES has to be 1 to 16"
#endif
#if GATEWAY_REORDER_LINES < 1 || GATEWAY_REORDER_LINES > 32
#error "GATEWAY_REORDER_LINES has to be 1 to 32"
#endif
#if GATEWAY_LINE_WORDS < 1 || GATEWAY_LINE_WORDS > 32768
#error "GATEWAY_LINE_WORDS has to be 1 to 32768"
#endif

/* Why the machine has to stop: bits. */
enum gateway_reason {
    GATEWAY_OBJECT = 1, /* something is in the zone */
    GATEWAY_SILENT = 2, /* an eye has shown no point for silence_ms, or not the
                           whole of a frame within hold_ms: blind; or the
                           gateway was not begun */
    GATEWAY_LASER = 4,  /* a status said that the laser is down: blind */
    GATEWAY_STALLED = 8 /* the main loop hung, or has made no round yet; or
                           now_ms is behind the sensor's clock */
};

/* The machine may move only while each eye has shown a point within silence_ms
 * and all lines of a frame within hold_ms, and no object came within hold_ms;
 * all by the time of measuring. This is true for any configuration: one that
 * does not fit the sensor keeps the machine stopped. */
typedef struct gateway_config {
    zone zone;
    uint32_t hits;     /* returns in the zone, of one frame, that are an object
                          and not rain; 1 or more */
    uint32_t lines;    /* of a frame and eye, that have to come whole: the
                          sensor's number, minus those that may be lost; 1 or
                          more */
    uint32_t frame_ms; /* a frame takes at most; 1 or more */
    uint32_t hold_ms;  /* how long a reason lasts after its cause, and a look is
                          valid: more than two frames and the open lines. An
                          early line of a frame and a late line of the next are
                          nearly two frames apart. */
    uint32_t silence_ms; /* older packets are ignored. Longer than frame_ms, and
                            than any round of the main loop; up to AGE_MAX_MS */
    uint8_t eyes;        /* which have to be heard: bit of each ::lum_eye */
} gateway_config;

/* Functions that the gateway calls. context is passed to each. */
typedef struct gateway_output {
    void *context;
    heart_send *send; /* from gateway_tick() */

    /* From gateway_receive(); each may be NULL. A line before its points. */
    void (*line)(void *context, const lum_line *line);
    void (*points)(void *context, const lum_fixed_point *points, size_t n);
    void (*frame)(void *context, int64_t frame, const zone_sight *sight);
} gateway_output;

/* What one frame showed in the zone. Private. */
typedef struct gateway_frame {
    zone_sight sight;
    uint32_t number;
} gateway_frame;

/* Place it statically. It is aligned like the ring. kinds, old_packets,
 * old_lines and the assembler's counters are for diagnosis; the rest is
 * private, except the ring, which the driver uses. */
typedef struct gateway {
    ring ring;
    heart heart;
    uint32_t begun; /* shared, as the next two: written by the main loop */
    uint32_t reasons;
    uint32_t stalls_seen;
    uint32_t kinds[LUM_PACKET_KINDS];
    uint32_t old_packets; /* left out, as older than silence_ms */
    uint32_t old_lines;   /* likewise, of fresh packets */
    uint32_t dropped_seen;
    bool object; /* since the last decision */
    bool laser_down;
    bool laser_was_down; /* since the last decision, as the next */
    bool has_lagged;     /* now_ms, behind the sensor's clock */
    int64_t now_ms;
    int64_t since_ms[GATEWAY_REASONS];
    age age;
    look looks[LUM_EYES];
    gateway_config config;
    gateway_output output;
    lum_layout layout;
    lum_fixed_projector projector;
    lum_point_losses losses;
    gateway_frame frames[GATEWAY_FRAMES];
    lum_fixed_point block[GATEWAY_BLOCK];
    lum_assembler assembler;
    lum_line_slot slots[LUM_ASSEMBLER_SLOTS(GATEWAY_OPEN_LINES)];
    uint32_t words[LUM_ASSEMBLER_WORDS(GATEWAY_OPEN_LINES, GATEWAY_LINE_WORDS)];
    lum_reach reach[LUM_ASSEMBLER_REACH(GATEWAY_REORDER_LINES)];
} gateway;

/* Begin, stopped: GATEWAY_SILENT until every eye has sent, and stalled until
 * the first round. No interrupt may use it during this call. config, output,
 * layout: copied. calibration: used only here. now_ms, here and below: of one
 * clock, which may wrap but never goes back. Returns LUM_OK; LUM_E_VALUE if a
 * value of the configuration, of the zone or of the calibration is out of
 * range, or the layout's data packets have no clock of 32 bits in us. Then it
 * stays stopped, sends nothing, takes nothing, and gateway_may_kick() is false.
 */
LUM_MUST_CHECK lum_result gateway_init(gateway *g, const gateway_config *config,
                                       const gateway_output *output,
                                       const lum_calibration *calibration,
                                       const lum_layout *layout,
                                       uint32_t now_ms);

/* From the main loop, in every round: takes the datagrams of the ring, and
 * decides. Returns the number of datagrams taken, RING_SLOTS at most. */
unsigned gateway_receive(gateway *g, uint32_t now_ms);

/* What gateway_receive() does with each datagram; for a driver without a ring,
 * which calls gateway_receive() after it. Any bytes, any length. */
void gateway_datagram(gateway *g, const uint8_t *bytes, size_t len,
                      uint32_t now_ms);

/* Only from a timer's interrupt, every 100 ms or more often: heartbeats,
 * requests for the sensor's clock, polls of the laser's status, and the check
 * whether the main loop hangs for longer than its looks are valid. Set the
 * relay after it. */
void gateway_tick(gateway *g, uint32_t now_ms);

/* From the main loop, after gateway_receive(): whether to kick the watchdog.
 * True once for each run of the timer. */
bool gateway_may_kick(gateway *g);

/* Bits of ::gateway_reason; 0: the machine may move. From any context, also for
 * a gateway that is all zeros or was refused. */
uint32_t gateway_reasons(const gateway *g);

/* The stream's end: hands out the lines that are open. Only counters and
 * reasons may be read after it. */
void gateway_finish(gateway *g);

#endif
