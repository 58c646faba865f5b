#include "monitor.h"

#include "../common/writable.h"
#include "report.h"
#include "session.h"

#include "lum/base/time.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Between two looks at the clock: as the lines, from one to ten seconds. */
#define CLOCK_MIN_NS INT64_C(1000000000)
#define CLOCK_MAX_NS INT64_C(10000000000)

static enum exit_status begin_counts(struct monitor *v)
{
    lum_error error = {""};
    v->begun.struct_size = sizeof v->begun;
    lum_sensor_count(v->ctl->sensor, &v->begun);
    if (!v->ctl->owns || v->ctl->options.every_s <= 0.0) {
        return EXIT_DONE;
    }
    v->losses = losses_new(&v->ctl->layout, &error);
    return v->losses != NULL ? EXIT_DONE
                             : ctl_complain(EXIT_FAILED, "%s", error.text);
}

enum exit_status monitor_begin(struct monitor *v, struct ctl *ctl, bool asks)
{
    const struct ctl_options *o = &ctl->options;
    const int64_t now = lum_time_monotonic_ns();
    lum_error error = {""};
    *v = (struct monitor){
        .ctl = ctl,
        .asks = asks,
        .begun_ns = now,
        .row_ns = now + (int64_t)(o->every_s * 1e9),
        .clock_ns = now,
        .writes_rows = o->json || (o->csv == NULL && o->prometheus == NULL)};
    ctl->is_lasting = !ctl->in_shell;
    lum_clock_sync_init(&v->sync);
    const enum exit_status status = begin_counts(v);
    if (status != EXIT_DONE || (o->csv == NULL && o->prometheus == NULL)) {
        return status;
    }
    v->writer =
        file_writer_new(o->csv, sample_csv_header, o->prometheus, &error);
    if (v->writer == NULL) {
        losses_free(v->losses);
        v->losses = NULL;
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    return EXIT_DONE;
}

static int64_t clock_period(double every_s)
{
    const int64_t every = (int64_t)(every_s * 1e9);
    return every < CLOCK_MIN_NS   ? CLOCK_MIN_NS
           : every > CLOCK_MAX_NS ? CLOCK_MAX_NS
                                  : every;
}

lum_result monitor_ask(struct ctl *ctl, void *context)
{
    struct monitor *v = context;
    const int64_t now = lum_time_monotonic_ns();
    const bool has_first = v->has_status || !v->asks;
    if (ctl->options.every_s > 0.0 && has_first && now >= v->clock_ns) {
        v->clock_ns = now + clock_period(ctl->options.every_s);
        return session_request_time(ctl);
    }
    return v->asks ? session_request(ctl, NULL, 0) : LUM_OK;
}

/* --- What comes --- */

/* That no heartbeat comes is a hazard only if somebody owns the sensor, and did
 * at the status before: an owner's first one may be under way yet. */
static uint16_t hazards_of(const struct monitor *v, uint16_t status,
                           bool is_owned)
{
    const unsigned hazards = status & LUM_LASER_HAZARDS;
    return (uint16_t)(is_owned && v->was_owned
                          ? hazards
                          : hazards & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT);
}

/* Where lines go to files, a person is told at once. */
static void tell_hazard(const struct monitor *v, uint16_t hazards)
{
    char when[REPORT_UTC_BYTES];
    char bits[LUM_LASER_BITS_TEXT];
    const unsigned begun = hazards & ~(unsigned)v->hazards;
    if (v->writer != NULL && begun != 0) {
        (void)ctl_complain(
            EXIT_HAZARD, "%s: %s", report_utc(v->hazard_utc_ns, when),
            lum_laser_bits_name((uint16_t)begun, ", ", bits, sizeof bits));
    }
}

static void take_status(struct monitor *v, uint16_t status)
{
    const bool is_owned = session_is_owned(v->ctl, status);
    const uint16_t hazards = hazards_of(v, status, is_owned);
    v->was_owned = is_owned;
    v->hazard_count += (hazards & ~(unsigned)v->hazards) != 0 ? 1u : 0u;
    v->hazard_utc_ns = hazards != 0 ? lum_time_utc_ns() : v->hazard_utc_ns;
    tell_hazard(v, hazards);
    v->has_status = true;
    v->status = status;
    v->hazards = hazards;
    v->since |= hazards;
    v->ever |= hazards;
}

static void take_answer(struct monitor *v, const lum_sensor_event *event)
{
    v->knows = true;
    v->answers = true;
    v->answered_ns = event->received_ns;
    v->round_trip_ns =
        event->tries == 1 ? event->received_ns - event->sent_ns : 0;
}

static void take_data(struct monitor *v, const lum_sensor_event *event)
{
    for (size_t i = 0; v->losses != NULL && i < event->datagram_count; i++) {
        losses_take(v->losses, session_host(v->ctl), &event->datagrams[i]);
    }
}

/* --- Rows --- */

static void fill(const struct monitor *v, struct sample *out,
                 char name[SESSION_NAME_BYTES])
{
    const int64_t now = lum_time_monotonic_ns();
    *out = (struct sample){
        .sensor = session_name(session_host(v->ctl), name),
        .utc_ns = lum_time_utc_ns(),
        .monitor = v,
        .is_owned = v->has_status && session_is_owned(v->ctl, v->status),
        .age_s =
            v->answered_ns != 0 ? (double)(now - v->answered_ns) / 1e9 : -1.0,
        .has_counts = v->losses != NULL,
        .session.struct_size = sizeof out->session};
    out->has_clock = lum_clock_sync_estimate(&v->sync, &out->clock) == LUM_OK;
    out->utc_offset_ns = out->clock.offset_ns + (out->utc_ns - now);
    lum_sensor_count(v->ctl->sensor, &out->session);
    out->session.datagrams -= v->begun.datagrams;
    out->session.bytes -= v->begun.bytes;
    out->session.kernel_drops -= v->begun.kernel_drops;
    if (v->losses != NULL) {
        losses_count(v->losses, &out->losses);
    }
}

/* An owner waits for no reader: then the next line tells of the hazards. */
static bool print_row(struct monitor *v, const struct sample *g)
{
    char row[SAMPLE_ROW_BYTES];
    if (v->writes_rows && v->ctl->owns && !writable(stdout, 0)) {
        v->unprinted++;
        return true;
    }
    if (v->writes_rows && v->ctl->options.json) {
        sample_json(g, stdout);
    } else if (v->writes_rows) {
        sample_text(g, row);
        (void)fputs(row, stdout);
    }
    v->since = 0;
    return !v->writes_rows || report_flush();
}

static void tell_failure(const struct monitor *v)
{
    lum_error error = {""};
    if (file_writer_tell(v->writer, &error) && writable(stderr, 0)) {
        (void)ctl_complain(EXIT_FAILED, "%s; it is tried again at each line",
                           error.text);
    }
}

static void write_files(const struct monitor *v, const struct sample *g)
{
    char row[SAMPLE_ROW_BYTES];
    char page[SAMPLE_PAGE_BYTES];
    sample_csv(g, row);
    file_writer_add(v->writer, row);
    sample_page(g, page);
    file_writer_turn(v->writer, page);
    tell_failure(v);
}

static bool write_row(struct monitor *v)
{
    struct sample g;
    char name[SESSION_NAME_BYTES];
    fill(v, &g, name);
    if (v->writer != NULL) {
        write_files(v, &g);
    }
    const bool goes_on = print_row(v, &g);
    v->has_row = true;
    v->was_up = v->has_status && lum_laser_is_on(v->status);
    return goes_on;
}

static bool is_due(struct monitor *v)
{
    const int64_t every = (int64_t)(v->ctl->options.every_s * 1e9);
    const int64_t now = lum_time_monotonic_ns();
    if (every == 0 || !v->knows || now < v->row_ns) {
        return false;
    }
    v->row_ns += every * ((now - v->row_ns) / every + 1);
    return true;
}

bool monitor_take(struct monitor *v, const lum_sensor_event *event)
{
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        take_data(v, event);
    } else if (event->kind == LUM_SENSOR_TIME) {
        (void)!lum_clock_sync_add(&v->sync, event->sent_ns, event->received_ns,
                                  event->clock_us);
        take_answer(v, event);
    } else if (event->kind == LUM_SENSOR_ANSWER) {
        take_answer(v, event);
    } else if (event->kind == LUM_SENSOR_ALERT) {
        v->answers = true;
        v->answered_ns = event->received_ns;
    } else if (event->kind == LUM_SENSOR_NO_ANSWER) {
        v->knows = true;
        v->answers = false;
    }
    if (event->has_status) {
        take_status(v, event->status);
    }
    return !is_due(v) || write_row(v);
}

