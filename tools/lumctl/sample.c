/* A row of what is known of a sensor: text, JSON, CSV, Prometheus' page. */
#include "monitor.h"
#include "status_report.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Adds to a terminated text of at most size bytes. */
#define ADD(out, size, ...)                                                    \
    (void)snprintf((out) + strlen(out), (size)-strlen(out), __VA_ARGS__)

static bool has_trip(const struct sample *s)
{
    return s->monitor->answers && s->monitor->round_trip_ns > 0;
}

/* Those that came, and that the row does not show otherwise. */
static uint16_t passed(const struct sample *s)
{
    const struct monitor *m = s->monitor;
    const unsigned shown = m->answers && m->has_status ? m->status : 0u;
    return (uint16_t)(m->hazards.since & ~shown);
}

/* --- For people --- */

void sample_text(const struct sample *s, char out[SAMPLE_ROW_BYTES])
{
    const struct monitor *m = s->monitor;
    char bits[LUM_LASER_BITS_TEXT];
    out[0] = '\0';
    ADD(out, SAMPLE_ROW_BYTES, "%s %s: ", report_utc(s->utc_ns).text,
        s->sensor);
    if (!m->answers || !m->has_status) {
        ADD(out, SAMPLE_ROW_BYTES, "%s",
            m->answers ? "answers, without a status" : "does not answer");
    } else {
        ADD(out, SAMPLE_ROW_BYTES, "%s%s",
            report_line(m->status, s->is_owned).text,
            report_cause(m->status, m->was_up));
    }
    if (has_trip(s)) {
        ADD(out, SAMPLE_ROW_BYTES, ", round trip %.2f ms",
            (double)m->round_trip_ns / 1e6);
    }
    if (s->has_counts) {
        ADD(out, SAMPLE_ROW_BYTES,
            ", %" PRIu64 " packets, %" PRIu64 " words lost",
            s->session.datagrams, s->losses.words_lost);
    }
    if (passed(s) != 0) {
        ADD(out, SAMPLE_ROW_BYTES, "; meanwhile: %s",
            lum_laser_bits_name(passed(s), ", ", bits, sizeof bits));
    }
    ADD(out, SAMPLE_ROW_BYTES, "\n");
}

/* --- JSON --- */

static void put_clock(struct json *json, const struct sample *s)
{
    if (s->has_clock) {
        json_int(json, "clock_us", s->clock.clock_us);
        json_int(json, "offset_ns", s->utc_offset_ns);
        json_int(json, "error_ns", s->clock.error_ns);
        json_uint(json, "restarts", s->clock.resets);
    }
    if (s->has_clock && s->clock.has_drift) {
        json_int(json, "drift_ppb", s->clock.drift_ppb);
        json_int(json, "drift_error_ppb", s->clock.drift_error_ppb);
    }
}

static void put_counts(struct json *json, const struct sample *s)
{
    json_uint(json, "packets", s->session.datagrams);
    json_uint(json, "bytes", s->session.bytes);
    json_uint(json, "kernel_drops", s->session.kernel_drops);
    json_uint(json, "lines", s->losses.lines);
    json_uint(json, "lines_incomplete", s->losses.lines_incomplete);
    json_uint(json, "lines_missing", s->losses.lines_missing);
    json_uint(json, "lost_words", s->losses.words_lost);
    json_uint(json, "refused", s->losses.refused);
}

