#include "decoder.h"

#include "../common/misfit.h"
#include "../common/number.h"
#include "base/text.h"
#include "capture/demux_state.h"
#include "gather.h"
#include "lum/frame/framer.h"
#include "second_profile.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Frames before the first that is wanted whose points the second makes. */
#define SECOND_EARLY 4

/* Frames beside which one of the second's is shown: a profile that does not fit
 * may bring none any more. */
#define SECOND_SHOWN 3

/* Pictures of a rig before the first that is wanted whose points are made: a
 * frame in it may be GATHER_OLD pictures old, and as long under way. */
#define RIG_EARLY (3 * (int64_t)GATHER_OLD)

struct decoder {
    struct decoder_options options;
    lum_framer *framer;
    struct gather gather;  /* of a rig */
    struct second *second; /* NULL: there is one profile */
    bool has_gone_ahead;   /* it has taken the record that is being pushed */
    bool second_is_first;  /* the second's newest frame came before any other */
    int64_t second_behind; /* else behind this one */
    struct feed_views views; /* that it makes */
    struct picture complete;
    int64_t from; /* frames before it are passed over */
    bool is_skipping;
    bool has_shown; /* the sensor that is shown was heard */
    size_t shown;   /* its index */
    uint32_t address;
    size_t looked_at;     /* sensors */
    lum_packet_kind kind; /* of the record that is being pushed */
    uint64_t bytes;
    struct totals skipped; /* counted while frames were skipped */
    struct totals mark;    /* as of the last start of that */
};

/* --- Opening --- */

static bool open_second(struct decoder *d, lum_framer_options framer)
{
    if (d->options.second_layout == NULL) {
        return true;
    }
    framer.layout = d->options.second_layout;
    framer.projector = d->options.second_projector;
    framer.wants = LUM_WANT_FRAMES;
    d->second = second_new(&framer);
    return d->second != NULL;
}

struct decoder *decoder_new(const struct decoder_options *options)
{
    struct decoder *d = calloc(1, sizeof *d);
    if (d == NULL) {
        return NULL;
    }
    const size_t parts = options->rig != NULL ? options->member_count : 0;
    const bool has_members = options->member_count > 0;
    const lum_framer_options framer = {
        .struct_size = sizeof framer,
        .layout = options->layout,
        .projector = options->projector,
        .wants = LUM_WANT_FRAMES | (parts > 0 ? 0u : LUM_WANT_LINES),
        .only_first = !has_members,
        .has_sensor = options->sensor.is_given && !has_members,
        .sensor = options->sensor.address,
        .port = options->sensor.port,
        .records_are_single = true,
        .sensor_interface = options->sensor.interface,
        .members = options->members,
        .member_count = options->member_count,
        .points_max = FRAME_POINTS_MAX / (parts > 0 ? (uint32_t)parts : 1u)};
    d->options = *options;
    d->gather.members = parts;
    d->from = INT64_MIN;
    d->kind = LUM_PACKET_KINDS;
    if (lum_framer_new(&framer, &d->framer, NULL) != 0 ||
        lum_framer_set_views(d->framer, NULL, 0, NULL) != 0 ||
        !open_second(d, framer)) {
        decoder_free(d);
        return NULL;
    }
    return d;
}

void decoder_free(struct decoder *decoder)
{
    if (decoder == NULL) {
        return;
    }
    picture_drop(&decoder->complete);
    gather_end(&decoder->gather);
    second_free(decoder->second);
    lum_framer_free(decoder->framer);
    free(decoder);
}

static bool has_rig(const struct decoder *d)
{
    return d->options.rig != NULL;
}

/* --- Counters, and what is skipped --- */

/* The sensor that is shown is the first that sent data, or the one of
 * --sensor. */
static void look_for_shown(struct decoder *d)
{
    const lum_demux *demux = lum_framer_demux(d->framer);
    const size_t count = lum_demux_sensor_count(demux);
    for (size_t i = d->looked_at; i < count && !d->has_shown; i++) {
        d->address = lum_demux_address(demux, i);
        d->has_shown = lum_demux_is_requested(demux, i);
        d->shown = i;
    }
    d->looked_at = count;
}

