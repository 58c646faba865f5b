/* The raw part of a frame: arrays that grow line by line. */
#include "raw_internal.h"

#include "base/grow.h"
#include "base/sized.h"
#include "frame_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct array {
    void *at;
    size_t room;
} array;

struct lum_raw_store {
    size_t line_count;
    size_t lines_without_packets;
    size_t packet_count;
    array first_word;
    array words;
    array gives_point;
    array angles;
    array marks;
    array packets;
    array places;
    bool has_places;
};

static bool grow(array *a, size_t used, size_t more, size_t bytes)
{
    void *at = lum_grown(a->at, used, more, bytes, &a->room);
    a->at = at != NULL ? at : a->at;
    return at != NULL;
}

static size_t count_words(const lum_raw_store *s)
{
    const uint64_t *first = s->first_word.at;
    return (size_t)first[s->line_count];
}

lum_raw_store *lum_raw_store_new(void)
{
    lum_raw_store *s = calloc(1, sizeof *s);
    if (s != NULL && !grow(&s->first_word, 0, 1, sizeof(uint64_t))) {
        free(s);
        return NULL;
    }
    if (s != NULL) {
        lum_raw_store_clear(s);
    }
    return s;
}

void lum_raw_store_free(lum_raw_store *store)
{
    if (store == NULL) {
        return;
    }
    free(store->first_word.at);
    free(store->words.at);
    free(store->gives_point.at);
    free(store->angles.at);
    free(store->marks.at);
    free(store->packets.at);
    free(store->places.at);
    free(store);
}

void lum_raw_store_clear(lum_raw_store *store)
{
    uint64_t *first = store->first_word.at;
    first[0] = 0;
    store->line_count = 0;
    store->lines_without_packets = 0;
    store->packet_count = 0;
    store->has_places = false;
}

bool lum_raw_store_reserve(lum_raw_store *store, const lum_line *line,
                           const lum_raw_list *packets)
{
    const size_t lines = store->line_count;
    const size_t used = count_words(store);
    const size_t more = line->word_count;
    return grow(&store->first_word, lines + 1u, 1, sizeof(uint64_t)) &&
           grow(&store->words, used, more, sizeof(uint32_t)) &&
           grow(&store->gives_point, used, more, sizeof(uint8_t)) &&
           grow(&store->angles, lines * LUM_LINE_PIXELS, LUM_LINE_PIXELS,
                sizeof(lum_angle)) &&
           grow(&store->marks, lines * LUM_PIXEL_MARK_WORDS,
                LUM_PIXEL_MARK_WORDS, sizeof(uint32_t)) &&
           grow(&store->packets, store->packet_count, packets->count,
                sizeof(lum_raw_packet)) &&
           (!(store->has_places || packets->places != NULL) ||
            grow(&store->places, used, more, sizeof(uint16_t)));
}

static void add_packets(lum_raw_store *s, const lum_raw_list *list)
{
    lum_raw_packet *to = s->packets.at;
    for (size_t i = 0; i < list->count; i++) {
        to[s->packet_count] = list->packets[i];
        to[s->packet_count].line = (uint32_t)s->line_count;
        s->packet_count++;
    }
    s->lines_without_packets += list->count == 0 ? 1u : 0u;
}

/* The places of the words from begin to end of a line; NULL: in their order. */
static void put_places(lum_raw_store *s, const uint16_t *places, size_t begin,
                       size_t end)
{
    uint16_t *to = s->places.at;
    for (size_t i = begin; i < end; i++) {
        to[i] = places != NULL ? places[i - begin] : (uint16_t)(i - begin);
    }
}

/* The first line with places has the lines before it get theirs. */
static void add_places(lum_raw_store *s, const lum_line *line,
                       const uint16_t *places)
{
    const uint64_t *first = s->first_word.at;
    const size_t begin = count_words(s);
    if (places != NULL && !s->has_places) {
        for (size_t i = 0; i < s->line_count; i++) {
            put_places(s, NULL, (size_t)first[i], (size_t)first[i + 1u]);
        }
        s->has_places = true;
    }
    if (s->has_places) {
        put_places(s, places, begin, begin + line->word_count);
    }
}

void lum_raw_store_add(lum_raw_store *store, const lum_projector *projector,
                       const lum_line *line, const lum_raw_list *packets)
{
    const size_t at = count_words(store);
    uint64_t *first = store->first_word.at;
    uint8_t *gives = store->gives_point.at;
    lum_angle *angles = store->angles.at;
    uint32_t *marks = store->marks.at;
    if (line->word_count > 0) {
        uint32_t *words = store->words.at;
        memcpy(words + at, line->words, line->word_count * sizeof *words);
        lum_points_mark(projector, line, gives + at);
    }
    memcpy(angles + store->line_count * LUM_LINE_PIXELS, line->angles,
           LUM_LINE_PIXELS * sizeof *angles);
    memcpy(marks + store->line_count * LUM_PIXEL_MARK_WORDS, line->angle_marks,
           LUM_PIXEL_MARK_WORDS * sizeof *marks);
    add_packets(store, packets);
    add_places(store, line, packets->places);
    store->line_count++;
    first[store->line_count] = at + line->word_count;
}

lum_result lum_frame_get_raw(const lum_frame *frame, lum_frame_raw *out)
{
    const lum_raw_store *s = frame->raw;
    if (s == NULL) {
        return LUM_E_VALUE;
    }
    const lum_frame_raw raw = {.struct_size = sizeof raw,
                               .line_count = s->line_count,
                               .first_word = s->first_word.at,
                               .words = s->words.at,
                               .gives_point = s->gives_point.at,
                               .angles = s->angles.at,
                               .angle_marks = s->marks.at,
                               .packet_count = s->packet_count,
                               .packets = s->packets.at,
                               .lines_without_packets =
                                   s->lines_without_packets,
                               .places = s->has_places ? s->places.at : NULL};
    return lum_sized_fill(out, &raw, sizeof raw) ? LUM_OK : LUM_E_VALUE;
}
