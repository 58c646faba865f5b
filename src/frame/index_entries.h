/* Entries of an index, made while a capture is read from record to record; and
 * where the capture was before a sensor's first data. */
#ifndef LUM_FRAME_INDEX_ENTRIES_H
#define LUM_FRAME_INDEX_ENTRIES_H

#include "index.h"
#include "lum/frame/reader.h"

/* Frames that have begun and were not handed out: more than a framer has. */
#define LUM_INDEX_PENDING_MAX 8u

struct place;

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

#endif
