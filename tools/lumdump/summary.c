#define _POSIX_C_SOURCE 200809L
#include "summary.h"

#include "../common/number.h"
#include "stream.h"

#include <inttypes.h>
#include <stddef.h>
#include <string.h>

/* A counter by its name in the protocol, as JSON shows it, and in words. */
struct named {
    const char *key;
    const char *meaning;
    uint64_t value;
};

struct part {
    struct named row;
    const char *of; /* the key of a loss */
};

/* Rows of each list: where one has more, this does not compile. */
enum {
    KINDS = 8,
    CONTENT = 7,
    LOSSES = 22,
    UNDER_WAY = 4,
    PARTS = UNDER_WAY + 1,
    LIVE_LOSSES = 4,
    NAMED_MAX = KINDS + CONTENT + LOSSES + PARTS + LIVE_LOSSES + 1
};

/* --- Counting --- */

static lum_framer_counters count_sensor(const struct summary *s, size_t i)
{
    lum_framer_counters c = {.struct_size = sizeof c};
    (void)lum_framer_count(s->framer, i, &c);
    if (s->whole.asked != 0) {
        c.frames = i == s->whole.sensor ? s->whole.frames : 0;
        c.points = i == s->whole.sensor ? s->whole.points : 0;
    }
    return c;
}

/* Rounding below this is not worth a line. */
#define COARSE_NS 10000

/* Whole numbers stand from the lines on, and the rate alone among them. Else
 * this does not compile, and a counter would be in no total. */
#define NUMBERS_AT offsetof(lum_framer_counters, lines)
#define RATE_AT    offsetof(lum_framer_counters, frames_per_second)
typedef char every_number_is_added
    [(sizeof(lum_framer_counters) - NUMBERS_AT) % sizeof(uint64_t) == 0 &&
             (RATE_AT - NUMBERS_AT) % sizeof(uint64_t) == 0 &&
             sizeof(double) == sizeof(uint64_t)
         ? 1
         : -1];

static void add_numbers(lum_framer_counters *to,
                        const lum_framer_counters *more)
{
    for (size_t at = NUMBERS_AT; at < sizeof *to; at += sizeof(uint64_t)) {
        uint64_t sum = 0;
        uint64_t number = 0;
        if (at == RATE_AT) {
            continue;
        }
        memcpy(&sum, (const char *)to + at, sizeof sum);
        memcpy(&number, (const char *)more + at, sizeof number);
        sum += number;
        memcpy((char *)to + at, &sum, sizeof sum);
    }
}

lum_framer_counters summary_count(const struct summary *s)
{
    lum_framer_counters total = {.struct_size = sizeof total};
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        const lum_framer_counters c = count_sensor(s, i);
        add_numbers(&total, &c);
        total.frames_per_second += c.frames_per_second;
    }
    return total;
}

/* --- The lists of counters --- */

static size_t list_kinds(const lum_demux_counters *c, struct named *out)
{
    const uint64_t *k = c->packets;
    const struct named rows[KINDS] = {
        {"data", "data", k[LUM_PACKET_DATA]},
        {"angle_packets", "angle packets", c->angle_packets},
        {"range_packets", "range packets", c->range_packets},
        {"heartbeat", "heartbeat", k[LUM_PACKET_HEARTBEAT]},
        {"set_ip", "set IP", k[LUM_PACKET_SET_IP]},
        {"timestamp", "timestamp", k[LUM_PACKET_TIMESTAMP]},
        {"tlv", "TLV", k[LUM_PACKET_TLV]},
        {"joined", "of all packets: came joined, and were taken apart",
         c->joined},
    };
    for (size_t i = 0; i < KINDS; i++) {
        out[i] = rows[i];
    }
    return KINDS;
}

