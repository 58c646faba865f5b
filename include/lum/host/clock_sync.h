/** @file
 * The sensor's clock against the host's (docs/protocol.md, sections 3, 6).
 * Integers only, reentrant, constant time. */
#ifndef LUM_HOST_CLOCK_SYNC_H
#define LUM_HOST_CLOCK_SYNC_H

#include "lum/result.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Number of exchanges in an estimate. */
#define LUM_CLOCK_EXCHANGES 16u

/** A sensor clock further than this from where it was expected was reset. */
#define LUM_CLOCK_RESET_NS INT64_C(1000000000)

/** One exchange of timestamps. Private. */
typedef struct lum_clock_exchange {
    int64_t middle_ns; /**< private: host, half way between both times */
    int64_t offset_ns; /**< private: host less sensor */
    int64_t error_ns;  /**< private: half the round trip */
} lum_clock_exchange;

/** Estimate of a sensor's clock against a host's. Only its size is public. */
typedef struct lum_clock_sync {
    lum_clock_exchange anchor;                      /**< private: the best of
                                                         the early ones */
    lum_clock_exchange recent[LUM_CLOCK_EXCHANGES]; /**< private: a ring */
    int64_t clock_us;                               /**< private: extended */
    int64_t middle_ns;                              /**< private: of the last */
    uint32_t count;                                 /**< private */
    uint32_t resets;                                /**< private */
} lum_clock_sync;

/** What is known of a sensor's clock. Host times are by the clock that timed
 * the exchanges. */
typedef struct lum_clock_estimate {
    int64_t clock_us;        /**< the last reading, extended from the first
                                  exchange's raw value on, over any number of
                                  wraps */
    int64_t offset_ns;       /**< host less sensor: the best recent exchange,
                                  brought to the last one's time by the drift */
    int64_t error_ns;        /**< bound of its error: half the round trip, the
                                  sensor's microsecond, and the possible drift
                                  since */
    bool has_drift;          /**< two exchanges far enough apart */
    int32_t drift_ppb;       /**< billionths by which the host's clock runs
                                  faster than the sensor's */
    int32_t drift_error_ppb; /**< bound of its error */
    uint32_t exchanges;      /**< since the last reset, all counted */
    uint32_t resets;         /**< times the sensor's clock was reset */
} lum_clock_estimate;

/** Begin; nothing is known. Cannot fail. */
void lum_clock_sync_init(lum_clock_sync *out);

/** Take an exchange (section 3). The host's clock shows how often the sensor's
 * clock has wrapped since the last one, so exchanges may be any time apart.
 * @param sent_ns     host time just before the request left.
 * @param received_ns host time just after the answer came; the sensor stamped
 *                    in between. The same monotonic clock in every call.
 * @param clock_us    the sensor's 32-bit clock in the answer.
 * @return LUM_OK; LUM_E_VALUE if received_ns is before sent_ns or more than an
 *         hour after it. After a reset of the clock, the estimate begins anew
 *         with this exchange. */
LUM_MUST_CHECK lum_result lum_clock_sync_add(lum_clock_sync *sync,
                                             int64_t sent_ns,
                                             int64_t received_ns,
                                             uint32_t clock_us);

/** What is known.
 * @return LUM_OK; LUM_END before the first exchange. */
LUM_MUST_CHECK lum_result lum_clock_sync_estimate(const lum_clock_sync *sync,
                                                  lum_clock_estimate *out);

#ifdef __cplusplus
}
#endif

#endif
