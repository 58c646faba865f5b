/* Which packets the lines under way are made of. A line is known by its number:
 * an eye has at most one open line of each. */
#include "raw_internal.h"

#include "base/grow.h"
#include "core/group.h"

#include <stdlib.h>
#include <string.h>

#define OPEN_MAX LUM_ASSEMBLER_SLOTS(LUM_OPEN_LINES_MAX)
#define UNKNOWN  UINT16_MAX /* no place: LUM_RAW_PLACES_MAX */

/* The pixels of a line's samples of ranges, as they came, from the first packet
 * on that is not in order; what came before is. */
typedef struct pixel_list {
    uint32_t before; /* samples that came before */
    uint32_t last;   /* pixel of the last of them */
    bool is_full;    /* there are too many: none is of use */
    uint16_t *at;    /* a bad word has none that is possible */
    size_t count;
    size_t room;
} pixel_list;

typedef struct open_line {
    bool is_used;
    uint8_t eye;
    uint32_t number;
    lum_raw_list list;
    pixel_list pixels;
} open_line;

typedef struct watched {
    open_line open[OPEN_MAX];
    uint64_t bad_words; /* that its assembler had counted */
} watched;

struct lum_raw_watch {
    uint64_t order;
    size_t samples_at;                       /* of packets */
    watched *sensors[LUM_DEMUX_SENSORS_MAX]; /* NULL: nothing came */
    lum_raw_list taken;
    uint16_t places[LUM_LINE_WORDS_MAX]; /* of taken */
};

/* --- Packets come --- */

static open_line *find(watched *s, uint8_t eye, uint32_t number)
{
    for (size_t i = 0; i < OPEN_MAX; i++) {
        open_line *o = &s->open[i];
        if (o->is_used && o->eye == eye && o->number == number) {
            return o;
        }
    }
    return NULL;
}

static open_line *open_one(watched *s, uint8_t eye, uint32_t number)
{
    size_t i = 0;
    while (i < OPEN_MAX && s->open[i].is_used) {
        i++;
    }
    if (i == OPEN_MAX) {
        return NULL;
    }
    open_line *o = &s->open[i];
    o->is_used = true;
    o->eye = eye;
    o->number = number;
    o->list.count = 0;
    o->pixels.before = 0;
    o->pixels.last = 0;
    o->pixels.is_full = false;
    o->pixels.count = 0;
    return o;
}

static bool reserve(lum_raw_list *list)
{
    lum_raw_packet *packets =
        lum_grown(list->packets, list->count, 1, sizeof *packets, &list->room);
    if (packets == NULL) {
        return false;
    }
    list->packets = packets;
    return true;
}

/* Whether a packet's words are good, and ordered by pixel behind what came. A
 * bad word is above every pixel, so that the last one tells of it. */
static bool is_in_order(const pixel_list *pixels, const lum_group *group)
{
    uint32_t borrow = place_of(group_word(group, 0)) - pixels->last;
    for (uint32_t i = 1; i < group->num_samples; i++) {
        borrow |= place_of(group_word(group, i)) -
                  place_of(group_word(group, i - 1u));
    }
    return borrow >> 31 == 0 &&
           place_of(group_word(group, group->num_samples - 1u)) <
               LUM_LINE_PIXELS;
}

/* At most LUM_RAW_PLACES_MAX: bad words cannot use up memory. */
static bool add_pixels(pixel_list *pixels, const lum_group *group)
{
    const uint32_t n = group->num_samples;
    if (group->tag != LUM_TAG_RANGES) {
        return true;
    }
    if (!pixels->is_full && pixels->count == 0 && is_in_order(pixels, group)) {
        pixels->before += n;
        pixels->last = place_of(group_word(group, n - 1u));
        return true;
    }
    if (n > LUM_RAW_PLACES_MAX - pixels->before - pixels->count) {
        pixels->is_full = true;
    }
    if (pixels->is_full) {
        return true;
    }
    uint16_t *at =
        lum_grown(pixels->at, pixels->count, n, sizeof *at, &pixels->room);
    if (at == NULL) {
        return false;
    }
    pixels->at = at;
    for (uint32_t i = 0; i < n; i++) {
        pixels->at[pixels->count++] = (uint16_t)place_of(group_word(group, i));
    }
    return true;
}

static uint32_t first_pixel(const lum_group *group)
{
    if (group->tag == LUM_TAG_ANGLES) {
        return group->first_sample_index;
    }
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = lum_group_word(group, i);
        if (lum_word_is_good(word)) {
            return lum_word_pixel(word);
        }
    }
    return 0;
}

