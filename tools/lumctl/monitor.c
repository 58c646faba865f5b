#include "monitor.h"

#include "../common/terminal.h"
#include "ctl_session.h"
#include "status_report.h"

#include "lum/base/time.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Between two looks at the clock: as the lines, from one to ten seconds. */
#define CLOCK_MIN_NS INT64_C(1000000000)
#define CLOCK_MAX_NS INT64_C(10000000000)

static enum exit_status begin_counts(struct monitor *m)
{
    lum_error error = {""};
    m->begun.struct_size = sizeof m->begun;
    lum_sensor_count(m->ctl->sensor, &m->begun);
    if (!m->ctl->owns || m->ctl->options.repeat.every_s <= 0.0) {
        return EXIT_DONE;
    }
    m->losses = losses_new(&m->ctl->layout, &error);
    return m->losses != NULL ? EXIT_DONE
                             : ctl_complain(EXIT_FAILED, "%s", error.text);
}

enum exit_status monitor_begin(struct monitor *m, struct ctl *ctl, bool asks)
{
    const struct repeat_options *o = &ctl->options.repeat;
    const bool has_files = o->csv != NULL || o->prometheus != NULL;
    const int64_t now = lum_time_monotonic_ns();
    lum_error error = {""};
    *m = (struct monitor){.ctl = ctl,
                          .asks = asks,
                          .rows.due_ns = now + (int64_t)(o->every_s * 1e9),
                          .clock_ns = now,
                          .rows.prints = ctl->options.json || !has_files};
    ctl->is_lasting = !ctl->in_shell;
    lum_clock_sync_init(&m->sync);
    const enum exit_status status = begin_counts(m);
    if (status != EXIT_DONE || !has_files) {
        return status;
    }
    m->rows.writer =
        file_writer_new(o->csv, sample_csv_header, o->prometheus, &error);
    if (m->rows.writer == NULL) {
        losses_free(m->losses);
        m->losses = NULL;
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
    struct monitor *m = context;
    const int64_t now = lum_time_monotonic_ns();
    const bool has_first = m->has_status || !m->asks;
    if (ctl->options.repeat.every_s > 0.0 && has_first && now >= m->clock_ns) {
        m->clock_ns = now + clock_period(ctl->options.repeat.every_s);
        return session_request_time(ctl);
    }
    return m->asks ? session_request(ctl, NULL, 0) : LUM_OK;
}

/* --- What comes --- */

/* That no heartbeat comes is a hazard only if somebody owns the sensor, and did
 * at the status before: an owner's first one may be under way yet. */
static uint16_t hazards_of(const struct monitor *m, uint16_t status,
                           bool is_owned)
{
    const unsigned hazards = status & LUM_LASER_HAZARDS;
    return (uint16_t)(is_owned && m->was_owned
                          ? hazards
                          : hazards & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT);
}

/* Where lines go to files, a person is told at once. */
static void tell_hazard(const struct monitor *m, uint16_t hazards)
{
    char bits[LUM_LASER_BITS_TEXT];
    const unsigned begun = hazards & ~(unsigned)m->hazards.now;
    if (m->rows.writer != NULL && begun != 0) {
        (void)ctl_complain(
            EXIT_HAZARD, "%s: %s", report_utc(m->hazards.seen_utc_ns).text,
            lum_laser_bits_name((uint16_t)begun, ", ", bits, sizeof bits));
    }
}

static void take_status(struct monitor *m, uint16_t status)
{
    const bool is_owned = session_is_owned(m->ctl, status);
    const uint16_t hazards = hazards_of(m, status, is_owned);
    m->was_owned = is_owned;
    m->hazards.count += (hazards & ~(unsigned)m->hazards.now) != 0 ? 1u : 0u;
    m->hazards.seen_utc_ns =
        hazards != 0 ? lum_time_utc_ns() : m->hazards.seen_utc_ns;
    tell_hazard(m, hazards);
    m->has_status = true;
    m->status = status;
    m->hazards.now = hazards;
    m->hazards.since |= hazards;
    m->hazards.ever |= hazards;
}

static void take_answer(struct monitor *m, const lum_sensor_event *event)
{
    m->knows = true;
    m->answers = true;
    m->answered_ns = event->received_ns;
    m->round_trip_ns =
        event->tries == 1 ? event->received_ns - event->sent_ns : 0;
}

static void take_data(struct monitor *m, const lum_sensor_event *event)
{
    for (size_t i = 0; m->losses != NULL && i < event->datagram_count; i++) {
        losses_take(m->losses, session_host(m->ctl), &event->datagrams[i]);
    }
}

/* --- Rows --- */

static void fill(const struct monitor *m, const char *sensor,
                 struct sample *out)
{
    const int64_t now = lum_time_monotonic_ns();
    *out = (struct sample){
        .sensor = sensor,
        .utc_ns = lum_time_utc_ns(),
        .monitor = m,
        .is_owned = m->has_status && session_is_owned(m->ctl, m->status),
        .age_s =
            m->answered_ns != 0 ? (double)(now - m->answered_ns) / 1e9 : -1.0,
        .has_counts = m->losses != NULL,
        .session.struct_size = sizeof out->session};
    out->has_clock = lum_clock_sync_estimate(&m->sync, &out->clock) == LUM_OK;
    out->utc_offset_ns = out->clock.offset_ns + (out->utc_ns - now);
    lum_sensor_count(m->ctl->sensor, &out->session);
    out->session.datagrams -= m->begun.datagrams;
    out->session.bytes -= m->begun.bytes;
    out->session.kernel_drops -= m->begun.kernel_drops;
    if (m->losses != NULL) {
        losses_count(m->losses, &out->losses);
    }
}

/* An owner waits for no reader: then the next line tells of the hazards. */
static bool print_row(struct monitor *m, const struct sample *s)
{
    char row[SAMPLE_ROW_BYTES];
    if (m->rows.prints && m->ctl->owns && !writable(stdout, 0)) {
        m->rows.unprinted++;
        return true;
    }
    if (m->rows.prints && m->ctl->options.json) {
        sample_json(s, stdout);
    } else if (m->rows.prints) {
        sample_text(s, row);
        (void)fputs(row, stdout);
    }
    m->hazards.since = 0;
    return !m->rows.prints || report_flush();
}

static void tell_failure(const struct monitor *m)
{
    lum_error error = {""};
    if (writable(stderr, 0) && file_writer_tell(m->rows.writer, &error)) {
        (void)ctl_complain(EXIT_FAILED, "%s; it is tried again at each line",
                           error.text);
    }
}

static void write_files(const struct monitor *m, const struct sample *s)
{
    char row[SAMPLE_ROW_BYTES];
    char page[SAMPLE_PAGE_BYTES];
    sample_csv(s, row);
    file_writer_add(m->rows.writer, row);
    sample_page(s, page);
    file_writer_turn(m->rows.writer, page);
    tell_failure(m);
}

static bool write_row(struct monitor *m)
{
    const struct session_name name = session_name(session_host(m->ctl));
    struct sample s;
    fill(m, name.text, &s);
    if (m->rows.writer != NULL) {
        write_files(m, &s);
    }
    const bool goes_on = print_row(m, &s);
    m->rows.has_any = true;
    m->was_up = m->has_status && lum_laser_is_on(m->status);
    return goes_on;
}

static bool is_due(struct monitor *m)
{
    const int64_t every = (int64_t)(m->ctl->options.repeat.every_s * 1e9);
    const int64_t now = lum_time_monotonic_ns();
    if (every == 0 || !m->knows || now < m->rows.due_ns) {
        return false;
    }
    m->rows.due_ns += every * ((now - m->rows.due_ns) / every + 1);
    return true;
}

bool monitor_take(struct monitor *m, const lum_sensor_event *event)
{
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        take_data(m, event);
    } else if (event->kind == LUM_SENSOR_TIME) {
        (void)!lum_clock_sync_add(&m->sync, event->sent_ns, event->received_ns,
                                  event->clock_us);
        take_answer(m, event);
    } else if (event->kind == LUM_SENSOR_ANSWER) {
        take_answer(m, event);
    } else if (event->kind == LUM_SENSOR_ALERT) {
        m->answers = true;
        m->answered_ns = event->received_ns;
    } else if (event->kind == LUM_SENSOR_NO_ANSWER) {
        m->knows = true;
        m->answers = false;
    }
    if (event->has_status) {
        take_status(m, event->status);
    }
    return !is_due(m) || write_row(m);
}

