/* Heartbeats on schedule, as long as the main loop runs.
 *
 * Heartbeats keep a laser on, so a program that hangs must not send them. The
 * timer calls heart_tick(), which sends; the main loop calls heart_beat() in
 * each of its rounds. After HEART_STALL_MS without a round no heartbeat is
 * sent, and the sensor switches the laser off after 3 s.
 *
 * With each heartbeat it sends a request for the sensor's clock, and with some
 * a poll of its status. Their sequence number is the time, and the answer
 * repeats it.
 *
 * A reset must not keep the laser on either: the sensor does not notice it, and
 * an earlier command to switch on is still in effect. So nothing is sent for
 * HEART_SILENCE_MS after the start, and nothing before the first round. By then
 * the sensor has timed out, and its laser waits for another command. */
#ifndef HEART_H
#define HEART_H

#include "lum/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define HEART_PERIOD_MS LUM_HEARTBEAT_MS
#define HEART_STALL_MS  2000u /* a main loop without a round for this long */
#define HEART_POLL      5u    /* every fifth asks for the laser's status too */

/* After the start. */
#define HEART_SILENCE_MS (LUM_HEARTBEAT_TIMEOUT_MS + 500u)

/* Sends a datagram to the sensor's port 5517. Returns false when it could not
 * be handed to the hardware. Called by heart_tick(). */
typedef bool heart_send(void *context, const uint8_t *bytes, size_t len);

typedef struct heart {
    heart_send *send;
    void *context;
    uint32_t rounds;   /* shared: written by the main loop alone */
    uint32_t lasts_ms; /* shared: likewise */
    uint32_t ticks;    /* shared: written by the tick alone */
    uint32_t stalls;   /* shared: written by the tick alone */
    uint32_t ticks_seen;
    uint32_t rounds_seen;
    uint32_t stall_ms;
    uint32_t alive_ms;
    uint32_t next_ms;
    uint32_t sent;   /* heartbeats */
    uint32_t failed; /* datagrams of all kinds */
    uint8_t until_poll;
    bool hung; /* for so long that no heartbeat may be sent */
} heart;

/* Begin: stalled, until the first round. */
void heart_init(heart *h, heart_send *send, void *context, uint32_t now_ms);

/* Only from a timer's interrupt, every 100 ms or more often: if the main loop
 * called it, a hang would not be detected. now_ms may wrap. A heartbeat that
 * could not be sent is tried again by the next tick; missed heartbeats are not
 * repeated. */
void heart_tick(heart *h, uint32_t now_ms);

/* From the main loop, after it has checked for datagrams. It is stalled if
 * there is no other round for lasts_ms, or for HEART_STALL_MS if that is
 * less. */
void heart_beat(heart *h, uint32_t lasts_ms);

/* From the main loop: whether there was a tick since the last call. */
bool heart_has_ticked(heart *h);

/* How often a stall of the main loop began or ended, including the one at the
 * start: odd during a stall. From either side. */
uint32_t heart_stalls(const heart *h);

#endif
