/* The evidence for each key of a profile, the margin, and the verdict. */
#include "base/text.h"
#include "fields.h"
#include "ticks.h"

#include <stdio.h>
#include <string.h>

/* A reading that fits fewer packets, or steps from line to line, is unsure:
 * loss, disorder and corruption spoil fewer. */
#define FIT_MIN  0.8
#define LINE_MIN 0.75

/* Where no field counts samples, packets of angles have 334 or 332 of them at
 * least in this share. */
#define CUT_MIN 0.5

/* With fewer lines, chance bits can pass for an eye or a line number. A header
 * has about 300 bits. Among those that change as they like, one in 2^31 takes
 * turns at all 31 steps of 32 lines; 27 steps, which is what a true eye has
 * left after loss, one of 300 reaches in 1 of 200 captures. With 16 lines
 * it would be in two of three. */
#define LINES_SURE 32u

/* --- Texts --- */

/* Add to a text. */
#define say(out, ...) lum_text_add(out, LUM_INFER_TEXT_BYTES, __VA_ARGS__)

static double percent(double share)
{
    return 100.0 * share;
}

/* --- Fields --- */

/* A field as it stands in a profile. */
static void say_field(char out[LUM_INFER_TEXT_BYTES], lum_field field)
{
    if (field.bytes == 0) {
        say(out, "none");
        return;
    }
    say(out, "{at: %u, bytes: %u%s", (unsigned)field.at, (unsigned)field.bytes,
        field.order == LUM_ORDER_BIG ? ", order: big" : "");
    if (field.bits != 0) {
        say(out, ", bits: [%u, %u]", (unsigned)field.low,
            field.low + field.bits - 1u);
    }
    say(out, "}");
}

/* The share of packets in which two fields have the same value. */
static double share_alike(const lum_infer_state *state, lum_field a,
                          lum_field b)
{
    size_t n = 0;
    for (size_t i = 0; i < state->good.count; i++) {
        const uint8_t *bytes = state->good.at[i]->bytes;
        n += lum_infer_value(bytes, a) == lum_infer_value(bytes, b);
    }
    return state->good.count == 0 ? 0.0 : (double)n / (double)state->good.count;
}

/* Of a field that was widened, or could as well be wider. */
static void say_wider(const lum_infer_state *state, lum_infer_finding *f,
                      lum_field field)
{
    lum_field other = state->narrow[f->key - LUM_INFER_TAG];
    if (other.bytes > 0 || lum_infer_wider(state, field, &other)) {
        say_field(f->equal, other);
        say(f->equal, ", since the further bytes are 0 in %.1f %% of packets",
            percent(share_alike(state, field, other)));
    }
}

/* --- Key by key --- */

static void of_type(const lum_infer_state *state, lum_infer_finding *f)
{
    if (state->is_tag_type) {
        f->is_told = false;
        say(f->value, "8");
        say(f->evidence, "not used: types 2 and 3 are the tags themselves");
        return;
    }
    say(f->value, "%u", state->type);
    say(f->evidence,
        "%zu packets of this type have samples of angles or "
        "ranges, more than of any other",
        state->good.count);
}

/* Of a tag, whose lowest two bits may tell it alone, or whose byte may. */
static void say_lowest(const lum_infer_state *state, lum_infer_finding *f,
                       lum_field field)
{
    lum_field two = field;
    two.bits = 2;
    if (field.bits == 2) {
        say_wider(state, f, field);
        return;
    }
    say_field(f->equal, two);
    say(f->equal, ", since the bits above are 0 in %.1f %% of packets",
        percent(share_alike(state, field, two)));
}

static void of_tag(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_choice *tag = &state->field[LUM_FIELD_TAG];
    if (state->is_tag_type) {
        say(f->evidence,
            "the packets' type is 2 where samples sweep as angles, 3 where "
            "pixels rise as in ranges: %.1f %% of %zu packets",
            percent(tag->share), state->good.count);
        return;
    }
    say(f->evidence,
        "2 where samples sweep as angles, 3 where pixels rise as in ranges: "
        "%.1f %% of %zu packets; the next best field %.1f %%",
        percent(tag->share), state->good.count, percent(tag->second));
    say_lowest(state, f, tag->field);
}

