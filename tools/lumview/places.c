/* A reader of the library keeps the index and jumps; records are read and
 * pushed by others here, so it has neither of its own. */
#include "places.h"

#include "capture/capture_internal.h"
#include "frame/framer_state.h"
#include "frame/reader_internal.h"

#include <stdlib.h>
#include <string.h>

struct places {
    lum_reader reader;
};

/* The sensor that is shown, as no other gives frames. */
#define SENSOR 0u

static struct places *make(lum_capture *capture, struct decoder *decoder)
{
    lum_framer *framer = decoder_framer(decoder);
    struct places *p = framer != NULL ? calloc(1, sizeof *p) : NULL;
    if (p != NULL) {
        p->reader.capture = capture;
        p->reader.framer = framer;
        p->reader.place.keeps_index = true;
        lum_place_begin(&p->reader);
    }
    return p;
}

struct places *places_new(lum_capture *capture, struct decoder *decoder)
{
    struct places *p = make(capture, decoder);
    if (p != NULL && !p->reader.place.keeps_index) {
        places_free(p);
        p = NULL;
    }
    return p;
}

void places_free(struct places *places)
{
    if (places != NULL) {
        lum_place_free(&places->reader.place);
        free(places);
    }
}

/* --- Noting --- */

static bool notes(const struct places *p)
{
    return p != NULL && p->reader.place.keeps_index;
}

void places_end(struct places *places)
{
    if (places != NULL) {
        lum_index_entries_forget(&places->reader.place.entries);
        places->reader.place.keeps_index = false;
    }
}

void places_drop(struct places *places)
{
    places_end(places);
    if (places != NULL) {
        lum_index_clear(&places->reader.place.index);
    }
}

void places_begin_record(struct places *places)
{
    if (notes(places)) {
        lum_demux_set_record(lum_framer_sensors(places->reader.framer),
                             ++places->reader.place.records);
    }
}

void places_note_frame(struct places *places)
{
    if (!notes(places)) {
        return;
    }
    struct place *at = &places->reader.place;
    const lum_framer *framer = places->reader.framer;
    struct last_frame *last = &at->frames.last[SENSOR];
    uint32_t lines[LUM_EYES];
    (void)memcpy(lines, last->lines, sizeof lines);
    lum_framer_get_lines(framer, SENSOR, last->lines);
    lum_index_entries_finish(at, SENSOR, lum_framer_frame_number(framer),
                             lines);
    at->index.frames = ++at->frames.order;
}

void places_note_record(struct places *places)
{
    if (notes(places)) {
        lum_index_entries_note_record(&places->reader);
    }
}

/* --- Going there --- */

static const lum_index_entry *find(const lum_index *index, int64_t frame)
{
    const lum_index_entry *entry = lum_index_at_number(index, SENSOR, frame);
    return entry != NULL && lum_index_is_certain(index, entry->after) ? entry
                                                                      : NULL;
}

bool places_find(const struct places *places, int64_t frame, int64_t *begin)
{
    const lum_index_entry *entry =
        places != NULL ? find(&places->reader.place.index, frame) : NULL;
    *begin = entry != NULL ? entry->number : 0;
    return entry != NULL;
}

/* Another sensor's data might have to be awaited, and that is not worth it. */
static bool jump(lum_reader *to, const lum_index_entry *entry)
{
    const bool is_there =
        lum_place_jump(to, entry, NULL) == 0 && to->place.jump.is_made &&
        lum_place_approach(to, NULL) == 0 && to->place.jump.is_made &&
        to->place.jump.awaited_next == to->place.jump.awaited_count;
    if (!is_there) {
        (void)lum_place_restart(to, NULL);
    }
    return is_there;
}

/* The index is lent: a jump drops it where it is of no use. */
bool places_go(struct places *places, lum_capture *capture,
               struct decoder *decoder, int64_t frame)
{
    lum_index *index = &places->reader.place.index;
    const lum_index_entry *entry = find(index, frame);
    struct places *to = entry != NULL ? make(capture, decoder) : NULL;
    if (!notes(to)) {
        places_free(to);
        return false;
    }
    const size_t entries = index->count;
    to->reader.place.index = *index;
    const bool is_there = jump(&to->reader, entry);
    *index = to->reader.place.index;
    to->reader.place.index = (lum_index){.stride = 1};
    if (index->count < entries) {
        places_end(places);
    }
    places_free(to);
    return is_there;
}
