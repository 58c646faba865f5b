#include "monitor.h"
#include "report.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Adds to a terminated text of at most size bytes. */
#define ADD(out, size, ...)                                                    \
    (void)snprintf((out) + strlen(out), (size)-strlen(out), __VA_ARGS__)

static bool has_trip(const struct sample *g)
{
    return g->monitor->answers && g->monitor->round_trip_ns > 0;
}

/* Those that came, and that the row does not show otherwise. */
static uint16_t passed(const struct sample *g)
{
    const struct monitor *v = g->monitor;
    const unsigned shown = v->answers && v->has_status ? v->status : 0u;
    return (uint16_t)(v->since & ~shown);
}

/* --- For people --- */

void sample_text(const struct sample *g, char out[SAMPLE_ROW_BYTES])
{
    const struct monitor *v = g->monitor;
    char when[REPORT_UTC_BYTES];
    char line[REPORT_LINE_BYTES];
    char bits[LUM_LASER_BITS_TEXT];
    out[0] = '\0';
    ADD(out, SAMPLE_ROW_BYTES, "%s %s: ", report_utc(g->utc_ns, when),
        g->sensor);
    if (!v->answers || !v->has_status) {
        ADD(out, SAMPLE_ROW_BYTES, "%s",
            v->answers ? "answers, without a status" : "does not answer");
    } else {
        ADD(out, SAMPLE_ROW_BYTES, "%s%s",
            report_line(v->status, g->is_owned, line),
            report_cause(v->status, v->was_up));
    }
    if (has_trip(g)) {
        ADD(out, SAMPLE_ROW_BYTES, ", round trip %.2f ms",
            (double)v->round_trip_ns / 1e6);
    }
    if (g->has_counts) {
        ADD(out, SAMPLE_ROW_BYTES,
            ", %" PRIu64 " packets, %" PRIu64 " words lost",
            g->session.datagrams, g->losses.words_lost);
    }
    if (passed(g) != 0) {
        ADD(out, SAMPLE_ROW_BYTES, "; meanwhile: %s",
            lum_laser_bits_name(passed(g), ", ", bits, sizeof bits));
    }
    ADD(out, SAMPLE_ROW_BYTES, "\n");
}

/* --- JSON --- */

static void put_clock(struct json *json, const struct sample *g)
{
    if (g->has_clock) {
        json_int(json, "clock_us", g->clock.clock_us);
        json_int(json, "offset_ns", g->utc_offset_ns);
        json_int(json, "error_ns", g->clock.error_ns);
        json_uint(json, "restarts", g->clock.resets);
    }
    if (g->has_clock && g->clock.has_drift) {
        json_int(json, "drift_ppb", g->clock.drift_ppb);
        json_int(json, "drift_error_ppb", g->clock.drift_error_ppb);
    }
}

static void put_counts(struct json *json, const struct sample *g)
{
    json_uint(json, "packets", g->session.datagrams);
    json_uint(json, "bytes", g->session.bytes);
    json_uint(json, "kernel_drops", g->session.kernel_drops);
    json_uint(json, "lines", g->losses.lines);
    json_uint(json, "lines_incomplete", g->losses.lines_incomplete);
    json_uint(json, "lines_missing", g->losses.lines_missing);
    json_uint(json, "lost_words", g->losses.words_lost);
    json_uint(json, "refused", g->losses.refused);
}

void sample_json(const struct sample *g, FILE *out)
{
    const struct monitor *v = g->monitor;
    char when[REPORT_UTC_BYTES];
    char bits[LUM_LASER_BITS_TEXT];
    struct json json;
    json_init(&json, out);
    json_open_object(&json, NULL);
    json_text(&json, "time", report_utc(g->utc_ns, when));
    json_text(&json, "sensor", g->sensor);
    json_bool(&json, "answers", v->answers);
    if (g->age_s >= 0.0) {
        json_real(&json, "answer_age_s", g->age_s, 3);
    }
    if (v->answers && v->has_status) {
        report_json(&json, v->status, g->is_owned);
    }
    json_text(&json, "hazards_since",
              v->since == 0
                  ? ""
                  : lum_laser_bits_name(v->since, " ", bits, sizeof bits));
    if (v->answers) {
        report_json_trip(&json, v->round_trip_ns);
    }
    put_clock(&json, g);
    if (g->has_counts) {
        put_counts(&json, g);
    }
    json_close_object(&json);
    json_end(&json);
}