static void add_sensor(const struct decoder *d, size_t sensor,
                       struct totals *out)
{
    lum_demux_counters c = {.struct_size = sizeof c};
    lum_framer_counters lines = {.struct_size = sizeof lines};
    struct totals its = {.received.bytes = 0};
    (void)lum_framer_count(d->framer, sensor, &lines);
    (void)lum_demux_count(lum_framer_demux(d->framer), sensor, &c);
    for (unsigned i = 0; i < LUM_PACKET_KINDS; i++) {
        its.received.packets += c.packets[i];
    }
    its.received.joined = c.joined;
    its.decoded = (struct feed_decoded){
        .points = lines.rising,
        .lost_words = c.assembly.lost_words,
        .lost_lines = c.assembly.lines_skipped + lines.lines_in_pauses +
                      c.assembly.lines_missing_angles + lines.lines_late +
                      lines.lines_cut,
        .joined_words = lines.under_way.words,
        .joined_lines = lines.under_way.lines,
        .pauses = lines.pauses,
        .refused = lum_framer_refused(&c, &lines)};
    totals_add(out, &its);
}

static bool is_shown(const struct decoder *d, size_t sensor)
{
    return has_rig(d) ? lum_framer_member(d->framer, sensor) >= 0
                      : d->has_shown && sensor == d->shown;
}

/* All counters so far, including skipped frames. */
static void count_all(const struct decoder *d, struct totals *out)
{
    const size_t count = lum_demux_sensor_count(lum_framer_demux(d->framer));
    *out = (struct totals){.received.bytes = d->bytes};
    for (size_t i = 0; i < count; i++) {
        if (is_shown(d, i)) {
            add_sensor(d, i, out);
        }
    }
}

/* Points of skipped frames were not counted, except those of a line that ends
 * the skipping. Of a rig all are. */
static void end_skipping(struct decoder *d)
{
    struct totals now;
    if (!d->is_skipping) {
        return;
    }
    d->is_skipping = false;
    count_all(d, &now);
    if (!has_rig(d)) {
        now.decoded.points = d->mark.decoded.points;
    }
    totals_add(&d->skipped, &now);
    totals_subtract(&d->skipped, &d->mark);
}

/* Of a rig: the next picture is wanted. */
static void leave_skipped(struct decoder *d)
{
    if (d->gather.count >= add_clamped(d->from, -1)) {
        end_skipping(d);
    }
}

void decoder_skip_to(struct decoder *decoder, int64_t frame)
{
    end_skipping(decoder);
    count_all(decoder, &decoder->mark);
    decoder->is_skipping = true;
    decoder->from = frame;
    picture_drop(&decoder->complete);
    if (has_rig(decoder)) {
        leave_skipped(decoder);
    } else {
        lum_framer_skip_to(decoder->framer, frame);
    }
}

bool decoder_learn(struct decoder *decoder, const struct decoder *from)
{
    return lum_framer_learn_clocks(decoder->framer, from->framer) == 0;
}

void decoder_count(const struct decoder *decoder, struct totals *out)
{
    count_all(decoder, out);
    if (decoder->is_skipping) {
        *out = decoder->mark;
    }
    totals_subtract(out, &decoder->skipped);
}

/* --- What is known --- */

bool decoder_range(const struct decoder *decoder, int64_t *first, int64_t *last)
{
    if (has_rig(decoder)) {
        *first = 1;
        *last = decoder->gather.count;
        return *last > 0;
    }
    return decoder->has_shown &&
           lum_framer_range(decoder->framer, decoder->shown, first, last);
}

lum_framer *decoder_framer(struct decoder *decoder)
{
    return decoder->options.member_count == 0 && decoder->second == NULL
               ? decoder->framer
               : NULL;
}

bool decoder_is_lost(const struct decoder *decoder)
{
    return lum_demux_is_unsure(lum_framer_demux(decoder->framer));
}

struct picture *decoder_picture(struct decoder *decoder)
{
    return &decoder->complete;
}

const char *decoder_others(const struct decoder *decoder,
                           char shown[LUM_SENSOR_NAME_BYTES], char *out,
                           size_t room)
{
    char name[LUM_SENSOR_NAME_BYTES];
    *out = '\0';
    *shown = '\0';
    if (has_rig(decoder)) {
        return out;
    }
    const lum_demux *demux = lum_framer_demux(decoder->framer);
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        (void)lum_demux_name(demux, i, name);
        if (decoder->has_shown && i == decoder->shown) {
            memcpy(shown, name, sizeof name);
        } else if (strlen(out) + 3u + strlen(name) < room) {
            lum_text_list(out, room, ", ", name);
        }
    }
    return out;
}

/* The first member that does not fit; count: all fit. What is no data cannot be
 * told apart where sensors share an address, and makes no sensor known. */
static size_t find_misfit(const struct decoder *d, char *what, size_t room)
{
    const lum_demux *demux = lum_framer_demux(d->framer);
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        lum_demux_counters c = {.struct_size = sizeof c};
        const int member = lum_framer_member(d->framer, i);
        (void)lum_demux_count(demux, i, &c);
        if (member >= 0 && !lum_demux_is_shared(demux, i) &&
            misfit_find(&c, what, room)) {
            return (size_t)member;
        }
    }
    return d->options.member_count;
}