void sample_json(const struct sample *s, FILE *out)
{
    const struct monitor *m = s->monitor;
    char bits[LUM_LASER_BITS_TEXT];
    struct json json;
    json_begin_line(&json, out);
    json_text(&json, "time", report_utc(s->utc_ns).text);
    json_text(&json, "sensor", s->sensor);
    json_bool(&json, "answers", m->answers);
    if (s->age_s >= 0.0) {
        json_real(&json, "answer_age_s", s->age_s, 3);
    }
    if (m->answers && m->has_status) {
        report_json(&json, m->status, s->is_owned);
    }
    json_text(&json, "hazards_since",
              m->hazards.since == 0 ? ""
                                    : lum_laser_bits_name(m->hazards.since, " ",
                                                          bits, sizeof bits));
    if (m->answers) {
        report_json_trip(&json, m->round_trip_ns);
    }
    put_clock(&json, s);
    if (s->has_counts) {
        put_counts(&json, s);
    }
    json_end_line(&json);
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

struct seconds {
    char text[40];
};

/* Seconds of nanoseconds, exactly. */
static struct seconds seconds_text(int64_t ns)
{
    struct seconds out;
    const int64_t whole = ns / INT64_C(1000000000);
    const int64_t part = ns % INT64_C(1000000000);
    (void)snprintf(out.text, sizeof out.text, "%s%" PRId64 ".%09" PRId64,
                   ns < 0 && whole == 0 ? "-" : "", whole,
                   part < 0 ? -part : part);
    return out;
}

static void add_csv_clock(char out[SAMPLE_ROW_BYTES], const struct sample *s)
{
    if (!s->has_clock) {
        ADD(out, SAMPLE_ROW_BYTES, ",,,");
        return;
    }
    ADD(out, SAMPLE_ROW_BYTES, ",%s,%s", seconds_text(s->utc_offset_ns).text,
        seconds_text(s->clock.error_ns).text);
    if (s->clock.has_drift) {
        ADD(out, SAMPLE_ROW_BYTES, ",%.3f", (double)s->clock.drift_ppb / 1e3);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",");
    }
}

void sample_csv(const struct sample *s, char out[SAMPLE_ROW_BYTES])
{
    const struct monitor *m = s->monitor;
    const bool has_status = m->answers && m->has_status;
    out[0] = '\0';
    ADD(out, SAMPLE_ROW_BYTES, "%s,%s,%d,", report_utc(s->utc_ns).text,
        s->sensor, m->answers ? 1 : 0);
    if (s->age_s >= 0.0) {
        ADD(out, SAMPLE_ROW_BYTES, "%.3f", s->age_s);
    }
    if (has_status) {
        ADD(out, SAMPLE_ROW_BYTES, ",%s,%u", lum_laser_status_name(m->status),
            (unsigned)m->status);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",,");
    }
    add_bits(out, has_status ? m->hazards.now : 0);
    add_bits(out, m->hazards.since);
    if (has_trip(s)) {
        ADD(out, SAMPLE_ROW_BYTES, ",%.3f", (double)m->round_trip_ns / 1e6);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",");
    }
    add_csv_clock(out, s);
    if (s->has_counts) {
        ADD(out, SAMPLE_ROW_BYTES,
            ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64
            ",%" PRIu64,
            s->session.datagrams, s->session.bytes, s->session.kernel_drops,
            s->losses.lines_incomplete, s->losses.lines_missing,
            s->losses.words_lost);
    } else {
        ADD(out, SAMPLE_ROW_BYTES, ",,,,,,");
    }
    ADD(out, SAMPLE_ROW_BYTES, "\n");
}

/* --- Prometheus --- */

/* A metric with one value; value: as text. */
static void add_metric(char out[SAMPLE_PAGE_BYTES], const struct sample *s,
                       const char *name, const char *type, const char *help,
                       const char *value)
{
    ADD(out, SAMPLE_PAGE_BYTES,
        "# HELP lumsdk_%s %s\n# TYPE lumsdk_%s %s\nlumsdk_%s{sensor=\"%s\"} "
        "%s\n",
        name, help, name, type, name, s->sensor, value);
}

static void add_real(char out[SAMPLE_PAGE_BYTES], const struct sample *s,
                     const char *name, const char *help, double value)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%.9g", value);
    add_metric(out, s, name, "gauge", help, text);
}

