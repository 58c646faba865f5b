/** @file
 * Records: datagrams with their time and their addresses, from a capture or
 * another source. */
#ifndef LUM_CAPTURE_RECORD_H
#define LUM_CAPTURE_RECORD_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Bytes of the name of an interface, with its NUL. */
#define LUM_INTERFACE_BYTES 64u

/** The kind of a record of a capture. */
typedef enum lum_record_kind {
    LUM_RECORD_DATAGRAM,  /**< a whole UDP datagram over IPv4 */
    LUM_RECORD_CUT_SHORT, /**< a datagram that the capture has only in part */
    LUM_RECORD_FRAGMENT,  /**< stored, used or repeated; counts as nothing */
    LUM_RECORD_OTHER,     /**< anything else */
    LUM_RECORD_JOINED     /**< as LUM_RECORD_DATAGRAM: one of several that a
                               receiving host had joined; already split */
} lum_record_kind;

/** A record of a capture. It never grows, because it is filled in for each
 * packet. */
typedef struct lum_record {
    int64_t time_ns;           /**< capture time, ns since 1970 UTC */
    const uint8_t *payload;    /**< datagrams: UDP payload; lives until the next
                                    read */
    size_t len;                /**< datagrams: bytes of payload */
    uint32_t source;           /**< datagrams, also cut ones: host order */
    uint32_t destination;      /**< likewise */
    uint16_t source_port;      /**< likewise */
    uint16_t destination_port; /**< likewise */
    lum_record_kind kind;      /**< what it is */
    uint32_t dropped_fragments; /**< fragments given up while this record was
                                     read; each is one more *other* */
} lum_record;

/** Whether a record is a whole datagram. */
static inline bool lum_record_is_datagram(const lum_record *record)
{
    return record->kind == LUM_RECORD_DATAGRAM ||
           record->kind == LUM_RECORD_JOINED;
}

/** A source of records other than the bytes of a capture: a live sensor
 * (lum/net/live.h), or functions of the caller. All bytes except struct_size
 * and next may be 0. */
typedef struct lum_record_source {
    size_t struct_size; /**< sizeof(lum_record_source) */
    /** The next record. It, and its payload, live until the next call.
     * @return 1; 0 at the end; -1 if the rest cannot be read, with the reason
     *         in error. At the end, dropped_fragments of out counts too. */
    int (*next)(void *context, lum_record *out, lum_error *error);
    /** As lum_capture_progress(); NULL: not known. */
    void (*progress)(void *context, uint64_t *done, uint64_t *total);
    /** Called once, when the reader is closed or could not be opened; may be
     * NULL. */
    void (*close)(void *context);
    void *context; /**< handed to these */
    /** For a source that waits: gets the function of
     * lum_reader_options.go_on once, before the first record. From then on,
     * next() calls it at least every 50 ms, also while it waits, and returns -1
     * when it says false. NULL: the reader itself asks, between records. */
    void (*set_go_on)(void *context, bool (*go_on)(void *go_on_context),
                      void *go_on_context);
} lum_record_source;

#ifdef __cplusplus
}
#endif

#endif