static void tell_rig_doubt(const struct decoder *d,
                           const struct sources *captures)
{
    const lum_rig *rig = d->options.rig;
    char what[160];
    char capture[128];
    char text[FEED_TEXT_BYTES];
    lum_demux_counters total = {.struct_size = sizeof total};
    const size_t member = find_misfit(d, what, sizeof what);
    const bool is_known = member < rig->count;
    (void)lum_demux_total(lum_framer_demux(d->framer), &total);
    if (!is_known && !misfit_find(&total, what, sizeof what)) {
        return;
    }
    (void)snprintf(text, sizeof text,
                   "%s: %s: lumdump %s --sensor %s --infer -o profile.yaml "
                   "finds the layout, for profile: profile.yaml in the rig",
                   is_known ? rig->sensor[member].name : "a sensor of the rig",
                   what, misfit_capture(captures, capture, sizeof capture),
                   is_known ? number_address(rig->sensor[member].address).text
                            : "ADDRESS");
    stage_set_text(d->options.stage, FEED_DOUBT, text);
}

/* To record a sensor, its session must end first. */
void decoder_tell_doubt(const struct decoder *decoder,
                        const struct sources *captures, const char *sensor)
{
    char what[160];
    char capture[128];
    char advice[MISFIT_ADVICE_BYTES + sizeof capture];
    char text[FEED_TEXT_BYTES];
    lum_demux_counters total = {.struct_size = sizeof total};
    if (has_rig(decoder)) {
        tell_rig_doubt(decoder, captures);
        return;
    }
    (void)lum_demux_total(lum_framer_demux(decoder->framer), &total);
    if (!misfit_find(&total, what, sizeof what)) {
        return;
    }
    misfit_advise(sensor,
                  captures != NULL
                      ? misfit_capture(captures, capture, sizeof capture)
                      : NULL,
                  advice, sizeof advice);
    (void)snprintf(text, sizeof text, "%s: %s%s", what,
                   captures != NULL ? "" : "end lumview, then ", advice);
    stage_set_text(decoder->options.stage, FEED_DOUBT, text);
}

uint64_t decoder_late(const struct decoder *decoder, const char **sensor)
{
    const struct gather *g = &decoder->gather;
    *sensor =
        g->late > 0 ? decoder->options.rig->sensor[g->late_member].name : "";
    return g->late;
}

const lum_demux *decoder_demux(const struct decoder *decoder)
{
    return lum_framer_demux(decoder->framer);
}

/* --- Records to frames --- */

static struct feed_views wanted_views(const struct decoder *d)
{
    static const struct feed_views none = {.count = 0};
    return d->options.makes_no_points ? none : stage_views(d->options.stage);
}

static bool is_second_new(const struct decoder *d)
{
    int64_t behind = d->second_behind;
    int64_t last = 0;
    if (d->second_is_first && decoder_range(d, &behind, &last)) {
        behind = add_clamped(behind, -1);
    }
    return d->complete.frame <= add_clamped(behind, SECOND_SHOWN);
}

static enum decoded take_frame(struct decoder *d)
{
    picture_drop(&d->complete);
    picture_take(&d->complete, d->framer);
    if (d->second != NULL && is_second_new(d)) {
        second_join(d->second, &d->complete);
    }
    return DECODED_FRAME;
}

static enum decoded take_event(struct decoder *d, lum_framer_event event)
{
    switch (event) {
    case LUM_FRAMER_FRAME:
        return take_frame(d);
    case LUM_FRAMER_FAILED:
        return DECODED_FAILED;
    case LUM_FRAMER_NONE:
    case LUM_FRAMER_LINE:
    case LUM_FRAMER_FRAME_END:
    default:
        return DECODED_ALL;
    }
}

/* A line that is not passed over ends that. */
static bool is_line(struct decoder *d, lum_framer_event event)
{
    if (event != LUM_FRAMER_LINE) {
        return false;
    }
    end_skipping(d);
    return true;
}

static void count_bytes(struct decoder *d, const lum_record *record)
{
    if (!d->has_shown && !has_rig(d)) {
        look_for_shown(d);
    }
    if (d->kind != LUM_PACKET_KINDS &&
        (has_rig(d) || (d->has_shown && record->source == d->address)) &&
        lum_demux_is_wanted(lum_framer_demux(d->framer))) {
        d->bytes += record->len;
    }
    d->kind = LUM_PACKET_KINDS;
}

/* Frames that are passed over need no points. The second's frames have numbers
 * of their own, so those shortly before the first that is wanted have them. */
