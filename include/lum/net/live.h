/** @file
 * A live sensor as a source of records, for the reader of lum/frame/reader.h.
 *
 * The session's heartbeats are sent only inside the reader's calls: if a
 * program stops reading, the sensor switches its laser off after 3 s. Between
 * two of the reader's calls no other code may receive from the session: it
 * would overwrite records that the reader has not seen yet. Send requests over
 * another session, one that does not own the sensor.
 *
 * @code
 * lum_live_options live = {.struct_size = sizeof live, .sensor = sensor};
 * lum_record_source records = {.struct_size = sizeof records};
 * int status = lum_live_source(&live, &records, &error);
 * lum_reader_options options = {.struct_size = sizeof options,
 *                               .records = &records};
 * if (status == 0) {
 *     status = lum_reader_open(&options, &reader, &error);
 * }
 * @endcode */
#ifndef LUM_NET_LIVE_H
#define LUM_NET_LIVE_H

#include "lum/base/error.h"
#include "lum/capture/record.h"
#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Options of a live source. All bytes except struct_size and sensor may be 0.
 */
typedef struct lum_live_options {
    size_t struct_size;   /**< sizeof(lum_live_options) */
    lum_sensor *sensor;   /**< a session that owns the sensor; the caller closes
                             it after the source */
    uint32_t duration_ms; /**< end after this time; 0: never */
    uint32_t silence_ms;  /**< fail if nothing came from the sensor for this
                               time; 0: LUM_SENSOR_SILENCE_MS */
    /** Gets each event that brings no datagrams (see data_ms): answers to the
     * caller's requests, alerts, a link that went down. It may begin requests,
     * but must not receive. NULL: these events are ignored.
     * @return whether to go on; false ends the stream. */
    bool (*on_event)(void *context, const lum_sensor_event *event);
    void *context;    /**< handed to on_event */
    uint32_t data_ms; /**< on_event also gets a DATAGRAMS event, at most once in
                           this time; 0: none */
} lum_live_options;

/** Make a source of all datagrams that come from the sensor from now on. It
 * ends after the duration, when the session's cancel is raised, or when
 * on_event returns false. lum_reader_options.go_on is asked at least every 50
 * ms, also while nothing comes; heartbeats go on meanwhile. It fails if the
 * socket fails, if the sensor is silent, and if nothing came in the whole
 * duration. The laser stays as it is: while it is off, lines come without
 * words. lum_sensor_count() counts what the system dropped.
 * @param options read and not kept, except for the sensor and the context.
 * @param out     its struct_size is set by the caller; to be given to
 *                lum_reader_open(), or closed by its own close.
 * @param error   gets the message on failure: a struct_size or the sensor is
 *                not set, no memory.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_live_source(const lum_live_options *options,
                                   lum_record_source *out, lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
