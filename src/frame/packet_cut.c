/* Where a line is cut into packets: as it was, if its packets still fit; else
 * as the sensor does it. */
#include "packet_cut.h"

#include "base/grow.h"
#include "core/cuts.h"
#include "core/field.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define USUAL_BYTES 1472u /* the payload of an Ethernet frame */

/* Stands for a word that was skipped when the line was read. */
#define BAD_WORD LUM_WORD_ZERO

size_t lum_cut_bytes(const lum_layout *layout, const lum_cut_packet *packet)
{
    return layout->profile.samples_at +
           (size_t)LUM_SAMPLE_BYTES * packet->head.num_samples +
           packet->head.tail_bytes;
}

static size_t room_of(const lum_layout *layout, size_t bytes)
{
    return (bytes - layout->profile.samples_at) / LUM_SAMPLE_BYTES;
}

/* --- What a line is checked for --- */

static int check_words(const lum_raw_line *line, lum_error *error)
{
    for (size_t i = 0; i < line->word_count; i++) {
        const uint32_t pixel = lum_word_pixel(line->words[i]);
        if (!lum_word_is_good(line->words[i])) {
            return lum_error_set(error,
                                 "line %lu of the %s eye: word %zu is 0x%08lx; "
                                 "bit 11 must be 0 and the pixel 0 to 999",
                                 (unsigned long)line->number,
                                 lum_cut_eye(line->eye), i,
                                 (unsigned long)line->words[i]);
        }
        if (i > 0 && pixel < lum_word_pixel(line->words[i - 1u])) {
            return lum_error_set(
                error,
                "line %lu of the %s eye: pixel %lu follows pixel %lu; order "
                "the words of a line by pixel, and those of a pixel by return",
                (unsigned long)line->number, lum_cut_eye(line->eye),
                (unsigned long)pixel,
                (unsigned long)lum_word_pixel(line->words[i - 1u]));
        }
    }
    return 0;
}

static int check_line(const lum_raw_line *line, lum_error *error)
{
    if (line->eye >= LUM_EYES) {
        return lum_error_set(
            error, "line %lu: eye is %u; use 0 for blue or 1 for green",
            (unsigned long)line->number, (unsigned)line->eye);
    }
    if (line->word_count > LUM_LINE_WORDS_MAX) {
        return lum_error_set(
            error, "line %lu of the %s eye: %zu words; at most %u are possible",
            (unsigned long)line->number, lum_cut_eye(line->eye),
            line->word_count, LUM_LINE_WORDS_MAX);
    }
    return check_words(line, error);
}

static bool is_marked(const uint32_t *marks, uint32_t pixel)
{
    return marks != NULL && (marks[pixel / 32u] >> (pixel % 32u) & 1u) != 0;
}

/* --- As it was --- */

static lum_cut_packet *add(lum_cut *cut)
{
    lum_cut_packet *packets =
        lum_grown(cut->packets, cut->count, 1, sizeof *packets, &cut->room);
    if (packets == NULL) {
        return NULL;
    }
    cut->packets = packets;
    lum_cut_packet *p = &cut->packets[cut->count++];
    memset(p, 0, sizeof *p);
    return p;
}

/* In the order of their samples: words of a line are ordered by pixel. A packet
 * without a good word takes none, wherever it stands. */
static int compare_pixel(const void *a, const void *b)
{
    const lum_cut_packet *p = a;
    const lum_cut_packet *q = b;
    const uint32_t i = p->head.first_pixel;
    const uint32_t k = q->head.first_pixel;
    return i != k ? (i < k ? -1 : 1)
                  : (p->head.line < q->head.line ? -1
                                                 : p->head.line > q->head.line);
}

/* In order of arrival; line is where it stood among the packets. */
static int compare_place(const void *a, const void *b)
{
    const lum_cut_packet *p = a;
    const lum_cut_packet *q = b;
    return p->head.line < q->head.line ? -1 : p->head.line > q->head.line;
}

/* Takes the pixels of a packet of angles out of left. */
static bool takes_angles(const lum_cut_packet *p, uint32_t *left)
{
    for (uint32_t i = 0; i < p->head.num_samples; i++) {
        const uint32_t pixel = p->head.first_sample_index + i;
        if (pixel >= LUM_LINE_PIXELS || !is_marked(left, pixel)) {
            return false;
        }
        left[pixel / 32u] &= ~(UINT32_C(1) << pixel % 32u);
    }
    return true;
}