static size_t list_content(const lum_demux_counters *c,
                           const lum_framer_counters *p, struct named *out)
{
    const struct named rows[CONTENT] = {
        {"frames", "frames", c->assembly.frames},
        {"frames_selected", "of them: --frames selects these", p->frames},
        {"lines", "lines", c->assembly.lines},
        {"lines_blue", "lines of the blue eye", p->lines[LUM_EYE_BLUE]},
        {"lines_green", "lines of the green eye", p->lines[LUM_EYE_GREEN]},
        {"words", "range words, of rising and falling edges",
         c->assembly.words},
        {"points", "points", p->points},
    };
    for (size_t i = 0; i < CONTENT; i++) {
        out[i] = rows[i];
    }
    return CONTENT;
}

/* paused: what `pauses` means. */
static size_t list_losses(const lum_demux_counters *c,
                          const lum_framer_counters *p, const char *paused,
                          struct named *out)
{
    const lum_assembly_counters *a = &c->assembly;
    const uint64_t *k = c->packets;
    const struct named rows[LOSSES] = {
        {"lost_words", "range words lost on the way, at least", a->lost_words},
        {"lines_missing_angles", "lines that lack angles",
         a->lines_missing_angles},
        {"lines_skipped", "line numbers that never came", a->lines_skipped},
        {"lines_missing", "lines that frames lack, as their numbers show",
         p->lines_missing},
        {"lines_in_pauses", "lines missing in pauses, but for lines_skipped",
         p->lines_in_pauses},
        {"pauses", paused, p->pauses},
        {"lines_cut", "lines beyond the most that a frame has", p->lines_cut},
        {"no_angle", "words whose pixel has no angles", p->losses.no_angle},
        {"no_range", "words without a range above zero", p->losses.no_range},
        {"bad_words", "words with an impossible bit or pixel", a->bad_words},
        {"late", "packets of lines already closed", a->late},
        {"duplicate", "packets that came again", a->duplicate},
        {"conflict", "packets that contradict others", a->conflict},
        {"no_room", "packets with more words than a line holds", a->no_room},
        {"stray", "packets far from the stream's clock", a->stray},
        {"out_of_order", "packets too far out of order by their times",
         c->out_of_order},
        {"malformed", "packets with impossible lengths or fields",
         k[LUM_PACKET_MALFORMED]},
        {"unknown_tag", "data packets, neither angles nor ranges",
         k[LUM_PACKET_UNKNOWN_TAG]},
        {"unknown_type", "packets of an unknown type",
         k[LUM_PACKET_UNKNOWN_TYPE]},
        {"cut_short", "datagrams the capture holds in part", c->cut_short},
        {"foreign", "datagrams on the sensor's port without our magic",
         k[LUM_PACKET_FOREIGN]},
        {"other", "records that are not ours", c->other},
    };
    for (size_t i = 0; i < LOSSES; i++) {
        out[i] = rows[i];
    }
    return LOSSES;
}

/* What of the losses is none, as they were under way. */
static size_t list_under_way(const lum_framer_counters *p, struct part *out)
{
    const lum_under_way *u = &p->under_way;
    const struct part parts[UNDER_WAY] = {
        {{"lines_under_way",
          "of lines_missing_angles: cut by the stream's begin or end, not lost",
          u->lines},
         "lines_missing_angles"},
        {{"words_under_way", "of lost_words: the same", u->words},
         "lost_words"},
        {{"no_angle_under_way", "of no_angle: the same", u->no_angle},
         "no_angle"},
        {{"missing_under_way",
          "of lines_missing: of the frames that were cut so",
          p->missing_under_way},
         "lines_missing"},
    };
    for (size_t i = 0; i < UNDER_WAY; i++) {
        out[i] = parts[i];
    }
    return UNDER_WAY;
}

static struct named name_breaks(const lum_framer_counters *p)
{
    return (struct named){"stray_at_breaks",
                          "of stray: they began again after a pause",
                          p->stray_at_breaks};
}

/* All that is none. */
static size_t list_parts(const lum_framer_counters *p, struct part *out)
{
    size_t n = list_under_way(p, out);
    out[n++] = (struct part){name_breaks(p), "stray"};
    return n;
}

static size_t rows_of(const struct part *parts, size_t n, struct named *out)
{
    for (size_t i = 0; i < n; i++) {
        out[i] = parts[i].row;
    }
    return n;
}

