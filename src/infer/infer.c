/* Packets in, the steps of an inference in their order, a profile out. */
#include "lum/infer/infer.h"

#include "base/sized.h"
#include "capture/joined.h"
#include "state.h"

#include "lum/group.h"
#include "lum/wire.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Fewer packets of data, or fewer beginnings of lines, tell too little: a
 * field's bits must differ often enough to be told apart. */
#define DATA_MIN  24u
#define LINES_MIN 6u

struct lum_infer {
    lum_infer_options options;
    lum_infer_store store;
};

int lum_infer_create(const lum_infer_options *options, lum_infer **out,
                     lum_error *error)
{
    lum_infer_options known;
    *out = NULL;
    if (lum_sized_take(&known, sizeof known, options, "the inference's options",
                       "lum_infer_options", error) != 0) {
        return -1;
    }
    const uint32_t max =
        known.packets_max == 0 ? LUM_INFER_PACKETS_MAX : known.packets_max;
    if (max > LUM_INFER_PACKETS_MAX) {
        errno = EINVAL;
        return lum_error_set(error, "packets_max is %u; use at most %u",
                             (unsigned)max, LUM_INFER_PACKETS_MAX);
    }
    lum_infer *infer = calloc(1, sizeof *infer);
    if (infer == NULL || lum_infer_store_init(&infer->store, max) != 0) {
        free(infer);
        return lum_error_set(error, "no memory");
    }
    infer->options = known;
    *out = infer;
    return 0;
}

/* Whether a record is to or from a sensor that is looked at. One that is cut
 * before its ports may be. */
static bool is_ours(const lum_infer *infer, const lum_record *record,
                    uint32_t *sensor)
{
    const lum_infer_options *o = &infer->options;
    const uint16_t port = o->port != 0 ? o->port : (uint16_t)LUM_PORT;
    const bool is_from = record->source_port == port;
    const bool is_cut = record->kind == LUM_RECORD_CUT_SHORT &&
                        record->source_port == 0 &&
                        record->destination_port == 0;
    *sensor = is_from ? record->source : record->destination;
    if (!is_from && record->destination_port != port && !is_cut) {
        return false;
    }
    return !o->has_sensor || *sensor == o->sensor ||
           (is_cut && record->source == o->sensor);
}

/* One datagram, or another record. */
static int push_one(lum_infer *infer, const lum_record *record)
{
    const bool is_cut = record->kind == LUM_RECORD_CUT_SHORT;
    uint32_t sensor = 0;
    if ((!lum_record_is_datagram(record) && !is_cut) ||
        !is_ours(infer, record, &sensor)) {
        infer->store.counts.elsewhere++;
        return lum_infer_store_is_full(&infer->store) ? 0 : 1;
    }
    if (is_cut && !lum_infer_store_is_full(&infer->store)) {
        infer->store.counts.cut_short++;
        return 1;
    }
    return lum_infer_store_add(&infer->store, record, sensor);
}

int lum_infer_push(lum_infer *infer, const lum_record *record, lum_error *error)
{
    lum_joined joined = {.each = 0};
    lum_record one;
    int more = 1;
    while (more >= 0 && lum_joined_next(&joined, record, &one)) {
        more = push_one(infer, &one);
    }
    return more < 0 ? lum_error_set(error, "no memory for the packets") : more;
}

void lum_infer_free(lum_infer *infer)
{
    if (infer != NULL) {
        lum_infer_store_free(&infer->store);
        free(infer);
    }
}

/* --- Which packets are data --- */

/* Sensor by sensor, in the order of their arrival. */
static void sort(const lum_infer_store *store, lum_infer_packets *out)
{
    out->count = 0;
    for (unsigned s = 0; s < store->counts.sensors; s++) {
        for (uint32_t i = 0; i < store->count; i++) {
            if (store->packets[i].sensor == s) {
                out->at[out->count++] = &store->packets[i];
            }
        }
    }
}

static size_t of_type(const lum_infer_state *state, unsigned type,
                      lum_infer_kind kind)
{
    size_t n = 0;
    for (size_t i = 0; i < state->all.count; i++) {
        const lum_infer_packet *p = state->all.at[i];
        n += p->is_reserved_0 && p->bytes[8] == type && p->kind == kind;
    }
    return n;
}

