/* Where a reader is in its capture, and how it gets elsewhere. */
#ifndef LUM_FRAME_PLACE_H
#define LUM_FRAME_PLACE_H

#include "index_entries.h"

/* What is sought. */
enum sought {
    SOUGHT_NOTHING,
    SOUGHT_ORDER,
    SOUGHT_NUMBER,
    SOUGHT_TIME
};

struct target {
    enum sought what;
    uint64_t order;
    uint32_t sensor; /* its address */
    int64_t number;
    int64_t time_ns;
};

/* Of a sensor: the frame that came last. */
struct last_frame {
    bool is_there;
    int64_t number;
    uint32_t lines[LUM_EYES];
};

/* The frames that came. */
struct frames {
    bool is_lost;       /* what follows is not of this place */
    uint64_t order;     /* of the next one */
    int64_t highest_ns; /* the highest begin; INT64_MIN: none */
    struct last_frame last[LUM_DEMUX_SENSORS_MAX];
};

/* A sensor whose data is passed over until its state holds. */
struct awaited {
    uint32_t sensor;
    uint64_t after;               /* this record its state holds */
    const lum_index_entry *entry; /* NULL: it has sent nothing before */
};

/* The way to an entry in the middle. */
struct jump {
    bool is_made;           /* not all frames before this place came */
    bool is_approaching;    /* frames come that are not whole, up to: */
    lum_index_entry anchor; /* without its states */
    struct awaited awaited[LUM_DEMUX_SENSORS_MAX]; /* by record */
    size_t awaited_count;
    size_t awaited_next;
};

/* All of it, with the file that changes it. */
struct place {
    bool has_begun;               /* place.c: what follows is set */
    lum_pack start;               /* place.c: the capture's state there */
    lum_pack taught;              /* place.c: what the framer knew there */
    struct jump jump;             /* place.c */
    uint64_t records;             /* reader.c: that were read */
    struct frames frames;         /* seek.c */
    struct target target;         /* seek.c */
    struct index_entries entries; /* index_entries.c, as what follows */
    bool keeps_index;
    lum_index index;
};

/* Before the first record: note where that is. */
void lum_place_begin(lum_reader *reader);

/* Before a record is read: load the states that hold there, and pass over what
 * nobody needs. 0, or -1 with the reason in error. */
int lum_place_approach(lum_reader *reader, lum_error *error);

/* Go to the first record; what is sought is forgotten. 0, or -1 with the reason
 * in error. */
int lum_place_restart(lum_reader *reader, lum_error *error);

/* Go to where an entry's frame comes whole; if its state cannot be used, drop
 * the index and go to the first record. 0, or -1 with the reason in error. */
int lum_place_jump(lum_reader *reader, const lum_index_entry *to,
                   lum_error *error);

/* A frame came: whether it comes whole. That of the entry, and all behind it,
 * do. */
bool lum_place_is_reached(struct place *place, size_t sensor, int64_t number);

void lum_place_free(struct place *place);

/* --- seek.c --- */

/* Whether an event is to be told: what comes before a sought frame is not. */
bool lum_seek_shows(lum_reader *reader, lum_framer_event event);

#endif