static double duration_s(const struct summary *s)
{
    return s->has_time ? (double)(s->last_ns - s->first_ns) * 1e-9 : 0.0;
}

static size_t list_all(const lum_demux_counters *c,
                       const lum_framer_counters *p, struct named *out)
{
    struct part parts[PARTS];
    size_t n = list_kinds(c, out);
    n += list_content(c, p, out + n);
    n += list_losses(c, p, "times that no lines came", out + n);
    n += rows_of(parts, list_parts(p, parts), out + n);
    return n;
}

static double paused_s(const lum_framer_counters *p)
{
    return (double)p->paused_us * 1e-6;
}

/* --- JSON --- */

static void print_members(const lum_demux_counters *c,
                          const lum_framer_counters *p, const char *indent,
                          FILE *out)
{
    struct named rows[NAMED_MAX];
    const size_t n = list_all(c, p, rows);
    for (size_t i = 0; i < n; i++) {
        (void)fprintf(out, "%s\"%s\": %" PRIu64 ",\n", indent, rows[i].key,
                      rows[i].value);
    }
    (void)fprintf(out, "%s\"paused_s\": %.6f\n", indent, paused_s(p));
}

/* Bytes of the UTF-8 character at p; 0 if there is none. Surrogates and
 * overlong forms pass: readers of JSON cope with them. */
static size_t utf8_length(const unsigned char *p)
{
    static const struct {
        unsigned char first;
        unsigned char last;
        size_t length;
    } leads[] = {
        {0x01, 0x7f, 1}, {0xc2, 0xdf, 2}, {0xe0, 0xef, 3}, {0xf0, 0xf4, 4}};
    size_t n = 0;
    for (size_t i = 0; i < sizeof leads / sizeof leads[0]; i++) {
        if (*p >= leads[i].first && *p <= leads[i].last) {
            n = leads[i].length;
        }
    }
    for (size_t i = 1; i < n; i++) {
        if ((p[i] & 0xc0) != 0x80) {
            return 0;
        }
    }
    return n;
}

/* A byte that is not UTF-8 is written as the character of its number. */
static void print_json_text(const char *text, FILE *out)
{
    const unsigned char *p = (const unsigned char *)text;
    (void)fputc('"', out);
    while (*p != '\0') {
        const size_t n = utf8_length(p);
        if (*p == '"' || *p == '\\') {
            (void)fprintf(out, "\\%c", *p);
        } else if (n == 0 || *p < 0x20 || *p == 0x7f) {
            (void)fprintf(out, "\\u%04x", *p);
        } else {
            (void)fwrite(p, 1, n, out);
        }
        p += n > 0 ? n : 1;
    }
    (void)fputc('"', out);
}

static bool is_shown(const struct summary *s, size_t sensor)
{
    return lum_demux_is_requested(lum_framer_demux(s->framer), sensor);
}

/* Where its address does not tell it from another one. */
static void print_json_interface(const lum_demux *demux, size_t sensor,
                                 FILE *out)
{
    char name[LUM_SENSOR_NAME_BYTES];
    if (lum_demux_is_shared(demux, sensor)) {
        (void)fputs("      \"interface\": ", out);
        print_json_text(lum_demux_interface(demux, sensor), out);
        (void)fputs(",\n      \"name\": ", out);
        print_json_text(lum_demux_name(demux, sensor, name), out);
        (void)fputs(",\n", out);
    }
}

/* False: there is no clock, or no line yet. */
static bool find_clock(const struct summary *s, size_t sensor,
                       lum_clock_fit_info *out)
{
    const lum_clock_fit *clock = lum_framer_clock(s->framer, sensor);
    out->struct_size = sizeof *out;
    return clock != NULL && lum_clock_fit_get_info(clock, out) == LUM_OK;
}

lum_clock_fit_info summary_count_clocks(const struct summary *s)
{
    const size_t n = lum_demux_sensor_count(lum_framer_demux(s->framer));
    lum_clock_fit_info total = {.struct_size = sizeof total};
    for (size_t i = 0; i < n; i++) {
        lum_clock_fit_info clock;
        if (find_clock(s, i, &clock)) {
            total.sensor_breaks += clock.sensor_breaks;
            total.host_steps += clock.host_steps;
            total.still += clock.still;
        }
    }
    return total;
}