/* --- The end --- */

bool monitor_is_met(const struct monitor *v)
{
    switch (v->ctl->options.until) {
    case UNTIL_HAZARD:
        return v->ever != 0;
    case UNTIL_UP:
        return v->answers && v->has_status && lum_laser_is_on(v->status);
    case UNTIL_DOWN:
        return v->answers && v->has_status && lum_laser_is_down(v->status);
    default:
        return false;
    }
}

/* The last row, and what was never written. */
static enum exit_status end_files(struct monitor *v, enum exit_status status)
{
    const struct file_writer_rest rest = file_writer_end(v->writer);
    v->writer = NULL;
    if (rest.has_news) {
        (void)ctl_complain(EXIT_FAILED, "%s", rest.news.text);
    }
    if (rest.lost > 0) {
        status = ctl_complain(
            EXIT_FAILED, "%s: lines that are missing: %" PRIu64,
            strcmp(v->ctl->options.csv, "-") == 0 ? "standard output"
                                                  : v->ctl->options.csv,
            rest.lost);
    }
    if (rest.page_failed) {
        status = ctl_complain(EXIT_FAILED, "%s is not up to date",
                              v->ctl->options.prometheus);
    }
    return status;
}

/* Also of an owner that was silent at the only look. */
static uint16_t hazards_at_end(const struct monitor *v)
{
    return v->answers && v->has_status
               ? hazards_of(v, v->status, session_is_owned(v->ctl, v->status))
               : 0;
}

