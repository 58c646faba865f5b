/* How old a packet is, by the sensor's clock that it contains. A network, a
 * switch or a queue may delay packets for longer than a machine may act on
 * them, and nothing else shows it: a packet's arrival is always now.
 *
 * So the timer asks the sensor for its clock. The request's sequence number is
 * the time of the request, and the answer repeats it. The sensor had the clock
 * of the answer at that time or later. A packet with a later clock is younger
 * than the request by at least the difference: an error makes packets older,
 * never younger. After a restart of the sensor all packets are old, until it
 * answers again. */
#ifndef AGE_H
#define AGE_H

#include "lum/wire.h"

#include <stdbool.h>
#include <stdint.h>

#define AGE_KEPT_MS  10000u     /* an answer is used for this long */
#define AGE_AHEAD_MS 100u       /* a packet may be of after the round began */
#define AGE_UNKNOWN  UINT32_MAX /* ms */
#define AGE_MAX_MS   600000u /* a larger age may be reported as larger still */

typedef struct age {
    int64_t asked_ms;
    uint32_t clock_us; /* of the sensor, when it was asked or later */
    bool answered;
} age;

/* Begin, without an answer. */
void age_init(age *a);

/* An answer of the sensor, taken at now_ms, whose low 32 bits are of the same
 * clock as the request's sequence number. It is ignored if its request was sent
 * max_ms ago or earlier, or before that of the answer in use. */
void age_answer(age *a, const lum_timestamp *answer, int64_t now_ms,
                uint32_t max_ms);

/* Age of a packet, in ms, rounded up; AGE_UNKNOWN if there is no answer to use.
 * A clock that is ahead by AGE_AHEAD_MS or less counts as now. One further
 * ahead is from before a restart, and counts as older than AGE_MAX_MS. */
uint32_t age_of(const age *a, uint32_t clock_us, int64_t now_ms);

/* Whether a packet's clock is ahead by more than ahead_ms: then now_ms stands
 * still, or lags. One ahead by more than AGE_MAX_MS is from before a restart,
 * and shows nothing. */
bool age_is_ahead(const age *a, uint32_t clock_us, int64_t now_ms,
                  uint32_t ahead_ms);

#endif