/* Takes the next words of the line; a pixel does not cross packets. */
static bool takes_words(lum_cut_packet *p, const lum_raw_line *line, size_t *at)
{
    const uint32_t good = p->head.num_samples - p->head.bad_words;
    const size_t begin = *at;
    if (p->head.bad_words > p->head.num_samples ||
        good > line->word_count - begin) {
        return false;
    }
    p->first = (uint32_t)begin;
    *at = begin + good;
    return begin == 0 || begin == line->word_count ||
           lum_word_pixel(line->words[begin - 1u]) !=
               lum_word_pixel(line->words[begin]);
}

/* All words, in the order of pixels. */
static bool take_by_pixel(lum_cut *cut, const lum_raw_line *line)
{
    size_t words = 0;
    bool is_taken = true;
    qsort(cut->packets, cut->count, sizeof *cut->packets, compare_pixel);
    for (size_t i = 0; i < cut->count && is_taken; i++) {
        lum_cut_packet *p = &cut->packets[i];
        is_taken =
            p->head.tag != LUM_TAG_RANGES || takes_words(p, line, &words);
    }
    qsort(cut->packets, cut->count, sizeof *cut->packets, compare_place);
    return is_taken && words == line->word_count;
}

/* Puts each word at its place, of count places. False: places do not fit, or
 * words of a pixel are not in their order. */
static bool put_at_places(lum_cut *cut, const lum_raw_line *line, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        cut->samples[i] = BAD_WORD;
    }
    for (size_t i = 0; i < line->word_count; i++) {
        const uint16_t place = line->places[i];
        const uint32_t word = line->words[i];
        if (place >= count || cut->samples[place] != BAD_WORD ||
            (i > 0 && place < line->places[i - 1u] &&
             lum_word_pixel(word) == lum_word_pixel(line->words[i - 1u]))) {
            return false;
        }
        cut->samples[place] = word;
    }
    return true;
}

/* Whether a packet has as many good words as it should. owners: of each pixel,
 * the packet that has its words, from 1; a pixel does not cross packets. */
static bool is_whole(const lum_cut *cut, size_t packet,
                     size_t owners[LUM_LINE_PIXELS])
{
    const lum_cut_packet *p = &cut->packets[packet];
    uint32_t good = 0;
    for (uint32_t i = 0; i < p->head.num_samples; i++) {
        const uint32_t word = cut->samples[p->first + i];
        if (word == BAD_WORD) {
            continue;
        }
        size_t *owner = &owners[lum_word_pixel(word)];
        if (*owner != 0 && *owner != packet + 1u) {
            return false;
        }
        *owner = packet + 1u;
        good++;
    }
    return p->head.bad_words == p->head.num_samples - good;
}

/* All words, each to its place. */
static bool take_by_place(lum_cut *cut, const lum_raw_line *line)
{
    size_t owners[LUM_LINE_PIXELS] = {0};
    uint32_t count = 0;
    for (size_t i = 0; i < cut->count; i++) {
        lum_cut_packet *p = &cut->packets[i];
        if (p->head.tag != LUM_TAG_RANGES) {
            continue;
        }
        if (p->head.num_samples > LUM_RAW_PLACES_MAX - count) {
            return false;
        }
        p->first = count;
        count += p->head.num_samples;
    }
    if (!put_at_places(cut, line, count)) {
        return false;
    }
    for (size_t i = 0; i < cut->count; i++) {
        if (cut->packets[i].head.tag == LUM_TAG_RANGES &&
            !is_whole(cut, i, owners)) {
            return false;
        }
    }
    return true;
}

/* Whether packets are possible, and have the angles of the line. */
static bool fits(const lum_cut *cut, const lum_layout *layout,
                 const lum_raw_line *line)
{
    uint32_t left[LUM_PIXEL_MARK_WORDS] = {0};
    const bool has_number =
        field_bits(&layout->profile.group[LUM_FIELD_NUM_SAMPLES]) > 0;
    const uint32_t most_tail =
        has_number ? LUM_RAW_TAIL_MAX : LUM_SAMPLE_BYTES - 1u;
    if (line->angle_marks != NULL) {
        memcpy(left, line->angle_marks, sizeof left);
    }
    for (size_t i = 0; i < cut->count; i++) {
        const lum_cut_packet *p = &cut->packets[i];
        const bool is_possible =
            p->head.num_samples > 0 && p->head.tail_bytes <= most_tail &&
            p->head.num_samples <=
                room_of(layout, LUM_CUT_BYTES_MAX - p->head.tail_bytes) &&
            (p->head.tag == LUM_TAG_RANGES ||
             (p->head.tag == LUM_TAG_ANGLES && takes_angles(p, left)));
        if (!is_possible) {
            return false;
        }
    }
    uint32_t over = 0;
    for (size_t i = 0; i < LUM_PIXEL_MARK_WORDS; i++) {
        over |= left[i];
    }
    return over == 0;
}