static void print_clock_counts(const lum_clock_fit_info *clock, FILE *out)
{
    (void)fprintf(out,
                  "\"sensor_breaks\": %" PRIu64 ", \"host_steps\": %" PRIu64
                  ", \"stamps_still\": %" PRIu64,
                  clock->sensor_breaks, clock->host_steps, clock->still);
}

static void print_json_clock(const struct summary *s, size_t sensor, FILE *out)
{
    lum_clock_fit_info clock;
    if (!find_clock(s, sensor, &clock)) {
        return;
    }
    (void)fputs("      \"clock\": {", out);
    if (clock.has_drift) {
        (void)fprintf(out, "\"drift_ppm\": %.3f, \"drift_error_ppm\": %.3f, ",
                      clock.drift_ppb * 1e-3, clock.drift_error_ppb * 1e-3);
    }
    if (clock.error_ns == LUM_CLOCK_ERROR_UNKNOWN) {
        (void)fputs("\"utc_error_us\": null, ", out);
    } else {
        (void)fprintf(out, "\"utc_error_us\": %.1f, ",
                      (double)clock.error_ns * 1e-3);
    }
    (void)fprintf(out, "\"stamp_resolution_us\": %.1f, ",
                  (double)clock.resolution_ns * 1e-3);
    print_clock_counts(&clock, out);
    (void)fputs("},\n", out);
}

static void print_json_sensors(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const size_t n = lum_demux_sensor_count(demux);
    bool is_first = true;
    (void)fputs("  \"sensors\": [", out);
    for (size_t i = 0; i < n; i++) {
        lum_demux_counters counters = {.struct_size = sizeof counters};
        char address[16];
        if (!is_shown(s, i)) {
            continue;
        }
        (void)fprintf(
            out, "%s\n    {\n      \"address\": \"%s\",\n", is_first ? "" : ",",
            number_format_address(lum_demux_address(demux, i), address));
        print_json_interface(demux, i, out);
        const lum_framer_counters points = count_sensor(s, i);
        print_json_clock(s, i, out);
        lum_demux_count(demux, i, &counters);
        print_members(&counters, &points, "      ", out);
        (void)fputs("    }", out);
        is_first = false;
    }
    (void)fputs(is_first ? "],\n" : "\n  ],\n", out);
}

static void print_json_output(const struct live_output *o, FILE *out)
{
    (void)fputs("    {\"name\": ", out);
    print_json_text(o->name, out);
    (void)fprintf(out,
                  ", \"end\": \"%s\", \"datagrams\": %" PRIu64
                  ", \"dropped\": %" PRIu64,
                  o->end, o->datagrams, o->dropped);
    if (o->has_ended_early) {
        (void)fprintf(out, ", \"ended_s\": %.3f", o->seconds);
    }
    if (*o->error != '\0') {
        (void)fputs(", \"error\": ", out);
        print_json_text(o->error, out);
    }
    (void)fputc('}', out);
}

static void print_json_outputs(const struct live_counts *c, FILE *out)
{
    (void)fputs("  \"outputs\": [", out);
    for (size_t i = 0; i < c->output_count; i++) {
        (void)fputs(i > 0 ? ",\n" : "\n", out);
        print_json_output(&c->outputs[i], out);
    }
    (void)fputs(c->output_count > 0 ? "\n  ],\n" : "],\n", out);
}

