/* A reader, and where in its capture it is. */
#ifndef LUM_FRAME_READER_INTERNAL_H
#define LUM_FRAME_READER_INTERNAL_H

#include "lum/frame/reader.h"

#include "base/go_on.h"
#include "index.h"

/* Frames that have begun and were not handed out: more than a framer has. */
#define LUM_PLACE_PENDING_MAX 8u

/* What the reader is about. */
enum stage {
    READING,
    PUSHING,  /* the record gave an event: push it again */
    FLUSHING, /* the source has ended */
    ENDED
};

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

/* What is followed of a sensor. */
struct followed {
    bool has_newest;
    uint32_t newest; /* the highest frame that it has begun */
    bool has_marked;
    uint32_t marked;          /* the last one that got an entry */
    uint32_t lines[LUM_EYES]; /* of the frame that came last */
    uint64_t active;          /* the last record with data */
    bool has_last;
    int64_t last; /* the number of its frame that came last */
    lum_index_entry *pending[LUM_PLACE_PENDING_MAX];
    size_t pending_count;
};

/* A sensor whose data is passed over until its state holds. */
struct awaited {
    uint32_t sensor;
    uint64_t after;               /* this record its state holds */
    const lum_index_entry *entry; /* NULL: it has sent nothing before */
    const lum_index_birth *birth;
};

/* Where the reader is. */
struct place {
    bool has_begun; /* what follows is set */
    bool is_lost;   /* order and the like are not of this place */
    bool keeps_index;
    lum_index index;
    lum_pack start;  /* the capture's state there */
    lum_pack taught; /* what the framer knew there */
    lum_pack early;  /* a state of late, for sensors that appear */
    uint64_t early_after;
    uint64_t records; /* that were read */
    uint64_t order;   /* of the next frame */
    int64_t highest_ns;
    struct followed sensors[LUM_DEMUX_SENSORS_MAX];
    struct awaited awaited[LUM_DEMUX_SENSORS_MAX]; /* by record */
    size_t awaited_count;
    size_t awaited_next;
    bool has_jumped;        /* not all frames before this place came */
    bool is_approaching;    /* frames come that are not whole, up to: */
    lum_index_entry anchor; /* without its states */
    struct target target;
};

struct lum_reader {
    lum_record_source source;
    lum_capture *capture; /* NULL: records of the caller */
    char **paths;         /* to open them again; NULL: not possible */
    size_t path_count;
    lum_go_on go_on;
    size_t work_bytes; /* most between two questions */
    size_t work;       /* since the last one */
    lum_framer *framer;
    enum stage stage;
    lum_record record;
    int status;      /* how the source ended: 0 or -1 */
    lum_error error; /* why */
    struct place place;
};

/* Open the capture that the options name; the caller's source of bytes is taken
 * over, also on failure. 0, or -1 with the reason in error. */
int lum_reader_open_source(lum_reader *reader,
                           const lum_reader_options *options, lum_error *error);

/* Also if nothing was opened. */
void lum_reader_close_source(lum_reader *reader);

/* Open the paths again. 0, or -1 with the reason in error. */
int lum_reader_reopen(lum_reader *reader, lum_error *error);

/* Before the first record: note where that is. */
void lum_place_begin(lum_reader *reader);

/* Before a record is read: load the states that hold there, and pass over what
 * nobody needs. 0, or -1 with the reason in error. */
int lum_place_approach(lum_reader *reader, lum_error *error);

/* A record was read and pushed. */
void lum_place_note_record(lum_reader *reader);

/* Whether an event is to be told: what comes before a sought frame is not. */
bool lum_place_shows(lum_reader *reader, lum_framer_event event);

/* All was read and flushed. */
void lum_place_note_end(lum_reader *reader);

void lum_place_free(struct place *place);

#endif
