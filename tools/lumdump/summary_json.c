/* The summary of a run as JSON. */
#include "rig_report.h"
#include "summary.h"

#include "../common/number.h"
#include "../common/source_walk.h"

#include <inttypes.h>

/* --- Values --- */

static void print_number(const char *indent, const char *key, uint64_t value,
                         FILE *out)
{
    (void)fprintf(out, "%s\"%s\": %" PRIu64 ",\n", indent, key, value);
}

static void print_counters(const lum_demux_counters *packets,
                           const lum_framer_counters *frames,
                           const char *indent, FILE *out)
{
    struct summary_rows rows;
    summary_list(packets, frames, &rows);
    for (size_t i = 0; i < rows.count; i++) {
        print_number(indent, rows.list[i].key, rows.list[i].value, out);
    }
    (void)fprintf(out, "%s\"paused_s\": %.6f\n", indent,
                  (double)frames->paused_us * 1e-6);
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
static void print_text(const char *text, FILE *out)
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

/* --- Captures --- */

static void print_source(const struct source_walk *w, FILE *out)
{
    static const char *const ends[] = {[LUM_CAPTURE_UNDER_WAY] = "not reached",
                                       [LUM_CAPTURE_WHOLE] = "whole",
                                       [LUM_CAPTURE_BROKEN] = "broken off",
                                       [LUM_CAPTURE_UNREAD] = "unread"};
    const lum_capture_source *s = &w->source;
    (void)fputs("    {\"name\": ", out);
    print_text(s->name, out);
    (void)fprintf(out,
                  ", \"records\": %" PRIu64 ", \"end\": \"%s\""
                  ", \"damaged\": %" PRIu64,
                  s->records, ends[s->end], s->damaged);
    if (s->records > 0) {
        (void)fprintf(out, ", \"first_s\": %.6f, \"last_s\": %.6f",
                      (double)s->first_ns * 1e-9, (double)s->last_ns * 1e-9);
    }
    if (w->has_before && s->records > 0) {
        (void)fprintf(out, ", \"gap_s\": %.6f", (double)w->gap_ns * 1e-9);
    }
    (void)fputc('}', out);
}

static void print_sources(const lum_capture *capture, FILE *out)
{
    struct source_walk walk = {.capture = capture,
                               .source.struct_size = sizeof walk.source};
    const char *divider = "\n";
    (void)fputs("  \"sources\": [", out);
    while (source_walk_step(&walk)) {
        (void)fputs(divider, out);
        print_source(&walk, out);
        divider = ",\n";
    }
    (void)fputs("\n  ],\n", out);
}

/* --- Sensors --- */

/* Where its address does not tell it from another one. */
static void print_interface(const lum_demux *demux, size_t sensor, FILE *out)
{
    char name[LUM_SENSOR_NAME_BYTES];
    if (lum_demux_is_shared(demux, sensor)) {
        (void)fputs("      \"interface\": ", out);
        print_text(lum_demux_interface(demux, sensor), out);
        (void)fputs(",\n      \"name\": ", out);
        print_text(lum_demux_name(demux, sensor, name), out);
        (void)fputs(",\n", out);
    }
}

static void print_rig_name(const struct summary *s, size_t sensor, FILE *out)
{
    if (s->rig != NULL) {
        (void)fprintf(out, "      \"rig_name\": \"%s\",\n",
                      rig_name_of(s->rig, s->framer, sensor));
    }
}

static void print_missing(const struct summary *s, FILE *out)
{
    const char *divider = "";
    (void)fputs("\"missing\": [", out);
    for (size_t k = 0; k < s->rig->count; k++) {
        if (!rig_has_data(s->rig, s->framer, k)) {
            (void)fprintf(out, "%s\"%s\"", divider,
                          s->rig->sensors[k].of->name);
            divider = ", ";
        }
    }
    (void)fputs("]", out);
}

/* Which sensors the capture and the rig do not have in common. */
static void print_rig(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const char *divider = "";
    if (s->rig == NULL) {
        return;
    }
    (void)fputs("  \"rig\": {\"file\": ", out);
    print_text(s->rig->path, out);
    (void)fputs(", ", out);
    print_missing(s, out);
    (void)fputs(", \"unnamed\": [", out);
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        char name[LUM_SENSOR_NAME_BYTES];
        if (rig_name_of(s->rig, s->framer, i) == NULL) {
            (void)fprintf(out, "%s{\"address\": ", divider);
            print_text(lum_demux_name(demux, i, name), out);
            (void)fprintf(out, ", \"packets\": %" PRIu64 "}",
                          rig_others_packets(&s->others, s->framer, i));
            divider = ", ";
        }
    }
    (void)fputs("]},\n", out);
}

