/* Heartbeats on schedule, for as long as the main loop lives.
 *
 * Heartbeats keep a laser on, so a program that hangs must not send them. The
 * timer calls heart_tick(), which sends; the main loop calls heart_beat() in
 * each of its rounds. Without a round for HEART_STALL_MS no heartbeat leaves,
 * and the sensor's own 3 s do the rest. */
#ifndef HEART_H
#define HEART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define HEART_PERIOD_MS 200u  /* five a second */
#define HEART_STALL_MS  2000u /* a main loop without a round for so long */
#define HEART_POLL      5u    /* every fifth asks for the laser's status too */

/* Sends a datagram to the sensor's port 5517. Returns false when it could not
 * be handed to the hardware. Called from where heart_tick() is. */
typedef bool heart_send(void *context, const uint8_t *bytes, size_t len);

typedef struct heart {
    heart_send *send;
    void *context;
    uint32_t rounds;  /* shared: written by the main loop alone */
    uint32_t stalled; /* shared: written by the tick alone */
    uint32_t rounds_seen;
    uint32_t alive_ms;
    uint32_t next_ms;
    uint32_t sequence;
    uint32_t sent;
    uint32_t failed;
    uint8_t until_poll;
} heart;

/* Begin: the first tick sends. */
void heart_init(heart *h, heart_send *send, void *context, uint32_t now_ms);

/* From a timer's interrupt or the main loop, every 100 ms or more often. now_ms
 * may wrap. A heartbeat that could not be sent is tried again by the next
 * tick; what was missed is not made up for. */
void heart_tick(heart *h, uint32_t now_ms);

/* From the main loop, where it has looked for datagrams. */
void heart_beat(heart *h);

/* Whether the main loop hangs; from either side. */
bool heart_is_stalled(const heart *h);

#endif