/* Of a field that tells what another one tells too, if no other is said. */
static void say_equal(lum_infer_finding *f, lum_field equal)
{
    if (equal.bytes > 0 && f->equal[0] == '\0') {
        say_field(f->equal, equal);
    }
}

/* What the best reading of other values explains. */
static void say_rival(lum_infer_finding *f, const lum_infer_choice *choice,
                      const char *what)
{
    if (choice->second > 0.0) {
        say(f->evidence, "; the best %s explains %.1f %%", what,
            percent(choice->second));
    } else {
        say(f->evidence, "; there is no %s", what);
    }
}

static void of_eye(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_choice *eye = &state->field[LUM_FIELD_EYE];
    const lum_infer_reading *best = &state->readings.best;
    f->is_told = !best->is_one_eye;
    if (best->is_one_eye) {
        say(f->evidence, "lines rise by 1 and no field tells two eyes apart: "
                         "only one eye is seen");
        say_rival(f, eye, "reading with two eyes");
        say(f->equal, "every other byte that is always the same");
        say(f->look, "record both eyes");
        return;
    }
    say(f->evidence,
        "the values %u and %u alternate in %.1f %% of %zu lines; within "
        "each, lines rise by 1",
        (unsigned)best->eye_value[0], (unsigned)best->eye_value[1],
        percent(eye->share), state->readings.lines);
    say_rival(f, eye, "reading with other eyes");
    say_wider(state, f, eye->field);
    say_equal(f, best->equal_eye);
}

static void of_line(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_choice *line = &state->field[LUM_FIELD_LINE];
    say(f->evidence,
        "rises by 1, or begins again with the elevations, at %.1f %% of %zu "
        "steps from line to line of an eye",
        percent(line->share), state->readings.steps);
    say_rival(f, line, "other number");
    say_wider(state, f, line->field);
    say_equal(f, state->readings.equal_line);
}

static void of_num_samples(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_choice *n = &state->field[LUM_FIELD_NUM_SAMPLES];
    if (n->field.bytes == 0) {
        say(f->evidence,
            "no field times 4, and the %u bytes before the samples, is the "
            "length (best %.1f %%); %.1f %% of lengths are %u + 4 n",
            state->samples.at, percent(n->second),
            percent(state->samples.equal), state->samples.at);
        return;
    }
    say(f->evidence,
        "4 times it, and the %u bytes before the samples, is the length of "
        "%.1f %% of packets; the next best field %.1f %%",
        state->samples.at, percent(n->share), percent(n->second));
    say_wider(state, f, n->field);
    if (f->equal[0] == '\0' && state->samples.equal > 0.97) {
        say(f->equal, "\"none\", since the datagram's length tells the same");
    }
}

static void of_first(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_choice *first = &state->field[LUM_FIELD_FIRST_SAMPLE_INDEX];
    say(f->evidence,
        "0, 334 and 668 of angles; of ranges, 0 or where another packet ended: "
        "%.1f %% of packets; ",
        percent(first->share));
    if (first->rival.bytes > 0) {
        say(f->evidence, "the next best field %.1f %%", percent(first->second));
    } else {
        say(f->evidence, "no other field has all three");
    }
    say_wider(state, f, first->field);
}

/* Of eight bytes, of which only four change, or the other way round. */
static void say_equal_clock(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_field clock = state->field[LUM_FIELD_TIMESTAMP].field;
    say_equal(f, state->clock.equal);
    if (lum_infer_share_bits(state->clock.equal, clock)) {
        say(f->equal,
            ", since the further bytes do not change; a recording of more than "
            "%.1f s shows whether they do",
            4294967296e-9 * (double)state->clock.unit_ns);
    }
}

