/* Where in a capture reading can begin, so that a frame and all behind it come
 * as in a reading from the start. */
#ifndef LUM_FRAME_INDEX_H
#define LUM_FRAME_INDEX_H

#include "base/pack.h"
#include "capture/demux_state.h"
#include "frame_internal.h"
#include "lum/base/error.h"
#include "lum/capture/demux.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Most bytes of an index; above it, every other entry goes. */
#define LUM_INDEX_BYTES_MAX ((size_t)4 * 1024 * 1024)

/* A frame that reading can begin with. Records are counted from 1 on; a state
 * "after" a record holds before the next one. */
typedef struct lum_index_entry {
    uint32_t sensor;    /* its index */
    uint32_t from;      /* the first frame that the state gives whole */
    uint64_t after;     /* this record */
    uint64_t order;     /* of the first frame that it gives, among all */
    int64_t number;     /* of that frame */
    int64_t highest_ns; /* the highest start of a frame before it in order;
                           INT64_MIN: there is none */
    uint32_t lines[LUM_EYES]; /* of the frame before it, of its sensor */
    uint64_t active[LUM_DEMUX_SENSORS_MAX]; /* after which record the sensors
                                               had sent their last data */
    uint8_t *capture; /* the capture's state; allocated, with what follows */
    size_t capture_len;
    uint8_t *state; /* the sensor's */
    size_t state_len;
} lum_index_entry;

/* Where the capture is before the first data of a sensor. */
typedef struct lum_index_birth {
    uint64_t after;
    uint8_t *capture; /* allocated */
    size_t capture_len;
} lum_index_birth;

/* Whose data comes from where. */
typedef struct lum_index_origin {
    lum_demux_origin is;
    uint64_t known; /* after this record; a reading that begins behind is.since
                       and before it would not find it out */
} lum_index_origin;

/* A place in the capture. */
typedef struct lum_index_place {
    uint64_t after;
    const uint8_t *capture; /* NULL: it is the start */
    size_t capture_len;
} lum_index_place;

/* An index. All bytes 0, and stride 1: it is empty. */
typedef struct lum_index {
    lum_index_birth births[LUM_DEMUX_SENSORS_MAX];
    size_t birth_count;
    lum_index_origin origins[LUM_DEMUX_ORIGINS_MAX]; /* as they became known */
    size_t origin_count;
    lum_index_entry **entries; /* by order */
    size_t count;
    size_t room;
    size_t bytes;
    uint32_t stride; /* frames of a sensor from entry to entry */
    uint64_t known;  /* records that were looked at */
    uint64_t frames; /* among them */
    bool is_whole;   /* the capture has no more */
} lum_index;

/* Free all that it holds; then it is empty. */
void lum_index_clear(lum_index *index);

/* NULL is allowed. */
void lum_index_entry_free(lum_index_entry *entry);

/* Take an entry over, whose order is above all others. Without memory or room
 * it is dropped: then a seek takes longer. */
void lum_index_add(lum_index *index, lum_index_entry *entry);

/* The last entry of a sensor, or of any (LUM_DEMUX_SENSORS_MAX), with an order
 * of at most this. NULL: there is none. */
const lum_index_entry *lum_index_of(const lum_index *index, uint32_t sensor,
                                    uint64_t order);

/* The last entry of a sensor that is not behind a frame. */
const lum_index_entry *lum_index_at_number(const lum_index *index,
                                           uint32_t sensor, int64_t number);

/* The last entry before which no frame begins at a time or after it. */
const lum_index_entry *lum_index_at_time(const lum_index *index,
                                         int64_t time_ns);

/* Whether a reading that begins after a record finds out whose all data is. */
bool lum_index_is_certain(const lum_index *index, uint64_t after);

/* The last place after at most this many records where that is so. */
lum_index_place lum_index_place_at(const lum_index *index, uint64_t after);

/* What an index is of: of another one it is of no use. */
typedef struct lum_index_key {
    uint64_t bytes;   /* of the capture */
    uint32_t ends;    /* a sum of its first and its last bytes */
    uint32_t options; /* a sum of the options that matter */
} lum_index_key;

/* A sum of bytes that tells damage: CRC-32, going on from another one or 0. */
uint32_t lum_index_sum(uint32_t sum, const void *bytes, size_t len);

/* The file of an index as bytes, appended. False: something failed. */
bool lum_index_write(lum_index *index, const lum_index_key *key,
                     lum_pack *pack);

/* And back; out is empty. -1 with the reason in error, without the file's name;
 * then out is empty again. */
int lum_index_read(lum_index *out, const lum_index_key *key, const void *bytes,
                   size_t len, lum_error *error);

/* The same of what follows the key, up to the end. False: it is damaged. */
bool lum_index_read_body(lum_index *out, lum_pack *pack);

#endif