static bool passes_over(const struct decoder *d)
{
    int64_t first = 0;
    int64_t last = 0;
    return d->is_skipping && decoder_range(d, &first, &last) &&
           last < add_clamped(d->from, -SECOND_EARLY);
}

/* The second takes each record before, as far as its next frame: then that is
 * there when the first's is complete. */
static bool push_second(struct decoder *d, const lum_record *record)
{
    static const struct feed_views none = {.count = 0};
    if (d->second == NULL || d->has_gone_ahead) {
        return true;
    }
    const enum decoded decoded =
        second_push(d->second, record, passes_over(d) ? &none : &d->views);
    d->has_gone_ahead = decoded == DECODED_ALL;
    if (decoded == DECODED_FRAME) {
        int64_t first = 0;
        d->second_is_first = !decoder_range(d, &first, &d->second_behind);
    }
    return decoded != DECODED_FAILED;
}

/* The first has taken a record: so does the second. */
static bool end_record(struct decoder *d, const lum_record *record)
{
    bool goes_on = true;
    while (goes_on && d->second != NULL && !d->has_gone_ahead) {
        goes_on = push_second(d, record);
    }
    d->has_gone_ahead = false;
    return goes_on;
}

/* --- Records to pictures of a rig --- */

/* Those that are skipped are made all the same, as each counts. */
static bool take_picture(struct decoder *d, bool is_end)
{
    picture_drop(&d->complete);
    while (gather_take(&d->gather, is_end, &d->complete)) {
        if (d->complete.frame >= d->from) {
            return true;
        }
        leave_skipped(d);
        picture_drop(&d->complete);
    }
    return false;
}

static void put_frame(struct decoder *d)
{
    struct picture picture;
    const int member =
        lum_framer_member(d->framer, lum_framer_sensor(d->framer));
    picture_take(&picture, d->framer);
    gather_put(&d->gather, member >= 0 ? (size_t)member : 0, &picture);
}

static bool follow_views(struct decoder *d)
{
    static const struct feed_views none = {.count = 0};
    const struct feed_views wanted = wanted_views(d);
    const bool has_points = d->gather.count >= add_clamped(d->from, -RIG_EARLY);
    return views_follow(d->framer, &d->views, has_points ? &wanted : &none);
}

/* record: NULL at the end of the source. */
static enum decoded push_rig(struct decoder *d, const lum_record *record)
{
    lum_framer_event event = LUM_FRAMER_FRAME;
    while (event == LUM_FRAMER_FRAME) {
        if (take_picture(d, false)) {
            return DECODED_FRAME;
        }
        if (!follow_views(d)) {
            return DECODED_FAILED;
        }
        event = record != NULL ? lum_framer_push(d->framer, record, &d->kind)
                               : lum_framer_flush(d->framer);
        if (event == LUM_FRAMER_FRAME) {
            put_frame(d);
        }
    }
    if (event != LUM_FRAMER_NONE) {
        return DECODED_FAILED;
    }
    if (record != NULL) {
        count_bytes(d, record);
        return DECODED_ALL;
    }
    return take_picture(d, true) ? DECODED_FRAME : DECODED_ALL;
}

/* --- Records --- */

void decoder_set_interface(struct decoder *decoder, const char *name)
{
    lum_framer_set_interface(decoder->framer, name);
    if (decoder->second != NULL) {
        second_set_interface(decoder->second, name);
    }
}

enum decoded decoder_push(struct decoder *decoder, const lum_record *record)
{
    if (has_rig(decoder)) {
        return push_rig(decoder, record);
    }
    /* Those that are wanted now are those of the next frame that begins. */
    const struct feed_views wanted = wanted_views(decoder);
    if (!views_follow(decoder->framer, &decoder->views, &wanted) ||
        !push_second(decoder, record)) {
        return DECODED_FAILED;
    }
    lum_framer_event event = LUM_FRAMER_NONE;
    do {
        event = lum_framer_push(decoder->framer, record, &decoder->kind);
    } while (is_line(decoder, event));
    if (event == LUM_FRAMER_NONE) {
        count_bytes(decoder, record);
        if (!end_record(decoder, record)) {
            return DECODED_FAILED;
        }
    }
    return take_event(decoder, event);
}

enum decoded decoder_flush(struct decoder *decoder)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    if (has_rig(decoder)) {
        return push_rig(decoder, NULL);
    }
    if (!push_second(decoder, NULL)) {
        return DECODED_FAILED;
    }
    do {
        event = lum_framer_flush(decoder->framer);
    } while (is_line(decoder, event));
    return take_event(decoder, event);
}