static void of_clock(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_choice *clock = &state->field[LUM_FIELD_TIMESTAMP];
    f->is_told = state->clock.has_times && state->clock.unread_at == 0;
    if (!state->clock.has_times) {
        say(f->evidence, "the capture has no times of its own; %s",
            clock->field.bytes > 0 ? "the field rises from line to line"
                                   : "no field rises from line to line");
        say(f->look, "record again, with the times of capture");
    } else if (state->clock.unread_at > 0) {
        say(f->evidence,
            "no field rises as the time of capture does; byte %u, which is of "
            "no field, changes from line to line, as a clock does that wraps "
            "between lines",
            state->clock.unread_at);
        say(f->look, "what the sensor's maker says of byte %u",
            state->clock.unread_at);
    } else if (clock->field.bytes == 0) {
        say(f->evidence, "no field rises as the time of capture does");
    } else {
        say(f->evidence, "follows the time of capture; off by %.1f %% of it",
            percent(1.0 - clock->share));
        say_rival(f, clock, "other clock");
    }
    say_wider(state, f, clock->field);
    if (f->equal[0] == '\0') {
        say_equal_clock(state, f);
    }
}

static void of_unit(const lum_infer_state *state, lum_infer_finding *f)
{
    say(f->value, "%u", (unsigned)state->clock.unit_ns);
    f->is_told = state->clock.is_unit_told;
    if (state->clock.tick_ns <= 0.0) {
        say(f->evidence, "there is no clock to measure");
        return;
    }
    if (state->clock.has_times) {
        say(f->evidence,
            "a tick lasts %.6g ns of capture time, measured over %.3f s, half "
            "of it within %.3g %%; %s",
            state->clock.tick_ns, state->clock.span_ns * 1e-9,
            percent(state->clock.spread),
            state->clock.is_unit_told
                ? "taken is a round unit within 2 %, or else what was "
                  "measured"
                : "that varies too much, or the clock is too narrow, to be "
                  "sure");
    } else {
        say(f->evidence, "there are no times of capture to measure it by");
    }
    if (!f->is_told) {
        say(f->look, "infer again from a recording of a second or more, with "
                     "the times that it was captured at");
    }
}

static void of_samples(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_samples *s = &state->samples;
    say(f->value, "%u", s->at);
    say(f->evidence,
        "%.1f %% of angle packets go on smoothly from here on, %.1f %% one "
        "sample before; %.1f %% of them have 334 or 332 samples then",
        percent(s->smooth), percent(s->before), percent(s->cut));
}

static void of_eye_values(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_reading *best = &state->readings.best;
    f->is_told = false;
    say(f->value, "{blue: %u, green: %u}", (unsigned)best->eye_value[0],
        (unsigned)best->eye_value[1]);
    say(f->evidence, "%s",
        best->is_one_eye
            ? "only one eye is seen; its name is not in the packets"
            : "the packets do not say which value is blue: the lower one is "
              "taken, as in the default");
    say(f->equal, "{blue: %u, green: %u}", (unsigned)best->eye_value[1],
        (unsigned)best->eye_value[0]);
    say(f->look,
        "lumview with both profiles side by side: with the right one, blue "
        "looks to the right, and a wall continues from eye to eye");
}

static void of_angle_order(const lum_infer_state *state, lum_infer_finding *f)
{
    say(f->value, "%s",
        state->samples.is_el_first ? "elevation_azimuth" : "azimuth_elevation");
    say(f->evidence,
        "within a line the %s value of a pair sweeps, the other hardly changes",
        state->samples.is_el_first ? "second" : "first");
}

static void of_angle_lsb(const lum_infer_state *state, lum_infer_finding *f)
{
    const lum_infer_samples *s = &state->samples;
    const int az = s->high[0] - s->low[0];
    const int el = s->high[1] - s->low[1];
    f->is_told = false;
    say(f->value, "span");
    say(f->evidence,
        "azimuths reach %d to %d, elevations %d to %d, of -32768 to 32767; "
        "the scale is not in the packets",
        s->low[0], s->high[0], s->low[1], s->high[1]);
    if (az > 0) {
        say(f->equal,
            "%.7f, if azimuths reach over 60 degrees; elevations "
            "then reach over %.1f degrees",
            60.0 / az, 60.0 * el / az);
    }
    say(f->look, "lumview on a recording of a straight wall that passes from "
                 "eye to eye: with the right scale it is straight");
}

