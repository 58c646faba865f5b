#include "decoder.h"

#include "../common/number.h"
#include "../common/under_way.h"
#include "lum/smooth.h"
#include "strongest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An eye may begin a frame before the other has ended the one before. */
#define DRAFTS_MAX 4u

struct draft {
    bool is_used;
    struct picture picture;
};

/* Filters of the windows that are in use. */
struct filters {
    size_t count;
    unsigned window[FEED_VIEWS_MAX];
    lum_smooth filter[FEED_VIEWS_MAX];
};

struct decoder {
    struct decoder_options options;
    lum_demux *demux;
    struct draft drafts[DRAFTS_MAX];
    struct picture complete;
    int64_t from; /* frames before it are passed over */
    bool is_skipping;
    bool has_frame;
    int64_t first;
    int64_t last;
    bool has_shown; /* the sensor that is shown was heard */
    size_t shown;   /* its index */
    uint32_t address;
    size_t looked_at;     /* sensors */
    lum_packet_kind kind; /* of the record that is being pushed */
    uint64_t bytes;
    uint64_t points;
    struct under_way under_way;
    uint64_t left_out;     /* lines that came too late for their picture */
    struct totals skipped; /* what was counted while passing over */
    struct totals mark;    /* as of the last begin of that */
    bool has_no_memory;
    struct filters filters;
    lum_angle angles[LUM_LINE_PIXELS];
    lum_sample_workspace workspace;
    lum_sample *samples;
    lum_return *returns;
    uint8_t *strongest; /* of each sample */
};

struct decoder *decoder_new(const struct decoder_options *options)
{
    struct decoder *d = calloc(1, sizeof *d);
    if (d == NULL) {
        return NULL;
    }
    lum_demux_options demux = {.layout = *options->layout,
                               .has_sensor = options->has_sensor,
                               .sensor = options->sensor};
    lum_assembler_config_default(&demux.config);
    const size_t words = demux.config.words_per_line;
    d->options = *options;
    d->from = INT64_MIN;
    d->kind = LUM_PACKET_KINDS;
    d->demux = lum_demux_new(&demux);
    d->samples = malloc(words * sizeof *d->samples);
    d->returns = malloc(words * sizeof *d->returns);
    d->strongest = malloc(words);
    d->workspace.returns = malloc(words * sizeof *d->workspace.returns);
    if (d->demux == NULL || d->samples == NULL || d->returns == NULL ||
        d->strongest == NULL || d->workspace.returns == NULL) {
        decoder_free(d);
        return NULL;
    }
    return d;
}

static void drop_drafts(struct decoder *d, int64_t before)
{
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        if (d->drafts[i].is_used && d->drafts[i].picture.frame < before) {
            picture_drop(&d->drafts[i].picture);
            d->drafts[i].is_used = false;
        }
    }
}

void decoder_free(struct decoder *decoder)
{
    if (decoder == NULL) {
        return;
    }
    drop_drafts(decoder, INT64_MAX);
    picture_drop(&decoder->complete);
    lum_demux_free(decoder->demux);
    free(decoder->samples);
    free(decoder->returns);
    free(decoder->strongest);
    free(decoder->workspace.returns);
    free(decoder);
}

/* The sensor that is shown is the first that sent data, or the one that was
 * asked for. */
static void look_for_shown(struct decoder *d)
{
    lum_demux_sensor sensor;
    const size_t count = lum_demux_sensor_count(d->demux);
    for (size_t i = d->looked_at; i < count && !d->has_shown; i++) {
        lum_demux_get_sensor(d->demux, i, &sensor);
        d->has_shown =
            !d->options.has_sensor || sensor.address == d->options.sensor;
        d->shown = i;
        d->address = sensor.address;
    }
    d->looked_at = count;
}

static bool is_shown(const struct decoder *d)
{
    return d->has_shown && lum_demux_current_index(d->demux) == d->shown;
}

/* All there is so far, what was passed over too. */
static void count_all(const struct decoder *d, struct totals *out)
{
    lum_demux_sensor sensor;
    *out = (struct totals){.bytes = d->bytes, .points = d->points};
    if (!d->has_shown) {
        return;
    }
    lum_demux_get_sensor(d->demux, d->shown, &sensor);
    const lum_demux_counters *c = &sensor.counters;
    for (unsigned i = 0; i < LUM_PACKET_KINDS; i++) {
        out->packets += c->packets[i];
    }
    out->lost_words = c->assembly.lost_words;
    out->lost_lines = c->assembly.lines_skipped +
                      c->assembly.lines_missing_angles + d->left_out;
    out->joined_words = d->under_way.counts.words;
    out->joined_lines = d->under_way.counts.lines;
    out->refused =
        c->assembly.late + c->assembly.conflict + c->assembly.no_room +
        c->assembly.stray + c->packets[LUM_PACKET_MALFORMED] +
        c->packets[LUM_PACKET_UNKNOWN_TAG] +
        c->packets[LUM_PACKET_UNKNOWN_TYPE] + c->packets[LUM_PACKET_FOREIGN];
}

