/** @file
 * Converts the sensor's clock to UTC, by the arrival times of its packets.
 *
 * An arrival stamp says when the host noticed a packet. This is up to
 * milliseconds late, and many packets get one stamp if the system takes them in
 * batches. The sensor's clock has no such jitter, but its own zero and rate.
 * The fit combines both: no packet arrives before it was sent, so the true
 * times of clock readings lie on a line below all arrivals. The fit keeps the
 * earliest arrival of each eighth of a second, for the last 16 s, and lays the
 * line under them.
 *
 * What it can and cannot know:
 * - The time that every packet needs at least (the cable, the switch, a line
 *   that is sent after it was measured) cannot be seen in the arrivals. The
 *   answer includes it, the estimated error does not.
 * - UTC is that of the host's clock. If it is wrong, so is the answer.
 * - Stamps may be rounded, down or up. Their resolution is taken as the largest
 *   step that fits all of them: whole microseconds, or a second divided by a
 *   power of 2. It is part of the estimated error.
 * - At the beginning little is known, and the estimated error is large: with
 *   stamps in batches of 8 ms it falls below 1 ms within about a second.
 * - An answer uses only what came before it. A later answer for the same
 *   reading may differ, but by no more than their errors.
 *
 * If a sensor restarts or the host's clock is stepped, a new fit begins; it
 * keeps the known drift. Readings before the latest step still use the fit
 * before it. The error is ::LUM_CLOCK_ERROR_UNKNOWN within a second of a step,
 * while arrivals look like a step, and while they stand still. An answer given
 * before a step does not consider it. If the host's clock is slewed, by up to
 * 500 ppm, the fit follows within the window of 16 s; during this time the
 * error grows.
 *
 * It uses only integers, and is the same on every machine. The memory,
 * 5.5 KB, does not grow. Only one thread at a time may use a fit; two share
 * nothing. */
#ifndef LUM_FRAME_CLOCK_FIT_H
#define LUM_FRAME_CLOCK_FIT_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Largest distance from the newest reading for which lum_clock_fit_utc()
 * answers. */
#define LUM_CLOCK_FIT_NEAR_US INT64_C(60000000)

/** Readings lie within +-this: 17 years. */
#define LUM_CLOCK_FIT_CLOCK_MAX_US (INT64_C(1) << 49)

/** Arrivals lie within +-this: to the year 2079. */
#define LUM_CLOCK_FIT_ARRIVAL_MAX_NS (INT64_C(3) << 60)

/** A sensor's clock against arrivals. */
typedef struct lum_clock_fit lum_clock_fit;

/** Make a fit that knows nothing.
 * @return to be freed with lum_clock_fit_free(); NULL without memory. */
lum_clock_fit *lum_clock_fit_new(void);

/** Free it. NULL is allowed. */
void lum_clock_fit_free(lum_clock_fit *fit);

/** Forget all, as after lum_clock_fit_new(). */
void lum_clock_fit_reset(lum_clock_fit *fit);

/** From the first reading on, use what another fit has learned from the same
 * stream, for example from the first part of a file, read in advance. Readings
 * that the other has taken may be taken again. Nothing is learned from a fit
 * that met a break. */
void lum_clock_fit_learn(lum_clock_fit *to, const lum_clock_fit *from);

/** What happened to a reading. */
typedef enum lum_clock_fit_event {
    LUM_CLOCK_FIT_TAKEN,        /**< it went into the fit */
    LUM_CLOCK_FIT_ASIDE,        /**< it contradicts those before: a single one
                                     is left out, several that agree mean a
                                     restart or a step */
    LUM_CLOCK_FIT_SENSOR_BREAK, /**< the sensor's clock jumped, as when it
                                     restarts: the fit began anew */
    LUM_CLOCK_FIT_HOST_STEP,    /**< the host's clock was stepped: likewise */
    LUM_CLOCK_FIT_REFUSED       /**< a value is outside its range */
} lum_clock_fit_event;

/** Take a reading. Readings come in about the order of arrival; one that is
 * late, by up to the window, is taken too. Time is bounded: that of sorting 128
 * numbers twice, a few times a second.
 * @param clock_us   the sensor's clock, extended beyond its 32 bits: that of a
 *                   lum_line, or of a packet by lum_clock_extend().
 * @param arrival_ns when its packet arrived, ns since 1970 UTC. */
lum_clock_fit_event lum_clock_fit_add(lum_clock_fit *fit, int64_t clock_us,
                                      int64_t arrival_ns);

/** Note the arrival of a packet without a reading: it also shows the resolution
 * of the stamps. */
void lum_clock_fit_note_stamp(lum_clock_fit *fit, int64_t arrival_ns);

/** An unknown error, larger than all others: the host's clock was stepped
 * nearby, or its stamps stand still. */
#define LUM_CLOCK_ERROR_UNKNOWN INT64_C(9223372036854775807)

/** A moment. It never grows. */
typedef struct lum_clock_time {
    int64_t utc_ns;   /**< ns since 1970 UTC */
    int64_t error_ns; /**< its estimated error in both directions, without
                           the time that every packet needs at least; or
                           ::LUM_CLOCK_ERROR_UNKNOWN */
} lum_clock_time;

/** When the sensor's clock showed a reading.
 * @param clock_us as for lum_clock_fit_add(); need not have been added.
 * @param out      overwritten on LUM_OK. If the reading was set aside and may
 *                 come from a sensor that has restarted, this is only as exact
 *                 as its arrival.
 * @return LUM_OK; LUM_END before the first reading; LUM_E_VALUE if it is
 *         further than ::LUM_CLOCK_FIT_NEAR_US from the newest. */
LUM_MUST_CHECK lum_result lum_clock_fit_utc(const lum_clock_fit *fit,
                                            int64_t clock_us,
                                            lum_clock_time *out);

/** The state of a fit. */
typedef struct lum_clock_fit_info {
    size_t struct_size; /**< sizeof(lum_clock_fit_info), set by the caller */
    uint64_t taken;     /**< readings that were taken */
    uint64_t aside;     /**< readings that were set aside and left out */
    uint64_t sensor_breaks;  /**< times the sensor's clock jumped */
    uint64_t host_steps;     /**< times the host's clock was stepped */
    int64_t newest_us;       /**< the newest reading */
    int64_t error_ns;        /**< of its time; see lum_clock_time */
    bool has_drift;          /**< it was measured since the last break */
    int32_t drift_ppb;       /**< billionths by which the host's clock runs
                                  faster than the sensor's */
    int32_t drift_error_ppb; /**< its estimated error in both directions */
    int64_t resolution_ns;   /**< of the arrivals, as seen in them; at least
                                  1000 */
    uint64_t still; /**< those of aside that had the same arrival as readings
                         long before: stamps stood still */
} lum_clock_fit_info;

/** Read the state of a fit.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_END before the first reading, then newest_us and what
 *         follows are 0; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_clock_fit_get_info(const lum_clock_fit *fit,
                                  lum_clock_fit_info *out);

#ifdef __cplusplus
}
#endif

#endif
