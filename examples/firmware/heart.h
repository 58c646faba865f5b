/* Heartbeats on schedule, for as long as the main loop lives.
 *
 * Heartbeats keep a laser on, so a program that hangs must not send them. The
 * timer calls heart_tick(), which sends; the main loop calls heart_beat() in
 * each of its rounds. Without a round for HEART_STALL_MS no heartbeat leaves,
 * and the sensor's own 3 s do the rest.
 *
 * A reset must not keep the laser on either: the sensor does not see it, and
 * an earlier command to switch on still stands there. So nothing is sent for
 * HEART_SILENCE_MS after the start, nor before the first round. By then the
 * sensor has timed out, and its laser waits for another command. */
#ifndef HEART_H
#define HEART_H

#include "lum/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define HEART_PERIOD_MS LUM_HEARTBEAT_MS
#define HEART_STALL_MS  2000u /* a main loop without a round for so long */
#define HEART_POLL      5u    /* every fifth asks for the laser's status too */

/* After the start. */
#define HEART_SILENCE_MS (LUM_HEARTBEAT_TIMEOUT_MS + 500u)

/* Sends a datagram to the sensor's port 5517. Returns false when it could not
 * be handed to the hardware. Called by heart_tick(). */
typedef bool heart_send(void *context, const uint8_t *bytes, size_t len);

typedef struct heart {
    heart_send *send;
    void *context;
    uint32_t rounds; /* shared: written by the main loop alone */
    uint32_t ticks;  /* shared: written by the tick alone */
    uint32_t stalls; /* shared: written by the tick alone */
    uint32_t ticks_seen;
    uint32_t rounds_seen;
    uint32_t stall_ms;
    uint32_t alive_ms;
    uint32_t next_ms;
    uint32_t sequence;
    uint32_t sent;
    uint32_t failed;
    uint8_t until_poll;
    bool hung; /* for so long that no heartbeat may leave */
} heart;

/* Begin: stalled, until the first round.
 * stall_ms: the main loop is stalled after so long without a round, and after
 * HEART_STALL_MS if that is less. It makes a round more often than that. */
void heart_init(heart *h, heart_send *send, void *context, uint32_t stall_ms,
                uint32_t now_ms);

/* From a timer's interrupt and nowhere else, every 100 ms or more often: where
 * the main loop called it, a hang would pass unseen. now_ms may wrap. A
 * heartbeat that could not be sent is tried again by the next tick; what was
 * missed is not made up for. */
void heart_tick(heart *h, uint32_t now_ms);

/* From the main loop, where it has looked for datagrams. */
void heart_beat(heart *h);

/* From the main loop: whether there was a tick since this was asked last. */
bool heart_has_ticked(heart *h);

/* How often a stall of the main loop began or ended, the one at the start
 * included: odd while one lasts. From either side. */
uint32_t heart_stalls(const heart *h);

#endif