static void end_skipping(struct decoder *d)
{
    struct totals now;
    if (!d->is_skipping) {
        return;
    }
    d->is_skipping = false;
    count_all(d, &now);
    totals_add(&d->skipped, &now);
    totals_subtract(&d->skipped, &d->mark);
}

void decoder_skip_to(struct decoder *decoder, int64_t frame)
{
    end_skipping(decoder);
    count_all(decoder, &decoder->mark);
    decoder->is_skipping = true;
    decoder->from = frame;
    drop_drafts(decoder, frame);
    picture_drop(&decoder->complete);
}

void decoder_count(const struct decoder *decoder, struct totals *out)
{
    count_all(decoder, out);
    if (decoder->is_skipping) {
        *out = decoder->mark;
    }
    totals_subtract(out, &decoder->skipped);
}

bool decoder_range(const struct decoder *decoder, int64_t *first, int64_t *last)
{
    *first = decoder->first;
    *last = decoder->last;
    return decoder->has_frame;
}

struct picture *decoder_picture(struct decoder *decoder)
{
    return &decoder->complete;
}

const char *decoder_others(const struct decoder *decoder, uint32_t *shown,
                           char *out, size_t room)
{
    lum_demux_sensor sensor;
    char address[16];
    size_t len = 0;
    *out = '\0';
    *shown = decoder->address;
    for (size_t i = 0; i < lum_demux_sensor_count(decoder->demux); i++) {
        lum_demux_get_sensor(decoder->demux, i, &sensor);
        if ((!decoder->has_shown || i != decoder->shown) &&
            len + 2u + sizeof address < room) {
            const int n =
                snprintf(out + len, room - len, "%s%s", len > 0 ? ", " : "",
                         number_format_address(sensor.address, address));
            len += n > 0 ? (size_t)n : 0;
        }
    }
    return out;
}

static void begin_draft(struct decoder *d, struct draft *draft,
                        const lum_line *line)
{
    struct picture *p = &draft->picture;
    *p = (struct picture){.frame = line->frame,
                          .arrival_ns = line->arrival,
                          .clock_us = line->clock_us,
                          .sensor = d->address};
    draft->is_used = true;
    p->count = stage_views(d->options.stage, p->views);
    for (size_t i = 0; i < p->count; i++) {
        p->frames[i] = frame_begin(d->options.pool);
        d->has_no_memory |= p->frames[i] == NULL;
    }
}

/* The draft of a line's frame. NULL: the frame is complete already, or more
 * frames are open than can be. */
static struct picture *find_draft(struct decoder *d, const lum_line *line)
{
    struct draft *unused = NULL;
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        struct draft *draft = &d->drafts[i];
        if (draft->is_used && draft->picture.frame == line->frame) {
            return &draft->picture;
        }
        unused = draft->is_used ? unused : draft;
    }
    if (unused == NULL || (d->has_frame && line->frame <= d->last)) {
        return NULL;
    }
    begin_draft(d, unused, line);
    return &unused->picture;
}

/* NULL: no such filter can be. */
static const lum_smooth *find_filter(struct filters *f, unsigned window)
{
    size_t i = 0;
    while (i < f->count && f->window[i] != window) {
        i++;
    }
    if (i < f->count) {
        return &f->filter[i];
    }
    i = f->count < FEED_VIEWS_MAX ? f->count : 0;
    if (lum_smooth_init(&f->filter[i], window, LUM_SMOOTH_ORDER(window)) !=
        LUM_OK) {
        return NULL;
    }
    f->window[i] = window;
    f->count += f->count < FEED_VIEWS_MAX ? 1u : 0u;
    return &f->filter[i];
}

/* The points of a line, of all views that smooth alike. */
static void add_views(struct decoder *d, struct picture *p,
                      const lum_line *line, unsigned smooth, unsigned edges)
{
    lum_point_losses losses = {0, 0};
    lum_selection selection;
    lum_line smoothed = *line;
    const lum_smooth *filter =
        smooth > 1u ? find_filter(&d->filters, smooth) : NULL;
    if (filter != NULL) {
        lum_smooth_line(filter, line, d->angles);
        smoothed.angles = d->angles;
    }
    lum_selection_default(&selection);
    selection.edges = (lum_edges)edges;
    struct frame_part part = {.samples = d->samples,
                              .strongest = d->strongest,
                              .line = line->number,
                              .eye = line->eye};
    part.count =
        lum_samples_compute(d->options.projector, &smoothed, &selection,
                            &d->workspace, d->samples, &losses);
    strongest_mark(line, d->returns, d->samples, part.count, d->strongest);
    for (size_t i = 0; i < p->count; i++) {
        part.edges = p->views[i].edges;
        if (p->views[i].smooth == smooth && p->frames[i] != NULL &&
            !frame_add(p->frames[i], &part)) {
            d->has_no_memory = true;
        }
    }
}