static void add(lum_raw_list *list, const lum_demux_taken *packet,
                uint64_t order, uint32_t bad_words)
{
    const lum_group *group = packet->group;
    const size_t head = packet->layout->profile.samples_at;
    lum_raw_packet *p = &list->packets[list->count++];
    *p = (lum_raw_packet){.clock_raw = group->clock_raw,
                          .arrival_ns = packet->time_ns,
                          .order = order,
                          .first_sample_index = group->first_sample_index,
                          .num_samples = group->num_samples,
                          .bad_words = bad_words,
                          .tag = group->tag,
                          .first_pixel = first_pixel(group)};
    memcpy(p->head, group->samples - head, head);
    const size_t samples = (size_t)LUM_SAMPLE_BYTES * group->num_samples;
    const size_t tail = packet->len - head - samples;
    if (tail <= LUM_RAW_TAIL_MAX) {
        memcpy(p->tail, group->samples + samples, tail);
        p->tail_bytes = (uint32_t)tail;
    }
}

/* Without memory a packet is left out, which is_all() sees. */
static void take(void *context, const lum_demux_taken *packet)
{
    lum_raw_watch *w = context;
    const lum_group *group = packet->group;
    if (packet->result != LUM_OK) {
        return;
    }
    if (w->sensors[packet->sensor] == NULL) {
        w->sensors[packet->sensor] = calloc(1, sizeof *w->sensors[0]);
    }
    watched *s = w->sensors[packet->sensor];
    if (s == NULL) {
        return;
    }
    const uint64_t bad = lum_assembler_counters(packet->assembler)->bad_words;
    open_line *o = find(s, group->eye, group->line);
    o = o != NULL ? o : open_one(s, group->eye, group->line);
    if (o != NULL && reserve(&o->list) && add_pixels(&o->pixels, group)) {
        add(&o->list, packet, w->order++, (uint32_t)(bad - s->bad_words));
    }
    s->bad_words = bad;
}

/* --- Lines go --- */

/* Whether a line has just what these packets brought: what an open line was
 * restored with, or what there was no memory for, is in none of them. */
static bool is_all(const lum_raw_list *list, const lum_line *line)
{
    uint64_t angles = 0;
    uint64_t words = 0;
    for (size_t i = 0; i < list->count; i++) {
        const lum_raw_packet *p = &list->packets[i];
        angles += p->tag == LUM_TAG_ANGLES ? p->num_samples : 0u;
        words += p->tag == LUM_TAG_RANGES ? p->num_samples - p->bad_words : 0u;
    }
    return angles == line->angle_count && words == line->word_count;
}

/* NULL: the words came in their order. Words of a pixel are of one packet. */
static const uint16_t *find_places(lum_raw_watch *w, const pixel_list *pixels,
                                   const lum_line *line)
{
    uint16_t next[LUM_LINE_PIXELS] = {0}; /* of each pixel */
    uint16_t place = 0;
    if (pixels->count == 0 || pixels->is_full) {
        return NULL;
    }
    for (uint32_t i = line->word_count; i > 0; i--) {
        next[lum_word_pixel(line->words[i - 1u])] = (uint16_t)(i - 1u);
        w->places[i - 1u] = UNKNOWN;
    }
    for (size_t i = 0; i < pixels->count; i++) {
        const uint16_t pixel = pixels->at[i];
        if (pixel < LUM_LINE_PIXELS) {
            w->places[next[pixel]++] = (uint16_t)(pixels->before + i);
        }
    }
    for (uint32_t i = 0; i < line->word_count; i++) {
        if (w->places[i] == UNKNOWN) {
            w->places[i] = place++;
        }
    }
    return w->places;
}

const lum_raw_list *lum_raw_watch_take(lum_raw_watch *watch, size_t sensor,
                                       const lum_line *line)
{
    watched *s = watch->sensors[sensor];
    open_line *o = s != NULL ? find(s, line->eye, line->number) : NULL;
    watch->taken.count = 0;
    watch->taken.places = NULL;
    if (o == NULL) {
        return &watch->taken;
    }
    const lum_raw_list list = o->list;
    o->list = watch->taken;
    o->is_used = false;
    watch->taken = list;
    if (is_all(&list, line)) {
        watch->taken.places = find_places(watch, &o->pixels, line);
    } else {
        watch->taken.count = 0;
    }
    return &watch->taken;
}

/* --- Begin and end --- */

lum_raw_watch *lum_raw_watch_new(lum_demux *demux)
{
    lum_raw_watch *w = calloc(1, sizeof *w);
    if (w != NULL) {
        lum_demux_watch(demux, take, w);
    }
    return w;
}

void lum_raw_watch_restart(lum_raw_watch *watch)
{
    for (size_t i = 0; watch != NULL && i < LUM_DEMUX_SENSORS_MAX; i++) {
        watched *s = watch->sensors[i];
        for (size_t k = 0; s != NULL && k < OPEN_MAX; k++) {
            s->open[k].is_used = false;
            s->bad_words = 0;
        }
    }
}

void lum_raw_watch_free(lum_raw_watch *watch)
{
    if (watch == NULL) {
        return;
    }
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        watched *s = watch->sensors[i];
        for (size_t k = 0; s != NULL && k < OPEN_MAX; k++) {
            free(s->open[k].list.packets);
            free(s->open[k].pixels.at);
        }
        free(s);
    }
    free(watch->taken.packets);
    free(watch);
}