/* The type that most packets of samples have, or the tags as types. */
static void find_type(lum_infer_state *state)
{
    size_t most = 0;
    for (unsigned type = 0; type < 256; type++) {
        const size_t n = of_type(state, type, LUM_INFER_ANGLES) +
                         of_type(state, type, LUM_INFER_RANGES);
        if (n > most) {
            most = n;
            state->type = type;
        }
    }
    const size_t angles = of_type(state, 2, LUM_INFER_ANGLES);
    const size_t ranges = of_type(state, 3, LUM_INFER_RANGES);
    state->is_tag_type = angles > 0 && ranges > 0 && angles + ranges > most &&
                         of_type(state, 2, LUM_INFER_RANGES) * 20 < ranges &&
                         of_type(state, 3, LUM_INFER_ANGLES) * 20 < angles;
}

static bool is_data(const lum_infer_state *state, const lum_infer_packet *p)
{
    const unsigned type = p->bytes[8];
    return p->is_reserved_0 &&
           (state->is_tag_type ? type == 2 || type == 3 : type == state->type);
}

static void choose_data(lum_infer_state *state)
{
    state->data.count = 0;
    state->good.count = 0;
    for (size_t i = 0; i < state->all.count; i++) {
        lum_infer_packet *p = state->all.at[i];
        if (is_data(state, p)) {
            state->data.at[state->data.count++] = p;
            if (p->kind != LUM_INFER_UNKNOWN) {
                state->good.at[state->good.count++] = p;
            }
        }
    }
}

/* --- The profile, and what it explains --- */

/* Fields of the profile that was found. */
static void fill_profile(const lum_infer_state *state, lum_profile *out)
{
    lum_profile_default(out);
    if (!state->is_tag_type) {
        out->data_packet_type = state->type;
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        out->group[f] = state->field[f].field;
    }
    out->samples_at = (uint8_t)state->samples.at;
    out->sample_order =
        state->samples.is_big ? LUM_ORDER_BIG : LUM_ORDER_LITTLE;
    out->angle_order = state->samples.is_el_first ? LUM_ELEVATION_AZIMUTH
                                                  : LUM_AZIMUTH_ELEVATION;
    memcpy(out->eye_values, state->readings.best.eye_value,
           sizeof out->eye_values);
    out->clock_unit_ns = state->clock.unit_ns;
    out->line_span_us = state->line_span_us;
}

/* Whether a packet decodes, and its samples are what the tag says. */
static bool fits(const lum_layout *layout, const lum_infer_packet *p)
{
    lum_group group;
    return lum_group_decode(layout, p->bytes, p->len, &group) == LUM_OK &&
           (p->kind == LUM_INFER_UNKNOWN ||
            (group.tag == LUM_TAG_ANGLES) == (p->kind == LUM_INFER_ANGLES));
}

static uint32_t count_fit(const lum_infer_state *state,
                          const lum_layout *layout)
{
    uint32_t n = 0;
    for (size_t i = 0; i < state->data.count; i++) {
        n += fits(layout, state->data.at[i]);
    }
    return n;
}

/* --- The steps --- */

/* Why there is no profile; of a capture with more packets in part than whole,
 * that comes first. */
LUM_PRINTF(3, 4)
static int none(lum_infer_result *out, lum_infer_verdict verdict,
                const char *format, ...)
{
    const bool is_cut = out->counts.cut_short > out->counts.packets;
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(out->text, sizeof out->text, format, arguments);
    va_end(arguments);
    out->verdict = is_cut ? LUM_INFER_TOO_LITTLE : verdict;
    if (is_cut) {
        (void)snprintf(out->text, sizeof out->text,
                       "%u datagrams are in the capture only in part: record "
                       "whole packets (tcpdump -s 0)",
                       (unsigned)out->counts.cut_short);
    }
    return 1;
}

static int find_group(lum_infer_state *state, lum_infer_result *out)
{
    lum_infer_find_tag(state);
    if (state->field[LUM_FIELD_TAG].field.bytes == 0) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "no field is 2 where samples are angles and 3 where they "
                    "are ranges: there is no tag");
    }
    lum_infer_find_num_samples(state);
    lum_infer_find_first(state);
    if (state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field.bytes == 0) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "no field is 0, 334 and 668 in the packets of angles: "
                    "there is no first_sample_index");
    }
    return 0;
}

/* Packets with samples whose bytes 9 to 11 are not 0. */
static size_t count_reserved(const lum_infer_state *state)
{
    size_t n = 0;
    for (size_t i = 0; i < state->all.count; i++) {
        const lum_infer_packet *p = state->all.at[i];
        n += p->kind != LUM_INFER_UNKNOWN && !p->is_reserved_0;
    }
    return n;
}

static int find_data(lum_infer_state *state, lum_infer_result *out)
{
    find_type(state);
    choose_data(state);
    lum_infer_place_samples(state);
    out->counts.packets = (uint32_t)state->data.count;
    out->counts.other_type = (uint32_t)(state->all.count - state->data.count);
    const size_t reserved = count_reserved(state);
    if (reserved > state->good.count) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "bytes 9 to 11 of %zu packets with samples are not 0",
                    reserved);
    }
    return state->data.count >= DATA_MIN
               ? 0
               : none(out, LUM_INFER_TOO_LITTLE,
                      "there are too few packets of data: record "
                      "at least one whole frame");
}

