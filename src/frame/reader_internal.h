/* A reader: its source, where it is in that, and how it gets elsewhere. */
#ifndef LUM_FRAME_READER_INTERNAL_H
#define LUM_FRAME_READER_INTERNAL_H

#include "lum/frame/reader.h"

#include "base/go_on.h"
#include "index.h"

/* --- Where it is --- */

/* Frames that have begun and were not handed out: more than a framer has. */
#define LUM_INDEX_PENDING_MAX 8u

/* What a sensor's entries are made of. */
struct entry_maker {
    bool has_newest;
    uint32_t newest; /* the highest frame that it has begun */
    bool has_marked;
    uint32_t marked; /* the last one that got an entry */
    uint64_t active; /* the last record with data */
    lum_index_entry *pending[LUM_INDEX_PENDING_MAX]; /* not in the index yet */
    size_t pending_count;
};

struct index_entries {
    lum_pack early; /* a state of late, for sensors that appear */
    uint64_t early_after;
    struct entry_maker sensors[LUM_DEMUX_SENSORS_MAX];
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

/* All of it, with the file that it serves. A restart, which is
 * reader_place.c's, resets what belongs to the place before. */
struct place {
    bool has_begun;       /* reader_place.c */
    lum_pack start;       /* reader_place.c: the capture's state there */
    lum_pack clocks;      /* reader_place.c: what the framer knew there */
    struct jump jump;     /* reader_place.c */
    uint64_t records;     /* reader.c: that were read */
    struct frames frames; /* seek.c */
    struct target target; /* seek.c */
    struct index_entries entries; /* index_entries.c */
    bool keeps_index;             /* index_entries.c */
    lum_index index;              /* index_entries.c; index_file.c loads it */
};

/* --- The reader --- */

/* What the reader is about. */
enum reading {
    READING,
    PUSHING,  /* the record gave an event: push it again */
    FLUSHING, /* the source has ended */
    ENDED
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
    enum reading stage;
    lum_record record;
    int status;      /* how the source ended: 0 or -1 */
    lum_error error; /* why */
    struct place place;
};

/* --- Its source: reader_source.c --- */

/* Open the capture that the options name; the caller's source of bytes is taken
 * over, also on failure. 0, or -1 with the reason in error. */
int lum_reader_open_source(lum_reader *reader,
                           const lum_reader_options *options, lum_error *error);

/* Also if nothing was opened. */
void lum_reader_close_source(lum_reader *reader);

/* Open the paths again. 0, or -1 with the reason in error. */
int lum_reader_reopen(lum_reader *reader, lum_error *error);

/* --- Entries of its index: index_entries.c --- */

/* A record was read and pushed. Without memory there are fewer entries, or no
 * index is kept any more. */
void lum_index_entries_note_record(lum_reader *reader);

/* All was read and flushed. */
void lum_index_entries_note_end(lum_reader *reader);

/* A frame of a sensor was handed out: entries that begin with it are complete
 * and go into the index. lines: of its frame before. */
void lum_index_entries_finish(struct place *place, size_t sensor,
                              int64_t number, const uint32_t lines[LUM_EYES]);

/* A sensor has the state of an entry: its next entries come behind that. */
void lum_index_entries_go_on(lum_reader *reader, const lum_index_entry *entry);

/* Drop all that is not in the index. */
void lum_index_entries_forget(struct index_entries *entries);

/* --- Going to another place: reader_place.c --- */

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

/* --- What is sought: seek.c --- */

/* Whether an event is to be told: what comes before a sought frame is not. */
bool lum_seek_shows(lum_reader *reader, lum_framer_event event);

#endif