static void print_json_live(const struct live_counts *c, FILE *out)
{
    const struct named rows[] = {
        {"received", "", c->received},
        {"kernel_drops", "", c->kernel_drops},
        {"ring_drops", "", c->ring_drops},
        {"recording_drops", "", c->recording_drops},
        {"foreign_source", "", c->foreign_source},
        {"heartbeats_sent", "", c->heartbeats_sent},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        (void)fprintf(out, "  \"%s\": %" PRIu64 ",\n", rows[i].key,
                      rows[i].value);
    }
    (void)fprintf(out, "  \"kernel_drops_at_least\": %s,\n",
                  c->kernel_drops_at_least ? "true" : "false");
    (void)fprintf(out,
                  "  \"silent_s\": %.3f,\n  \"seconds\": %.6f,\n"
                  "  \"laser\": \"%s\",\n  \"dark_s\": %.3f,\n",
                  c->silent_s, c->seconds, c->laser, c->dark_s);
    print_json_outputs(c, out);
}

static void print_json_left_out(const struct summary *s, FILE *out)
{
    (void)fputs("  \"left_out\": [", out);
    for (size_t i = 0; i < s->left_out_count; i++) {
        const struct left_out *l = &s->left_out[i];
        (void)fputs(i > 0 ? ",\n    {\"output\": " : "\n    {\"output\": ",
                    out);
        print_json_text(output_title(l->name), out);
        (void)fprintf(out,
                      ", \"late\": %" PRIu64 ", \"cut\": %" PRIu64
                      ", \"no_place\": %" PRIu64 "}",
                      l->late, l->cut, l->no_place);
    }
    (void)fputs(s->left_out_count > 0 ? "\n  ],\n" : "],\n", out);
}

static void print_json_drawn(const struct summary *s, FILE *out)
{
    for (size_t i = 0; i < s->drawn_count; i++) {
        const struct drawn *d = &s->drawn[i];
        (void)fputs(i > 0 ? ",\n    {\"output\": "
                          : "  \"pictures\": [\n    {\"output\": ",
                    out);
        print_json_text(output_title(d->name), out);
        (void)fprintf(out,
                      ", \"frames\": %" PRIu64 ", \"files\": %" PRIu64
                      ", \"points\": %" PRIu64,
                      d->frames, d->files, d->points);
        if (d->frames > 0) {
            (void)fprintf(out, ", \"first\": %" PRId64 ", \"last\": %" PRId64,
                          d->first, d->last);
        }
        if (d->frames == 1) {
            (void)fprintf(out, ", \"is_whole\": %s",
                          d->is_whole ? "true" : "false");
        }
        (void)fprintf(out, ", \"others\": %" PRIu64 "}", d->others);
    }
    (void)fputs(s->drawn_count > 0 ? "\n  ],\n" : "", out);
}

static void print_json_retention(const struct retention_counts *counts,
                                 FILE *out)
{
    if (counts->is_used) {
        (void)fprintf(out,
                      "  \"kept_removed\": %" PRIu64
                      ",\n  \"kept_stuck\": %" PRIu64 ",\n",
                      counts->removed, counts->stuck);
    }
}

uint64_t summary_damaged(const struct summary *s, lum_error *why)
{
    return s->capture != NULL ? lum_capture_damaged(s->capture, why) : 0;
}

void summary_print_json(const struct summary *s, FILE *out)
{
    const lum_framer_counters points = summary_count(s);
    const lum_clock_fit_info clocks = summary_count_clocks(s);
    const double seconds = duration_s(s);
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_demux_total(lum_framer_demux(s->framer), &total);
    (void)fputs("{\n  \"source\": ", out);
    print_json_text(s->source, out);
    (void)fprintf(out,
                  ",\n  \"truncated\": %s,\n  \"damaged\": %" PRIu64
                  ",\n  \"records\": %" PRIu64 ",\n  \"duration_s\": %.6f,\n",
                  s->truncated ? "true" : "false", summary_damaged(s, NULL),
                  s->records, seconds);
    if (s->capture != NULL) {
        stream_print_json(s->capture, print_json_text, out);
    }
    if (seconds > 0.0) {
        (void)fprintf(out, "  \"points_per_second\": %.1f,\n",
                      (double)points.points / seconds);
    }
    if (points.frames_per_second > 0.0) {
        (void)fprintf(out, "  \"frames_per_second\": %.3f,\n",
                      points.frames_per_second);
    }
    if (s->live != NULL) {
        print_json_live(s->live, out);
    }
    print_json_left_out(s, out);
    print_json_drawn(s, out);
    print_json_retention(&s->retention, out);
    print_json_sensors(s, out);
    (void)fputs("  ", out);
    print_clock_counts(&clocks, out);
    (void)fputs(",\n", out);
    print_members(&total, &points, "  ", out);
    (void)fputs("}\n", out);
}

