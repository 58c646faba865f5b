#include "cut.h"

#include "lum/packet.h"

#include <stdlib.h>
#include <string.h>

/* An eye has four open lines: after this many more were handed out, the line of
 * a packet will not come, because the packet was late or stray. */
#define LINES_AWAITED 8u

/* If an eye falls silent its last lines stay open, and packets of the other eye
 * wait behind theirs. At most this many bytes wait; then these packets are
 * treated like the line before of their eye. */
#define BYTES_MAX ((size_t)32 * 1024 * 1024)

enum fate {
    AWAITED, /* a data packet whose line has not come */
    WANTED,
    UNWANTED,
    OTHER /* no data */
};

struct held {
    lum_record record; /* without its payload */
    enum fate fate;
    int64_t frame; /* of its line */
    uint32_t line;
    uint8_t eye;
    uint64_t lines; /* of its eye that had come before it */
};

/* What is known of an eye. */
struct eye {
    uint64_t lines; /* that came */
    enum fate fate; /* of the last one */
    int64_t frame;
};

struct cut {
    const struct options *options;
    const lum_layout *layout;
    struct held *held; /* from first on, count of them */
    size_t first;
    size_t count;
    size_t room;
    uint8_t *bytes; /* their payloads, from begin to end */
    size_t begin;
    size_t end;
    size_t size;
    struct eye eyes[LUM_EYES];
    bool is_inside; /* the last line was of the selected frames, and packets of
                       an earlier line were written */
    bool has_ended;
};

bool cut_is_asked(const struct options *options)
{
    return !options->is_live && options_any(options, options_takes_packets) &&
           (options->choice.eyes != 3u || options_has_frames(options) ||
            options->choice.drop_incomplete);
}

struct cut *cut_new(const struct options *options, const lum_layout *layout)
{
    struct cut *cut = calloc(1, sizeof *cut);
    if (cut != NULL) {
        cut->options = options;
        cut->layout = layout;
        cut->eyes[LUM_EYE_BLUE].fate = UNWANTED;
        cut->eyes[LUM_EYE_GREEN].fate = UNWANTED;
    }
    return cut;
}

void cut_free(struct cut *cut)
{
    if (cut != NULL) {
        free(cut->held);
        free(cut->bytes);
        free(cut);
    }
}

/* Room for one more after the last; items that were handed out are removed. */
static bool make_room(struct cut *cut)
{
    if (cut->first + cut->count < cut->room) {
        return true;
    }
    if (cut->first > cut->room / 2u) {
        memmove(cut->held, cut->held + cut->first,
                cut->count * sizeof *cut->held);
        cut->first = 0;
        return true;
    }
    const size_t room = cut->room != 0 ? 2u * cut->room : 256u;
    struct held *held = realloc(cut->held, room * sizeof *held);
    if (held != NULL) {
        cut->held = held;
        cut->room = room;
    }
    return held != NULL;
}

static bool make_byte_room(struct cut *cut, size_t len)
{
    const size_t used = cut->end - cut->begin;
    if (cut->size - cut->end >= len) {
        return true;
    }
    if (cut->begin > cut->size / 2u && cut->size - used >= len) {
        memmove(cut->bytes, cut->bytes + cut->begin, used);
        cut->begin = 0;
        cut->end = used;
        return true;
    }
    size_t size = cut->size != 0 ? 2u * cut->size : (size_t)256 * 1024;
    while (size - cut->end < len) {
        size *= 2u;
    }
    uint8_t *bytes = realloc(cut->bytes, size);
    if (bytes != NULL) {
        cut->bytes = bytes;
        cut->size = size;
    }
    return bytes != NULL;
}

int cut_add(struct cut *cut, const lum_record *record, lum_error *error)
{
    lum_group group;
    if (!make_room(cut) || !make_byte_room(cut, record->len)) {
        return lum_error_set(error, "out of memory");
    }
    struct held *h = &cut->held[cut->first + cut->count++];
    *h = (struct held){.record = *record, .fate = OTHER};
    if (lum_packet_decode(cut->layout, record->payload, record->len, &group) ==
        LUM_PACKET_DATA) {
        h->fate = AWAITED;
        h->eye = group.eye;
        h->line = group.line;
        h->lines = cut->eyes[group.eye].lines;
    }
    if (record->len > 0) {
        memcpy(cut->bytes + cut->end, record->payload, record->len);
    }
    cut->end += record->len;
    return 0;
}

void cut_take_line(struct cut *cut, const lum_line *line, bool is_wanted)
{
    struct eye *eye = &cut->eyes[line->eye];
    eye->lines++;
    eye->fate = is_wanted ? WANTED : UNWANTED;
    eye->frame = line->frame;
    for (size_t i = 0; i < cut->count; i++) {
        struct held *h = &cut->held[cut->first + i];
        if (h->fate == AWAITED && h->eye == line->eye &&
            h->line == line->number) {
            h->fate = eye->fate;
            h->frame = line->frame;
        }
    }
}

void cut_end(struct cut *cut)
{
    cut->has_ended = true;
}

/* Decide on a packet whose line may still come. False: wait for it. */
static bool decide(const struct cut *cut, struct held *h)
{
    const struct eye *eye = &cut->eyes[h->eye];
    if (h->fate != AWAITED) {
        return true;
    }
    if (cut->has_ended || eye->lines - h->lines > LINES_AWAITED) {
        h->fate = UNWANTED;
        h->frame = eye->frame;
        return true;
    }
    if (cut->end - cut->begin > BYTES_MAX) {
        h->fate = eye->fate;
        h->frame = eye->frame;
        return true;
    }
    return false;
}

static bool is_in_frames(const struct options *o, int64_t frame)
{
    return frame >= o->choice.frame_first && frame <= o->choice.frame_last;
}

/* Whether a packet that was decided on is written. */
static bool is_written(struct cut *cut, const struct held *h)
{
    if (h->fate == OTHER) {
        return cut->options->choice.all_packets && cut->is_inside;
    }
    cut->is_inside = h->fate == WANTED ||
                     (cut->is_inside && is_in_frames(cut->options, h->frame));
    return h->fate == WANTED;
}

bool cut_next(struct cut *cut, lum_record *out)
{
    while (cut->count > 0 && decide(cut, &cut->held[cut->first])) {
        const struct held *h = &cut->held[cut->first];
        *out = h->record;
        out->payload = cut->bytes + cut->begin;
        cut->first++;
        cut->count--;
        cut->begin += out->len;
        if (is_written(cut, h)) {
            return true;
        }
    }
    return false;
}