static void tell_passed(uint16_t passed)
{
    char bits[LUM_LASER_BITS_TEXT];
    (void)ctl_complain(EXIT_HAZARD, "hazards that came and went: %s",
                       lum_laser_bits_name(passed, ", ", bits, sizeof bits));
}

enum exit_status monitor_end(struct monitor *v, enum exit_status status)
{
    const struct ctl_options *o = &v->ctl->options;
    if (o->every_s > 0.0 && (v->since != 0 || !v->has_row)) {
        (void)write_row(v);
    }
    if (v->writer != NULL) {
        status = end_files(v, status);
    }
    if (v->unprinted > 0) {
        (void)ctl_complain(EXIT_FAILED,
                           "%" PRIu64 " lines were not printed: nobody read "
                           "standard output",
                           v->unprinted);
    }
    losses_free(v->losses);
    v->losses = NULL;
    const uint16_t now = hazards_at_end(v);
    const bool counts_all = o->every_s > 0.0 || o->until == UNTIL_HAZARD;
    const uint16_t passed =
        counts_all ? (uint16_t)(v->ever & ~(unsigned)now) : 0;
    if (passed != 0) {
        tell_passed(passed);
    }
    return (now != 0 || passed != 0) &&
                   (status == EXIT_DONE || status == EXIT_NO_ANSWER)
               ? EXIT_HAZARD
               : status;
}