/* --- Text --- */

static const char *plural(uint64_t n)
{
    return n == 1 ? "" : "s";
}

/* A name that says all is a noun: one frame, two frames. */
static void print_counter(const char *title, const struct named *row, FILE *out)
{
    const size_t len = strlen(row->key);
    const bool is_one = row->value == 1 && row->key[len - 1u] == 's';
    (void)fprintf(out, "%-10s %14" PRIu64 "  ", title, row->value);
    if (strcmp(row->key, row->meaning) != 0) {
        (void)fprintf(out, "%-21s %s\n", row->key, row->meaning);
    } else {
        (void)fprintf(out, "%.*s\n", (int)(is_one ? len - 1u : len), row->key);
    }
}

static void print_nonzero(const char *title, const struct named *rows, size_t n,
                          FILE *out)
{
    for (size_t i = 0; i < n; i++) {
        if (rows[i].value != 0) {
            print_counter(title, &rows[i], out);
            title = "";
        }
    }
}

static void print_sensors(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const size_t n = lum_demux_sensor_count(demux);
    const char *title = "sensor";
    for (size_t i = 0; i < n; i++) {
        lum_demux_counters counters = {.struct_size = sizeof counters};
        char name[LUM_SENSOR_NAME_BYTES];
        (void)fprintf(
            out, "%-10s %14s%s\n", title, lum_demux_name(demux, i, name),
            is_shown(s, i) ? "" : "  left out: another was asked for");
        title = "";
        if (n > 1 && is_shown(s, i)) {
            lum_demux_count(demux, i, &counters);
            const lum_assembly_counters *a = &counters.assembly;
            const lum_framer_counters p = count_sensor(s, i);
            char selected[40] = "";
            if (s->has_frames) {
                (void)snprintf(selected, sizeof selected,
                               " (%" PRIu64 " selected)", p.frames);
            }
            (void)fprintf(out,
                          "%-26s %" PRIu64 " line%s, %" PRIu64
                          " frame%s%s, %" PRIu64 " point%s\n",
                          "", a->lines, plural(a->lines), a->frames,
                          plural(a->frames), selected, p.points,
                          plural(p.points));
        }
    }
    if (n == 0) {
        (void)fprintf(out, "%-10s %14s\n", title, "none");
    }
}

static size_t list_live_losses(const struct live_counts *c, struct named *out)
{
    const struct named rows[LIVE_LOSSES] = {
        {"kernel_drops",
         c->kernel_drops_at_least
             ? "datagrams at least: this program was too slow, or they came "
               "damaged"
             : "datagrams: this program was too slow, or they came damaged",
         c->kernel_drops},
        {"ring_drops", "datagrams: this machine was too busy to decode them",
         c->ring_drops},
        {"recording_drops", "datagrams: a recording's disk was too slow",
         c->recording_drops},
        {"foreign_source", "datagrams of others, not taken", c->foreign_source},
    };
    for (size_t i = 0; i < LIVE_LOSSES; i++) {
        out[i] = rows[i];
    }
    return LIVE_LOSSES;
}

/* Those that lack something. */
static void print_outputs(const struct live_counts *c, FILE *out)
{
    const char *title = "outputs";
    for (size_t i = 0; i < c->output_count; i++) {
        const struct live_output *o = &c->outputs[i];
        if (!o->has_ended_early && o->dropped == 0) {
            continue;
        }
        (void)fprintf(out, "%-10s %14s  %s", title, o->end, o->name);
        if (o->has_ended_early) {
            (void)fprintf(out, ", ended after %.1f s", o->seconds);
        }
        (void)fprintf(out, ", %" PRIu64 " datagram%s dropped\n", o->dropped,
                      plural(o->dropped));
        title = "";
    }
}