/* --- CSV --- */

const char sample_csv_header[] =
    "time,sensor,answers,answer_age_s,laser,status,hazards,hazards_since,round_"
    "trip_ms,"
    "clock_offset_s,clock_error_s,drift_ppm,packets,bytes,kernel_drops,"
    "lines_incomplete,lines_missing,lost_words\n";

static void add_bits(char out[SAMPLE_ROW_BYTES], uint16_t bits)
{
    char text[LUM_LASER_BITS_TEXT];
    ADD(out, SAMPLE_ROW_BYTES, ",%s",
        bits == 0 ? "" : lum_laser_bits_name(bits, " ", text, sizeof text));
}

#define SECONDS_BYTES 40

/* Seconds of nanoseconds, exactly. */
static const char *seconds_text(int64_t ns, char out[SECONDS_BYTES])
{
    const int64_t whole = ns / INT64_C(1000000000);
    const int64_t part = ns % INT64_C(1000000000);
    (void)snprintf(out, SECONDS_BYTES, "%s%" PRId64 ".%09" PRId64,
                   ns < 0 && whole == 0 ? "-" : "", whole,
                   part < 0 ? -part : part);
    return out;
}

static void add_csv_clock(char out[SAMPLE_ROW_BYTES], const struct sample *g)
{
    char offset[SECONDS_BYTES];
    char error[SECONDS_BYTES];
    if (!g->has_clock) {
        ADD(out, SAMPLE_ROW_BYTES, ",,,");
        return;
    }
    ADD(out, SAMPLE_ROW_BYTES, ",%s,%s", seconds_text(g->utc_offset_ns, offset),
        seconds_text(g->clock.error_ns, error));
    if (g->clock.has_drift) {
        ADD(out, SAMPLE_ROW_BYTES, ",%.3f", (double)g->clock.drift_ppb / 1e3);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",");
    }
}

void sample_csv(const struct sample *g, char out[SAMPLE_ROW_BYTES])
{
    const struct monitor *v = g->monitor;
    const bool has_status = v->answers && v->has_status;
    char when[REPORT_UTC_BYTES];
    out[0] = '\0';
    ADD(out, SAMPLE_ROW_BYTES, "%s,%s,%d,", report_utc(g->utc_ns, when),
        g->sensor, v->answers ? 1 : 0);
    if (g->age_s >= 0.0) {
        ADD(out, SAMPLE_ROW_BYTES, "%.3f", g->age_s);
    }
    if (has_status) {
        ADD(out, SAMPLE_ROW_BYTES, ",%s,%u", lum_laser_status_name(v->status),
            (unsigned)v->status);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",,");
    }
    add_bits(out, has_status ? v->hazards : 0);
    add_bits(out, v->since);
    if (has_trip(g)) {
        ADD(out, SAMPLE_ROW_BYTES, ",%.3f", (double)v->round_trip_ns / 1e6);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",");
    }
    add_csv_clock(out, g);
    if (g->has_counts) {
        ADD(out, SAMPLE_ROW_BYTES,
            ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64
            ",%" PRIu64,
            g->session.datagrams, g->session.bytes, g->session.kernel_drops,
            g->losses.lines_incomplete, g->losses.lines_missing,
            g->losses.words_lost);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",,,,,,");
    }
    ADD(out, SAMPLE_ROW_BYTES, "\n");
}

/* --- Prometheus --- */

/* A metric with one value; value: as text. */
static void add_metric(char out[SAMPLE_PAGE_BYTES], const struct sample *g,
                       const char *name, const char *type, const char *help,
                       const char *value)
{
    ADD(out, SAMPLE_PAGE_BYTES,
        "# HELP lumsdk_%s %s\n# TYPE lumsdk_%s %s\nlumsdk_%s{sensor=\"%s\"} "
        "%s\n",
        name, help, name, type, name, g->sensor, value);
}