/* --- The end --- */

bool monitor_is_met(const struct monitor *m)
{
    switch (m->ctl->options.repeat.until) {
    case UNTIL_HAZARD:
        return m->hazards.ever != 0;
    case UNTIL_UP:
        return m->answers && m->has_status && lum_laser_is_on(m->status);
    case UNTIL_DOWN:
        return m->answers && m->has_status && lum_laser_is_down(m->status);
    default:
        return false;
    }
}

/* The last row, and what was never written. */
static enum exit_status end_files(struct monitor *m, enum exit_status status)
{
    const struct repeat_options *o = &m->ctl->options.repeat;
    const struct file_writer_rest rest = file_writer_end(m->rows.writer);
    m->rows.writer = NULL;
    if (rest.has_news) {
        (void)ctl_complain(EXIT_FAILED, "%s", rest.news.text);
    }
    if (rest.lost > 0) {
        status = ctl_complain(
            EXIT_FAILED, "%s: missing lines: %" PRIu64,
            strcmp(o->csv, "-") == 0 ? "standard output" : o->csv, rest.lost);
    }
    if (rest.page_failed) {
        status =
            ctl_complain(EXIT_FAILED, "%s is not up to date", o->prometheus);
    }
    return status;
}

/* Also of an owner that was silent at the only look. */
static uint16_t hazards_at_end(const struct monitor *m)
{
    return m->answers && m->has_status
               ? hazards_of(m, m->status, session_is_owned(m->ctl, m->status))
               : 0;
}

static void tell_passed(uint16_t passed)
{
    char bits[LUM_LASER_BITS_TEXT];
    (void)ctl_complain(EXIT_HAZARD, "hazards that came and went: %s",
                       lum_laser_bits_name(passed, ", ", bits, sizeof bits));
}

enum exit_status monitor_end(struct monitor *m, enum exit_status status)
{
    const struct repeat_options *o = &m->ctl->options.repeat;
    if (o->every_s > 0.0 && (m->hazards.since != 0 || !m->rows.has_any)) {
        (void)write_row(m);
    }
    if (m->rows.writer != NULL) {
        status = end_files(m, status);
    }
    if (m->rows.unprinted > 0) {
        (void)ctl_complain(EXIT_FAILED,
                           "%" PRIu64 " lines were not printed: nobody read "
                           "standard output",
                           m->rows.unprinted);
    }
    losses_free(m->losses);
    m->losses = NULL;
    const uint16_t now = hazards_at_end(m);
    const bool counts_all = o->every_s > 0.0 || o->until == UNTIL_HAZARD;
    const uint16_t passed =
        counts_all ? (uint16_t)(m->hazards.ever & ~(unsigned)now) : 0;
    if (passed != 0) {
        tell_passed(passed);
    }
    return (now != 0 || passed != 0) &&
                   (status == EXIT_DONE || status == EXIT_NO_ANSWER)
               ? EXIT_HAZARD
               : status;
}