static void of_sample_order(const lum_infer_state *state, lum_infer_finding *f)
{
    say(f->value, "%s", state->samples.is_big ? "big" : "little");
    say(f->evidence,
        "%zu packets sweep and %zu rise by pixel when read so; the other order "
        "breaks them",
        state->samples.angles, state->samples.ranges);
}

static void of_line_span(const lum_infer_state *state, lum_infer_finding *f)
{
    say(f->value, "%u", (unsigned)state->line_span_us);
    f->is_told = state->clock.is_unit_told;
    if (state->field[LUM_FIELD_TIMESTAMP].field.bytes == 0) {
        say(f->evidence, "there is no clock to measure lines by");
    } else if (2.0 * state->line_us >= LUM_INFER_GAP_US) {
        say(f->evidence,
            "nine of ten lines last up to %.0f us by the sensor's clock; "
            "lines must last less than %.0f us to be put together",
            state->line_us, LUM_INFER_GAP_US);
    } else {
        say(f->evidence,
            "nine of ten lines last up to %.0f us by the sensor's clock%s",
            state->line_us,
            state->clock.is_unit_told ? "" : ", whose unit is not known");
    }
}

/* --- All keys --- */

static const struct {
    const char *name;
    void (*find)(const lum_infer_state *, lum_infer_finding *);
} keys[LUM_INFER_KEYS] = {
    [LUM_INFER_DATA_PACKET_TYPE] = {"data_packet_type", of_type},
    [LUM_INFER_TAG] = {"group.tag", of_tag},
    [LUM_INFER_EYE] = {"group.eye", of_eye},
    [LUM_INFER_LINE] = {"group.line", of_line},
    [LUM_INFER_NUM_SAMPLES] = {"group.num_samples", of_num_samples},
    [LUM_INFER_FIRST_SAMPLE_INDEX] = {"group.first_sample_index", of_first},
    [LUM_INFER_TIMESTAMP] = {"group.timestamp", of_clock},
    [LUM_INFER_CLOCK_UNIT] = {"group.timestamp.unit_ns", of_unit},
    [LUM_INFER_SAMPLES] = {"group.samples", of_samples},
    [LUM_INFER_EYE_VALUES] = {"eye_values", of_eye_values},
    [LUM_INFER_ANGLE_ORDER] = {"angle_order", of_angle_order},
    [LUM_INFER_ANGLE_LSB] = {"angle_lsb_deg", of_angle_lsb},
    [LUM_INFER_SAMPLE_ORDER] = {"sample_order", of_sample_order},
    [LUM_INFER_LINE_SPAN] = {"line_span_us", of_line_span}};

const char *lum_infer_name(unsigned key)
{
    return keys[key].name;
}

static void find_all(const lum_infer_state *state, lum_infer_result *out)
{
    for (unsigned key = 0; key < LUM_INFER_KEYS; key++) {
        lum_infer_finding *f = &out->findings[key];
        f->key = (lum_infer_key)key;
        f->name = keys[key].name;
        f->is_told = true;
        if (key >= LUM_INFER_TAG && key <= LUM_INFER_TIMESTAMP) {
            say_field(f->value, state->field[key - LUM_INFER_TAG].field);
        }
        keys[key].find(state, f);
    }
    out->finding_count = LUM_INFER_KEYS;
}

/* --- How sure it is --- */

/* How much more a key's value explains than the best other one. */
static double lead(const lum_infer_state *state, lum_infer_key key)
{
    const lum_infer_samples *s = &state->samples;
    if (key == LUM_INFER_SAMPLES) {
        return s->smooth - s->before;
    }
    const lum_infer_choice *c = &state->field[key - LUM_INFER_TAG];
    if (key == LUM_INFER_LINE || key == LUM_INFER_EYE) {
        /* Rivals are whole readings too. */
        return state->readings.best.share - c->second;
    }
    if (key == LUM_INFER_NUM_SAMPLES && c->field.bytes == 0) {
        return s->equal - c->second;
    }
    return c->field.bytes == 0 ? 1.0 : c->share - c->second;
}