static int find_samples(lum_infer_state *state, lum_infer_result *out)
{
    out->counts.other_type = (uint32_t)state->all.count;
    if (state->all.count == 0) {
        return none(out, LUM_INFER_TOO_LITTLE,
                    "there are no data packets, perhaps only control packets: "
                    "record while the sensor gets heartbeats");
    }
    if (!lum_infer_find_samples(state)) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "no packet has samples that sweep as angles do, or words "
                    "whose pixels rise with bit 11 clear");
    }
    const int r = find_data(state, out);
    if (r != 0) {
        return r;
    }
    if (state->samples.angles == 0) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "no packet has samples that sweep as angles do");
    }
    if (state->samples.ranges == 0) {
        return none(out, LUM_INFER_TOO_LITTLE,
                    "there are angles, and no words of ranges whose "
                    "pixels rise: record with the laser on");
    }
    return 0;
}

static int find_lines(lum_infer_state *state, lum_infer_result *out)
{
    if (lum_infer_follow_time(state) != 0 || lum_infer_find_lines(state) != 0 ||
        lum_infer_find_clock(state) != 0 ||
        lum_infer_place_one_eye(state) != 0) {
        return -1;
    }
    if (state->readings.lines < LINES_MIN) {
        return none(out, LUM_INFER_TOO_LITTLE,
                    "there are too few lines: record at least one whole frame");
    }
    if (state->field[LUM_FIELD_LINE].field.bytes == 0 ||
        state->field[LUM_FIELD_LINE].share < 0.5) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "no field rises by 1 from line to line: there is no line "
                    "number");
    }
    if (state->field[LUM_FIELD_EYE].field.bytes == 0) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "no field tells the two eyes apart");
    }
    return 0;
}

/* The profile of what was found, if there can be one. */
static int make_profile(lum_infer_state *state, lum_infer_result *out,
                        lum_layout *layout)
{
    unsigned one = 0;
    unsigned two = 0;
    lum_infer_shape(state);
    fill_profile(state, &out->profile);
    if (lum_layout_init(layout, &out->profile, NULL, NULL) == LUM_OK) {
        return 0;
    }
    if (lum_infer_clash(state, &one, &two)) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "%s and %s, as they fit best, overlap in a way that no "
                    "profile can express",
                    lum_infer_name(LUM_INFER_TAG + one),
                    lum_infer_name(LUM_INFER_TAG + two));
    }
    return none(out, LUM_INFER_NOTHING_FITS,
                "no profile can express the reading that fits best");
}

static int solve(lum_infer_state *state, lum_infer_result *out)
{
    lum_layout layout;
    int r = find_samples(state, out);
    r = r == 0 ? find_group(state, out) : r;
    r = r == 0 ? find_lines(state, out) : r;
    r = r == 0 ? make_profile(state, out, &layout) : r;
    if (r != 0) {
        return r;
    }
    out->fit = count_fit(state, &layout);
    if (out->fit * 2 < state->data.count) {
        return none(out, LUM_INFER_NOTHING_FITS,
                    "the best reading explains only %u of %zu packets",
                    (unsigned)out->fit, state->data.count);
    }
    out->has_profile = true;
    lum_infer_report(state, out);
    return 0;
}

int lum_infer_solve(lum_infer *infer, lum_infer_result *out, lum_error *error)
{
    lum_infer_result *result = calloc(1, sizeof *result);
    lum_infer_state *state = calloc(1, sizeof *state);
    const size_t count = infer->store.count;
    lum_infer_packet **lists = calloc(3u * (count + 1u), sizeof(void *));
    int r = -1;
    if (result != NULL && state != NULL && lists != NULL) {
        state->all.at = lists;
        state->data.at = lists + count;
        state->good.at = lists + 2u * count;
        result->struct_size = sizeof *result;
        result->counts = infer->store.counts;
        result->counts.is_full = lum_infer_store_is_full(&infer->store);
        sort(&infer->store, &state->all);
        r = solve(state, result);
    }
    if (r < 0) {
        (void)lum_error_set(error, "no memory to find the layout");
    } else if (!lum_sized_fill(out, result, sizeof *result)) {
        errno = EINVAL;
        r = lum_error_set(error, "struct_size of the result is not set; set "
                                 "it to sizeof(lum_infer_result)");
    }
    free(lists);
    free(state);
    free(result);
    return r;
}