/* 1: all words are in its packets; 0: they do not fit; -1 without memory. */
static int take_words(lum_cut *cut, const lum_raw_line *line, lum_error *error)
{
    if (line->places != NULL) {
        if (cut->samples == NULL) {
            cut->samples = malloc(LUM_RAW_PLACES_MAX * sizeof *cut->samples);
        }
        if (cut->samples == NULL) {
            return lum_error_set(error, "out of memory");
        }
        cut->is_placed = take_by_place(cut, line);
    }
    return cut->is_placed || take_by_pixel(cut, line) ? 1 : 0;
}

/* Whether fields of the file stand where those of the line do. */
static bool keeps_head(const lum_layout *to, const lum_layout *from)
{
    if (from == NULL) {
        return true;
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const lum_field *a = &to->profile.group[f];
        const lum_field *b = &from->profile.group[f];
        if (a->at != b->at || a->bytes != b->bytes || a->order != b->order ||
            a->low != b->low || a->bits != b->bits) {
            return false;
        }
    }
    return to->profile.samples_at == from->profile.samples_at;
}

static int cut_as_it_was(lum_cut *cut, const lum_layout *layout,
                         const lum_raw_line *line, lum_error *error)
{
    for (size_t i = 0; i < line->packet_count; i++) {
        lum_cut_packet *p = add(cut);
        if (p == NULL) {
            return lum_error_set(error, "out of memory");
        }
        p->head = line->packets[i];
        p->head.line = (uint32_t)i;
        if (!keeps_head(layout, line->layout)) {
            memset(p->head.head, 0, sizeof p->head.head);
            p->head.tail_bytes = 0;
        }
        p->first = p->head.first_sample_index;
    }
    return 0;
}

/* --- As the sensor does it --- */

static lum_cut_packet *add_new(lum_cut *cut, const lum_raw_line *line,
                               uint32_t tag, uint32_t first, uint32_t n)
{
    lum_cut_packet *p = add(cut);
    if (p != NULL) {
        p->head.tag = tag;
        p->head.first_sample_index = first;
        p->head.num_samples = n;
        p->head.arrival_ns = line->arrival_ns;
        p->head.order = line->packet_count > 0 ? line->packets[0].order : 0;
        p->first = first;
    }
    return p;
}

/* The angles from begin to end, without the pixels that have none. */
static bool cut_angles(lum_cut *cut, const lum_raw_line *line, uint32_t begin,
                       uint32_t end)
{
    uint32_t at = begin;
    while (at < end) {
        uint32_t n = 0;
        while (at + n < end && is_marked(line->angle_marks, at + n)) {
            n++;
        }
        if (n > 0 && add_new(cut, line, LUM_TAG_ANGLES, at, n) == NULL) {
            return false;
        }
        at += n + 1u;
    }
    return true;
}

static int add_words(lum_cut *cut, const lum_layout *layout,
                     const lum_raw_line *line, lum_error *error)
{
    const size_t usual = room_of(layout, USUAL_BYTES);
    for (size_t at = 0; at < line->word_count;) {
        const size_t end = cut_words(line->words, line->word_count, at, usual);
        if (end - at > room_of(layout, LUM_CUT_BYTES_MAX)) {
            return lum_error_set(
                error,
                "line %lu of the %s eye: pixel %lu has %zu words; a packet "
                "holds "
                "at most %zu, and a pixel does not cross packets",
                (unsigned long)line->number, lum_cut_eye(line->eye),
                (unsigned long)lum_word_pixel(line->words[at]), end - at,
                room_of(layout, LUM_CUT_BYTES_MAX));
        }
        if (add_new(cut, line, LUM_TAG_RANGES, (uint32_t)at,
                    (uint32_t)(end - at)) == NULL) {
            return lum_error_set(error, "out of memory");
        }
        at = end;
    }
    return 0;
}

static int cut_anew(lum_cut *cut, const lum_layout *layout,
                    const lum_raw_line *line, lum_error *error)
{
    uint32_t at = 0;
    cut->is_anew = true;
    cut->count = 0;
    for (size_t i = 0; i < LINE_CUTS; i++) {
        if (!cut_angles(cut, line, at, at + line_cuts[i])) {
            return lum_error_set(error, "out of memory");
        }
        at += line_cuts[i];
    }
    return add_words(cut, layout, line, error);
}