static void add_whole(char out[SAMPLE_PAGE_BYTES], const struct sample *s,
                      const char *name, const char *help, uint64_t value)
{
    char text[24];
    const char *total = strstr(name, "_total");
    (void)snprintf(text, sizeof text, "%" PRIu64, value);
    add_metric(out, s, name, total != NULL ? "counter" : "gauge", help, text);
}

static void add_status(char out[SAMPLE_PAGE_BYTES], const struct sample *s)
{
    const struct monitor *m = s->monitor;
    add_whole(out, s, "laser_up", "Whether the status shows the laser on.",
              lum_laser_is_on(m->status));
    add_whole(out, s, "hazard", "Whether the status shows a hazard.",
              m->hazards.now != 0);
    ADD(out, SAMPLE_PAGE_BYTES,
        "# HELP lumsdk_status_bit The bits of the status.\n"
        "# TYPE lumsdk_status_bit gauge\n");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const char *name = lum_laser_bit_name(bit);
        if (name != NULL && *name != '\0') {
            ADD(out, SAMPLE_PAGE_BYTES,
                "lumsdk_status_bit{sensor=\"%s\",bit=\"%s\"} %u\n", s->sensor,
                name, (unsigned)m->status >> bit & 1u);
        }
    }
}

static void add_clock(char out[SAMPLE_PAGE_BYTES], const struct sample *s)
{
    add_metric(out, s, "clock_offset_seconds", "gauge",
               "UTC at which the sensor's clock was 0.",
               seconds_text(s->utc_offset_ns).text);
    add_real(out, s, "clock_error_seconds",
             "Largest possible error of the offset.",
             (double)s->clock.error_ns / 1e9);
    if (s->clock.has_drift) {
        add_real(out, s, "clock_drift_ratio",
                 "By how much this host's clock runs faster than the sensor's.",
                 (double)s->clock.drift_ppb / 1e9);
    }
    add_whole(out, s, "restarts_total",
              "Restarts of the sensor that its clock showed.", s->clock.resets);
}

static void add_counts(char out[SAMPLE_PAGE_BYTES], const struct sample *s)
{
    add_whole(out, s, "packets_total", "Datagrams that came.",
              s->session.datagrams);
    add_whole(out, s, "bytes_total", "Bytes in them.", s->session.bytes);
    add_whole(out, s, "kernel_drops_total",
              "Datagrams that this host's kernel dropped.",
              s->session.kernel_drops);
    add_whole(out, s, "lost_words_total", "Range words lost, at least.",
              s->losses.words_lost);
    add_whole(out, s, "incomplete_lines_total", "Lines that lost angles.",
              s->losses.lines_incomplete);
    add_whole(out, s, "missing_lines",
              "Lines of which no packet came; falls when they come late.",
              s->losses.lines_missing);
}

void sample_page(const struct sample *s, char out[SAMPLE_PAGE_BYTES])
{
    const struct monitor *m = s->monitor;
    out[0] = '\0';
    add_whole(out, s, "up", "Whether the sensor answers.", m->answers);
    if (s->age_s >= 0.0) {
        add_real(out, s, "answer_age_seconds",
                 "Time since the last answer, when this was written.",
                 s->age_s);
    }
    if (has_trip(s)) {
        add_real(out, s, "round_trip_seconds",
                 "Round trip of the last request.",
                 (double)m->round_trip_ns / 1e9);
    }
    if (m->answers && m->has_status) {
        add_status(out, s);
    }
    add_whole(out, s, "hazards_total", "Times that a hazard began.",
              m->hazards.count);
    if (m->hazards.seen_utc_ns != 0) {
        add_metric(out, s, "last_hazard_timestamp_seconds", "gauge",
                   "When a hazard was last seen.",
                   seconds_text(m->hazards.seen_utc_ns).text);
    }
    if (m->answers && s->has_clock) {
        add_clock(out, s);
    }
    if (s->has_counts) {
        add_counts(out, s);
    }
}