static void add_real(char out[SAMPLE_PAGE_BYTES], const struct sample *g,
                     const char *name, const char *help, double value)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%.9g", value);
    add_metric(out, g, name, "gauge", help, text);
}

static void add_whole(char out[SAMPLE_PAGE_BYTES], const struct sample *g,
                      const char *name, const char *help, uint64_t value)
{
    char text[24];
    const char *total = strstr(name, "_total");
    (void)snprintf(text, sizeof text, "%" PRIu64, value);
    add_metric(out, g, name, total != NULL ? "counter" : "gauge", help, text);
}

static void add_status(char out[SAMPLE_PAGE_BYTES], const struct sample *g)
{
    const struct monitor *v = g->monitor;
    add_whole(out, g, "laser_up", "Whether the status shows the laser on.",
              lum_laser_is_on(v->status));
    add_whole(out, g, "hazard", "Whether the status shows a hazard.",
              v->hazards != 0);
    ADD(out, SAMPLE_PAGE_BYTES,
        "# HELP lumsdk_status_bit The bits of the status.\n"
        "# TYPE lumsdk_status_bit gauge\n");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const char *name = lum_laser_bit_name(bit);
        if (name != NULL && *name != '\0') {
            ADD(out, SAMPLE_PAGE_BYTES,
                "lumsdk_status_bit{sensor=\"%s\",bit=\"%s\"} %u\n", g->sensor,
                name, (unsigned)v->status >> bit & 1u);
        }
    }
}

static void add_clock(char out[SAMPLE_PAGE_BYTES], const struct sample *g)
{
    char text[SECONDS_BYTES];
    add_metric(out, g, "clock_offset_seconds", "gauge",
               "UTC at which the sensor's clock was 0.",
               seconds_text(g->utc_offset_ns, text));
    add_real(out, g, "clock_error_seconds",
             "The most by which the offset may be wrong.",
             (double)g->clock.error_ns / 1e9);
    if (g->clock.has_drift) {
        add_real(out, g, "clock_drift_ratio",
                 "By how much this host's clock runs faster than the sensor's.",
                 (double)g->clock.drift_ppb / 1e9);
    }
    add_whole(out, g, "restarts_total",
              "Restarts of the sensor that its clock showed.", g->clock.resets);
}

static void add_counts(char out[SAMPLE_PAGE_BYTES], const struct sample *g)
{
    add_whole(out, g, "packets_total", "Datagrams that came.",
              g->session.datagrams);
    add_whole(out, g, "bytes_total", "Bytes in them.", g->session.bytes);
    add_whole(out, g, "kernel_drops_total",
              "Datagrams that this host's kernel dropped.",
              g->session.kernel_drops);
    add_whole(out, g, "lost_words_total", "Range words lost, at least.",
              g->losses.words_lost);
    add_whole(out, g, "incomplete_lines_total",
              "Lines of which angles are lost.", g->losses.lines_incomplete);
    add_whole(out, g, "missing_lines",
              "Lines of which nothing came; fewer again when they come late.",
              g->losses.lines_missing);
}

void sample_page(const struct sample *g, char out[SAMPLE_PAGE_BYTES])
{
    const struct monitor *v = g->monitor;
    char when[SECONDS_BYTES];
    out[0] = '\0';
    add_whole(out, g, "up", "Whether the sensor answers.", v->answers);
    if (g->age_s >= 0.0) {
        add_real(out, g, "answer_age_seconds",
                 "Time since the last answer, when this was written.",
                 g->age_s);
    }
    if (has_trip(g)) {
        add_real(out, g, "round_trip_seconds", "Of the last request.",
                 (double)v->round_trip_ns / 1e9);
    }
    if (v->answers && v->has_status) {
        add_status(out, g);
    }
    add_whole(out, g, "hazards_total", "Times that a hazard began.",
              v->hazard_count);
    if (v->hazard_utc_ns != 0) {
        add_metric(out, g, "last_hazard_timestamp_seconds", "gauge",
                   "When a hazard was last seen.",
                   seconds_text(v->hazard_utc_ns, when));
    }
    if (v->answers && g->has_clock) {
        add_clock(out, g);
    }
    if (g->has_counts) {
        add_counts(out, g);
    }
}