int lum_cut_line(lum_cut *cut, const lum_layout *layout,
                 const lum_raw_line *line, lum_error *error)
{
    int taken = 0;
    cut->count = 0;
    cut->is_anew = false;
    cut->is_placed = false;
    if (check_line(line, error) != 0 ||
        cut_as_it_was(cut, layout, line, error) != 0) {
        return -1;
    }
    if (cut->count > 0 && fits(cut, layout, line)) {
        taken = take_words(cut, line, error);
    }
    return taken == 0 ? cut_anew(cut, layout, line, error) : taken < 0 ? -1 : 0;
}

void lum_cut_free(lum_cut *cut)
{
    free(cut->packets);
    free(cut->samples);
}

/* --- Bytes --- */

static int refuse_value(const lum_layout *layout, const lum_raw_line *line,
                        const lum_group *group, lum_error *error)
{
    static const struct {
        unsigned field;
        const char *name;
    } fields[] = {{LUM_FIELD_LINE, "line number"},
                  {LUM_FIELD_NUM_SAMPLES, "number of samples"},
                  {LUM_FIELD_FIRST_SAMPLE_INDEX, "index of the first sample"}};
    const uint32_t values[] = {group->line, group->num_samples,
                               group->first_sample_index};
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        const unsigned bits =
            field_bits(&layout->profile.group[fields[i].field]);
        if (bits > 0 && bits < 32u && values[i] >> bits != 0) {
            return lum_error_set(
                error,
                "line %lu of the %s eye: its %s is %lu; the profile's field of "
                "%u bits holds at most %lu",
                (unsigned long)line->number, lum_cut_eye(line->eye),
                fields[i].name, (unsigned long)values[i], bits,
                (unsigned long)((UINT32_C(1) << bits) - 1u));
        }
    }
    return lum_error_set(error,
                         "line %lu of the %s eye: the profile cannot hold a "
                         "packet of it",
                         (unsigned long)line->number, lum_cut_eye(line->eye));
}

/* The bits of a head that belong to fields. */
static void find_fields(const lum_layout *layout,
                        uint8_t out[LUM_GROUP_HEAD_MAX])
{
    memset(out, 0, LUM_GROUP_HEAD_MAX);
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const lum_field *field = &layout->profile.group[f];
        for (unsigned i = 0; i < field_bits(field); i++) {
            const unsigned bit = field->low + i;
            out[field->at + (bit / 8u ^ field_flip(field))] |=
                (uint8_t)(1u << bit % 8u);
        }
    }
    memset(out, 0xff, LUM_HEADER_BYTES);
}

/* What a sensor sends beside the fields that are known. */
static void put_rest(const lum_layout *layout, const uint8_t *head,
                     uint8_t *out)
{
    uint8_t fields[LUM_GROUP_HEAD_MAX];
    find_fields(layout, fields);
    for (size_t i = LUM_HEADER_BYTES; i < layout->profile.samples_at; i++) {
        out[i] |= (uint8_t)(head[i] & ~fields[i]);
    }
}

static uint32_t word_of(const lum_cut *cut, const lum_raw_line *line,
                        const lum_cut_packet *packet, uint32_t i)
{
    if (cut->is_placed) {
        return cut->samples[packet->first + i];
    }
    return i < packet->head.num_samples - packet->head.bad_words
               ? line->words[packet->first + i]
               : BAD_WORD;
}

int lum_cut_encode(const lum_cut *cut, const lum_layout *layout,
                   const lum_raw_line *line, const lum_cut_packet *packet,
                   uint8_t *out, lum_error *error)
{
    const lum_raw_packet *head = &packet->head;
    const lum_group group = {.line = line->number,
                             .num_samples = head->num_samples,
                             .first_sample_index = head->first_sample_index,
                             .clock_raw = head->clock_raw,
                             .eye = line->eye,
                             .tag = (uint8_t)head->tag};
    const size_t bytes = lum_cut_bytes(layout, packet);
    size_t len = 0;
    if (lum_group_encode(layout, &group, out, bytes, &len) != LUM_OK) {
        return refuse_value(layout, line, &group, error);
    }
    put_rest(layout, head->head, out);
    for (uint32_t i = 0; i < head->num_samples; i++) {
        uint8_t *to = out + len + (size_t)LUM_SAMPLE_BYTES * i;
        if (head->tag == LUM_TAG_ANGLES) {
            lum_angle_encode(layout, line->angles[packet->first + i], to);
        } else {
            lum_group_word_encode(layout, word_of(cut, line, packet, i), to);
        }
    }
    memcpy(out + bytes - head->tail_bytes, head->tail, head->tail_bytes);
    return 0;
}