/* Whether a view before this one smooths alike, and which edges those that do
 * want. */
static bool is_first_alike(const struct picture *p, size_t view,
                           unsigned *edges)
{
    bool is_first = true;
    *edges = 0;
    for (size_t i = 0; i < p->count; i++) {
        if (p->views[i].smooth == p->views[view].smooth) {
            is_first &= i >= view;
            *edges |= (unsigned)p->views[i].edges;
        }
    }
    return is_first;
}

static void add_line(struct decoder *d, struct picture *p, const lum_line *line)
{
    p->lines++;
    p->lost_words += line->lost_words;
    p->arrival_ns =
        line->arrival < p->arrival_ns ? line->arrival : p->arrival_ns;
    p->clock_us = line->clock_us < p->clock_us ? line->clock_us : p->clock_us;
    for (size_t i = 0; i < p->count; i++) {
        unsigned edges = 0;
        if (is_first_alike(p, i, &edges)) {
            add_views(d, p, line, p->views[i].smooth, edges);
        }
    }
}

static void count_points(struct decoder *d, const lum_line *line)
{
    lum_point_losses losses = {0, 0};
    uint64_t rising = 0;
    uint64_t falling = 0;
    lum_points_count(d->options.projector, line, &rising, &falling, &losses);
    d->points += rising;
}

static void take_line(struct decoder *d)
{
    const lum_line *line = lum_assembler_line(lum_demux_current(d->demux));
    if (!is_shown(d)) {
        return;
    }
    under_way_take(&d->under_way, line, 0);
    if (line->frame < d->from) {
        return;
    }
    end_skipping(d);
    count_points(d, line);
    struct picture *draft = find_draft(d, line);
    if (draft == NULL) {
        d->left_out++;
        return;
    }
    add_line(d, draft, line);
}

/* Gives the frame that is complete its picture, an empty one where not a line
 * of it came. */
static void complete(struct decoder *d, int64_t frame)
{
    picture_drop(&d->complete);
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        struct draft *draft = &d->drafts[i];
        if (draft->is_used && draft->picture.frame == frame) {
            d->complete = draft->picture;
            *draft = (struct draft){.is_used = false};
            return;
        }
    }
    d->complete = (struct picture){.frame = frame, .sensor = d->address};
}

static enum decoded take_frame(struct decoder *d)
{
    const int64_t frame = lum_assembler_frame(lum_demux_current(d->demux));
    if (!is_shown(d)) {
        return DECODED_ALL;
    }
    d->first = d->has_frame ? d->first : frame;
    d->has_frame = true;
    d->last = frame;
    drop_drafts(d, frame);
    if (frame < d->from) {
        return DECODED_ALL;
    }
    complete(d, frame);
    return DECODED_FRAME;
}

static enum decoded take_event(struct decoder *d, lum_result event)
{
    if (event == LUM_FRAME_READY) {
        return take_frame(d);
    }
    take_line(d);
    return d->has_no_memory ? DECODED_FAILED : DECODED_ALL;
}

static void count_bytes(struct decoder *d, const lum_record *record)
{
    if (!d->has_shown) {
        look_for_shown(d);
    }
    if (d->kind != LUM_PACKET_KINDS && d->has_shown &&
        record->source == d->address) {
        d->bytes += record->len;
    }
    d->kind = LUM_PACKET_KINDS;
}

enum decoded decoder_push(struct decoder *decoder, const lum_record *record)
{
    lum_result r = LUM_OK;
    while ((r = lum_demux_push(decoder->demux, record, &decoder->kind)) > 0) {
        const enum decoded decoded = take_event(decoder, r);
        if (decoded != DECODED_ALL) {
            return decoded;
        }
    }
    count_bytes(decoder, record);
    return r == LUM_OK ? DECODED_ALL : DECODED_FAILED;
}

enum decoded decoder_flush(struct decoder *decoder)
{
    lum_result r = LUM_OK;
    under_way_leave(&decoder->under_way);
    while ((r = lum_demux_flush(decoder->demux)) > 0) {
        const enum decoded decoded = take_event(decoder, r);
        if (decoded != DECODED_ALL) {
            return decoded;
        }
    }
    return DECODED_ALL;
}