static void print_live(const struct live_counts *c, FILE *out)
{
    (void)fprintf(out,
                  "%-10s %14.3f  seconds, %" PRIu64 " datagram%s, %" PRIu64
                  " heartbeat%s sent\n",
                  "session", c->seconds, c->received, plural(c->received),
                  c->heartbeats_sent, plural(c->heartbeats_sent));
    if (c->silent_s > 0.0) {
        (void)fprintf(out, "%-10s %14.3f  seconds without data at the end\n",
                      "", c->silent_s);
    }
    (void)fprintf(out, "%-10s %14s\n", "laser", c->laser);
    if (c->dark_s >= 1.0) {
        (void)fprintf(out, "%-10s %14.3f  seconds of data without the laser\n",
                      "", c->dark_s);
    }
    print_outputs(c, out);
}

static void print_clock(const char *title, const lum_clock_fit_info *clock,
                        FILE *out)
{
    const struct named rows[] = {
        {"sensor_breaks", "times the sensor's clock started again",
         clock->sensor_breaks},
        {"host_steps", "times the host's clock was stepped", clock->host_steps},
        {"stamps_still", "lines whose arrival times stood still", clock->still},
    };
    const bool is_known = clock->error_ns != LUM_CLOCK_ERROR_UNKNOWN;
    if (clock->has_drift) {
        (void)fprintf(
            out,
            "%-10s %+14.3f  ppm by which the host's is faster, within "
            "%.3f\n",
            title, clock->drift_ppb * 1e-3, clock->drift_error_ppb * 1e-3);
        title = "";
    }
    if (clock->has_drift && is_known) {
        (void)fprintf(out,
                      "%-10s %14.1f  microseconds that UTC may be off by "
                      "--time utc\n",
                      "", (double)clock->error_ns * 1e-3);
    }
    if (!is_known) {
        (void)fprintf(out, "%-10s %14s  how far UTC may be off by --time utc\n",
                      title, "unknown");
        title = "";
    }
    if (clock->resolution_ns >= COARSE_NS) {
        (void)fprintf(out,
                      "%-10s %14.1f  microseconds that arrival times are "
                      "rounded to\n",
                      title, (double)clock->resolution_ns * 1e-3);
        title = "";
    }
    print_nonzero(title, rows, sizeof rows / sizeof rows[0], out);
}

static void print_clocks(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const size_t n = lum_demux_sensor_count(demux);
    for (size_t i = 0; i < n; i++) {
        lum_clock_fit_info clock;
        char name[LUM_SENSOR_NAME_BYTES];
        if (is_shown(s, i) && find_clock(s, i, &clock)) {
            if (n > 1) {
                (void)fprintf(out, "%-10s %14s\n", "clock",
                              lum_demux_name(demux, i, name));
            }
            print_clock(n > 1 ? "" : "clock", &clock, out);
        }
    }
}

static void print_rates(const struct summary *s,
                        const lum_framer_counters *points, FILE *out)
{
    const double seconds = duration_s(s);
    const double frames = points->frames_per_second;
    if (!(seconds > 0.0)) {
        return;
    }
    (void)fprintf(out, "%-10s %14.3f  seconds of capture\n", "rates", seconds);
    if (frames > 0.0) {
        (void)fprintf(out, "%-10s %14.2f  frames a second, of whole frames\n",
                      "", frames);
    }
    (void)fprintf(out, "%-10s %14.0f  points a second\n", "",
                  (double)points->points / seconds);
}

/* A loss of which all is a part that is none is left out. */
static void leave_out_parts(struct named *losses, size_t n,
                            const lum_framer_counters *points)
{
    struct part parts[PARTS];
    const size_t count = list_parts(points, parts);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < count; k++) {
            if (strcmp(parts[k].of, losses[i].key) == 0 &&
                losses[i].value == parts[k].row.value) {
                losses[i].value = 0;
            }
        }
    }
}