static void print_clock_counts(const lum_clock_fit_info *clock, FILE *out)
{
    (void)fprintf(out,
                  "\"sensor_breaks\": %" PRIu64 ", \"host_steps\": %" PRIu64
                  ", \"stamps_still\": %" PRIu64,
                  clock->sensor_breaks, clock->host_steps, clock->still);
}

static void print_clock(const struct summary *s, size_t sensor, FILE *out)
{
    lum_clock_fit_info clock;
    if (!summary_find_clock(s, sensor, &clock)) {
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

static void print_sensors(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const size_t n = lum_demux_sensor_count(demux);
    bool is_first = true;
    (void)fputs("  \"sensors\": [", out);
    for (size_t i = 0; i < n; i++) {
        lum_demux_counters counters = {.struct_size = sizeof counters};
        if (!lum_demux_is_requested(demux, i)) {
            continue;
        }
        (void)fprintf(out, "%s\n    {\n      \"address\": \"%s\",\n",
                      is_first ? "" : ",",
                      number_address(lum_demux_address(demux, i)).text);
        print_interface(demux, i, out);
        print_rig_name(s, i, out);
        const lum_framer_counters points = summary_count_sensor(s, i);
        print_clock(s, i, out);
        lum_demux_count(demux, i, &counters);
        print_counters(&counters, &points, "      ", out);
        (void)fputs("    }", out);
        is_first = false;
    }
    (void)fputs(is_first ? "],\n" : "\n  ],\n", out);
}

/* --- Outputs --- */

static void print_output(const struct live_output *o, FILE *out)
{
    (void)fputs("    {\"name\": ", out);
    print_text(o->name, out);
    (void)fprintf(out,
                  ", \"end\": \"%s\", \"datagrams\": %" PRIu64
                  ", \"dropped\": %" PRIu64,
                  o->end, o->datagrams, o->dropped);
    if (o->has_ended_early) {
        (void)fprintf(out, ", \"ended_s\": %.3f", o->seconds);
    }
    if (*o->error != '\0') {
        (void)fputs(", \"error\": ", out);
        print_text(o->error, out);
    }
    (void)fputc('}', out);
}

static void print_outputs(const struct live_counts *c, FILE *out)
{
    (void)fputs("  \"outputs\": [", out);
    for (size_t i = 0; i < c->output_count; i++) {
        (void)fputs(i > 0 ? ",\n" : "\n", out);
        print_output(&c->outputs[i], out);
    }
    (void)fputs(c->output_count > 0 ? "\n  ],\n" : "],\n", out);
}

static void print_live(const struct live_counts *c, FILE *out)
{
    print_number("  ", "received", c->received, out);
    print_number("  ", "kernel_drops", c->kernel_drops, out);
    print_number("  ", "ring_drops", c->ring_drops, out);
    print_number("  ", "recording_drops", c->recording_drops, out);
    print_number("  ", "foreign_source", c->foreign_source, out);
    print_number("  ", "heartbeats_sent", c->heartbeats_sent, out);
    (void)fprintf(out, "  \"kernel_drops_at_least\": %s,\n",
                  c->kernel_drops_at_least ? "true" : "false");
    (void)fprintf(out,
                  "  \"silent_s\": %.3f,\n  \"seconds\": %.6f,\n"
                  "  \"laser\": \"%s\",\n  \"dark_s\": %.3f,\n",
                  c->silent_s, c->seconds, c->laser, c->dark_s);
    print_outputs(c, out);
}

static void print_left_out(const struct summary *s, FILE *out)
{
    (void)fputs("  \"left_out\": [", out);
    for (size_t i = 0; i < s->outputs.left_out_count; i++) {
        const struct left_out *l = &s->outputs.left_out[i];
        (void)fputs(i > 0 ? ",\n    {\"output\": " : "\n    {\"output\": ",
                    out);
        print_text(output_title(l->name), out);
        (void)fprintf(out,
                      ", \"late\": %" PRIu64 ", \"cut\": %" PRIu64
                      ", \"no_place\": %" PRIu64 "}",
                      l->late, l->cut, l->no_place);
    }
    (void)fputs(s->outputs.left_out_count > 0 ? "\n  ],\n" : "],\n", out);
}

static void print_moved(const lum_move_counts *c, const double origin[3],
                        FILE *out)
{
    if (c != NULL) {
        (void)fprintf(out,
                      "  \"poses\": {\"points\": %" PRIu64
                      ", \"without\": %" PRIu64 ", \"before\": %" PRIu64
                      ", \"after\": %" PRIu64 ", \"in_gap\": %" PRIu64
                      ", \"no_start\": %" PRIu64 ", \"no_time\": %" PRIu64
                      ", \"origin_m\": [%.0f, %.0f, %.0f]},\n",
                      c->points, lum_move_counts_without(c), c->before,
                      c->after, c->in_gap, c->no_start, c->no_time, origin[0],
                      origin[1], origin[2]);
    }
}

static void print_drawn(const struct summary *s, FILE *out)
{
    for (size_t i = 0; i < s->outputs.drawn_count; i++) {
        const struct drawn *d = &s->outputs.drawn[i];
        (void)fputs(i > 0 ? ",\n    {\"output\": "
                          : "  \"pictures\": [\n    {\"output\": ",
                    out);
        print_text(output_title(d->name), out);
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
    (void)fputs(s->outputs.drawn_count > 0 ? "\n  ],\n" : "", out);
}

static void print_retention(const struct retention_counts *counts, FILE *out)
{
    if (counts->is_used) {
        (void)fprintf(out,
                      "  \"kept_removed\": %" PRIu64
                      ",\n  \"kept_stuck\": %" PRIu64 ",\n",
                      counts->removed, counts->stuck);
    }
}

static void print_voxels(const struct voxel_counts *v, FILE *out)
{
    if (v->size == 0) {
        return;
    }
    (void)fprintf(out, "  \"voxels\": {\"size_m\": %g", v->size);
    const struct {
        const char *key;
        uint64_t value;
    } counts[] = {{"points", v->points},
                  {"voxels", v->voxels},
                  {"without_pose", v->without_pose},
                  {"not_finite", v->not_finite},
                  {"out_of_range", v->out_of_range},
                  {"spooled_bytes", v->spooled}};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        (void)fprintf(out, ", \"%s\": %" PRIu64, counts[i].key,
                      counts[i].value);
    }
    (void)fputs("},\n", out);
}

/* --- The summary --- */

void summary_json_print(const struct summary *s, FILE *out)
{
    const lum_framer_counters points = summary_count(s);
    const lum_clock_fit_info clocks = summary_count_clocks(s);
    const double seconds = summary_seconds(s);
    const lum_demux_counters total = summary_count_packets(s);
    (void)fputs("{\n  \"source\": ", out);
    print_text(s->source, out);
    (void)fprintf(out,
                  ",\n  \"truncated\": %s,\n  \"damaged\": %" PRIu64
                  ",\n  \"records\": %" PRIu64 ",\n  \"duration_s\": %.6f,\n",
                  s->truncated ? "true" : "false", summary_damaged(s, NULL),
                  s->records, seconds);
    if (s->capture != NULL) {
        print_sources(s->capture, out);
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
        print_live(s->live, out);
    }
    print_moved(s->moved, s->origin, out);
    print_left_out(s, out);
    print_drawn(s, out);
    print_voxels(&s->voxels, out);
    print_retention(&s->outputs.retention, out);
    print_rig(s, out);
    print_sensors(s, out);
    (void)fputs("  ", out);
    print_clock_counts(&clocks, out);
    (void)fputs(",\n", out);
    print_counters(&total, &points, "  ", out);
    (void)fputs("}\n", out);
}
