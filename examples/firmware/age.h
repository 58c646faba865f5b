/* How old a packet is, by the clock of the sensor that it bears. A network, a
 * switch or a queue may hold packets back for longer than a machine may act on
 * them, and nothing in the packet tells: its arrival is always now.
 *
 * So the timer asks the sensor for its clock with the time of asking as the
 * request's sequence number, which the answer repeats. The sensor's clock stood
 * there at that moment or later. A packet that bears a later clock is younger
 * than the request by as much; if it errs, it takes the packet for older. After
 * a restart of the sensor all packets are old, until it answers again. */
#ifndef AGE_H
#define AGE_H

#include "lum/wire.h"

#include <stdbool.h>
#include <stdint.h>

#define AGE_KEPT_MS  10000u     /* an answer serves for so long */
#define AGE_AHEAD_MS 100u       /* a packet may be of after the round began */
#define AGE_UNKNOWN  UINT32_MAX /* ms */
#define AGE_MAX_MS   600000u    /* what is older may be told as older still */

typedef struct age {
    int64_t asked_ms;
    uint32_t clock_us; /* of the sensor, when it was asked or later */
    bool answered;
} age;

/* Begin, without an answer. */
void age_init(age *a);

/* An answer of the sensor, taken at now_ms, whose low 32 bits are of the clock
 * that the request bears. It is left out if it was asked for max_ms ago, or
 * before the one that serves. */
void age_answer(age *a, const lum_timestamp *answer, int64_t now_ms,
                uint32_t max_ms);

/* Of a packet, in ms, rounded up; AGE_UNKNOWN where no answer serves. A clock
 * of AGE_AHEAD_MS ahead or less is now. One further ahead, which is of before
 * a restart, counts as older than AGE_MAX_MS. */
uint32_t age_of(const age *a, uint32_t clock_us, int64_t now_ms);

#endif