/* The key that leads by least, and by how much. */
static double nearest(const lum_infer_state *state, lum_infer_key *which)
{
    double least = 1.0;
    *which = LUM_INFER_TAG;
    for (lum_infer_key key = LUM_INFER_TAG; key <= LUM_INFER_SAMPLES; key++) {
        const double now = key == LUM_INFER_CLOCK_UNIT ? 1.0 : lead(state, key);
        if (now < least) {
            least = now;
            *which = key;
        }
    }
    return least < 0.0 ? 0.0 : percent(least);
}

/* The best reading that gives other points. */
static void find_second(const lum_infer_state *state, lum_infer_result *out)
{
    lum_layout layout;
    if (out->margin_key != LUM_INFER_SAMPLES) {
        lum_infer_second(state, out->margin_key - LUM_INFER_TAG, out);
        return;
    }
    out->second = out->profile;
    out->second.samples_at = (uint8_t)(out->second.samples_at - 4u);
    out->has_second =
        state->samples.before > 0.0 &&
        lum_layout_init(&layout, &out->second, NULL, NULL) == LUM_OK;
}

/* 1, 2 or 5 times a power of ten. */
static bool is_round(uint32_t unit_ns)
{
    while (unit_ns % 10 == 0 && unit_ns > 0) {
        unit_ns /= 10;
    }
    return unit_ns == 1 || unit_ns == 2 || unit_ns == 5;
}

/* A narrow clock that wraps between lines, with a byte of anything below it,
 * follows time too. */
static bool has_odd_clock(const lum_infer_state *state)
{
    const lum_field clock = state->field[LUM_FIELD_TIMESTAMP].field;
    return state->clock.has_times && !state->clock.is_unit_told &&
           clock.bytes > 0 && lum_infer_width(clock) <= 16 &&
           !is_round(state->clock.unit_ns);
}

/* Why a reading is unsure; empty, as at first: it is not. */
static void find_doubt(const lum_infer_state *state,
                       const lum_infer_result *out,
                       char doubt[LUM_INFER_TEXT_BYTES])
{
    const double line = state->field[LUM_FIELD_LINE].share;
    if (state->field[LUM_FIELD_NUM_SAMPLES].field.bytes == 0 &&
        state->samples.cut < CUT_MIN) {
        say(doubt, "nothing confirms where samples begin");
    } else if (out->margin < LUM_INFER_MARGIN_SURE) {
        say(doubt, "another reading explains about as much");
    } else if ((double)out->fit < FIT_MIN * (double)out->counts.packets) {
        say(doubt, "%u packets do not fit",
            (unsigned)(out->counts.packets - out->fit));
    } else if (line < LINE_MIN) {
        say(doubt, "the line number rises at only %.1f %% of lines",
            percent(line));
    } else if (state->readings.lines < LINES_SURE) {
        say(doubt, "%zu lines are too few to be sure: record %u or more",
            state->readings.lines, LINES_SURE);
    } else if (state->clock.unread_at > 0) {
        say(doubt, "byte %u may be a clock", state->clock.unread_at);
    } else if (has_odd_clock(state)) {
        say(doubt, "the clock's ticks are of no round length, and it may wrap "
                   "between lines");
    }
}

static void judge(const lum_infer_state *state, lum_infer_result *out)
{
    char doubt[LUM_INFER_TEXT_BYTES] = "";
    out->margin = nearest(state, &out->margin_key);
    find_second(state, out);
    find_doubt(state, out, doubt);
    out->verdict = doubt[0] == '\0' ? LUM_INFER_FOUND : LUM_INFER_UNSURE;
    (void)snprintf(
        out->text, sizeof out->text,
        "%u of %u packets fit; margin %.1f points, of %s%s%s%s",
        (unsigned)out->fit, (unsigned)out->counts.packets, out->margin,
        keys[out->margin_key].name, doubt[0] == '\0' ? "" : "; unsure: ", doubt,
        state->readings.best.is_one_eye
            ? "; only one eye is seen, so the place of group.eye is unknown"
            : "");
}

void lum_infer_report(const lum_infer_state *state, lum_infer_result *out)
{
    find_all(state, out);
    judge(state, out);
}