static void print_losses(const struct summary *s, const lum_demux_counters *c,
                         const lum_framer_counters *points, FILE *out)
{
    char paused[64];
    struct named rows[NAMED_MAX];
    (void)snprintf(paused, sizeof paused,
                   "times that no lines came, %.3f s in all", paused_s(points));
    size_t n = list_losses(c, points, paused, rows);
    leave_out_parts(rows, n, points);
    if (points->stray_at_breaks < c->assembly.stray) {
        rows[n++] = name_breaks(points);
    }
    n += s->live != NULL ? list_live_losses(s->live, rows + n) : 0;
    rows[n++] =
        (struct named){"damaged", "parts of the capture that could not be read",
                       summary_damaged(s, NULL)};
    print_nonzero("losses", rows, n, out);
    for (size_t i = 0; i < n; i++) {
        if (rows[i].value != 0) {
            return;
        }
    }
    (void)fprintf(out, "%-10s %14s\n", "losses", "none");
}

static void print_content(const struct summary *s, const lum_demux_counters *c,
                          const lum_framer_counters *points, FILE *out)
{
    struct named rows[CONTENT];
    lum_framer_counters shown = *points;
    if (!s->has_frames) {
        shown.frames = 0; /* all of them */
    }
    print_nonzero("content", rows, list_content(c, &shown, rows), out);
}

static const char *what_one_is(const struct drawn *d)
{
    if (d->is_whole) {
        return d->others > 0 ? ", the first whole one" : "";
    }
    return d->others > 0 ? ", the first with points, as none is whole"
                         : ", which is not whole";
}

const char *summary_drawn(const struct drawn *d, char *out, size_t room)
{
    char others[80] = "";
    if (d->others > 0) {
        (void)snprintf(others, sizeof others,
                       "; %" PRIu64 " other%s not drawn, see --frames",
                       d->others, d->others == 1 ? " is" : "s are");
    }
    if (d->frames == 0) {
        (void)snprintf(out, room, "no frame with points");
    } else if (d->frames == 1) {
        (void)snprintf(out, room, "frame %" PRId64 "%s%s", d->first,
                       what_one_is(d), others);
    } else {
        char where[40] = "over each other";
        if (d->files > 1) {
            (void)snprintf(where, sizeof where, "in %" PRIu64 " pictures",
                           d->files);
        }
        (void)snprintf(out, room,
                       "%" PRIu64 " frames %s, %" PRId64 " to %" PRId64,
                       d->frames, where, d->first, d->last);
    }
    return out;
}

static void print_drawn(const struct summary *s, FILE *out)
{
    char text[200];
    for (size_t i = 0; i < s->drawn_count; i++) {
        (void)fprintf(out, "%-10s %s shows %s\n", i > 0 ? "" : "picture",
                      output_title(s->drawn[i].name),
                      summary_drawn(&s->drawn[i], text, sizeof text));
    }
}

static void print_retention(const struct retention_counts *counts, FILE *out)
{
    if (counts->is_used) {
        (void)fprintf(out, "%-10s %14" PRIu64 "  old files were removed\n",
                      "keep", counts->removed);
    }
    if (counts->stuck > 0) {
        (void)fprintf(out, "%-10s %14" PRIu64 "  could not be removed\n", "",
                      counts->stuck);
    }
}

void summary_print_text(const struct summary *s, FILE *out)
{
    const lum_framer_counters points = summary_count(s);
    struct part parts[PARTS];
    struct named rows[NAMED_MAX];
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_demux_total(lum_framer_demux(s->framer), &total);
    (void)fprintf(out, "%s%s\n", s->source,
                  s->truncated ? " (broken off: see the warning)" : "");
    if (s->capture != NULL) {
        stream_print_text(s->capture, out);
    }
    print_sensors(s, out);
    if (s->live != NULL) {
        print_live(s->live, out);
    }
    print_nonzero("packets", rows, list_kinds(&total, rows), out);
    print_content(s, &total, &points, out);
    print_rates(s, &points, out);
    print_clocks(s, out);
    print_nonzero("under way", rows,
                  rows_of(parts, list_under_way(&points, parts), rows), out);
    print_losses(s, &total, &points, out);
    print_drawn(s, out);
    print_retention(&s->retention, out);
}
