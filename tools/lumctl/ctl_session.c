#include "ctl_session.h"

#include "../common/interrupt.h"
#include "../common/number.h"
#include "../common/printable.h"
#include "../common/terminal.h"
#include "status_report.h"

#include "lum/base/time.h"
#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

#define NS_PER_MS INT64_C(1000000)
#define LOOK_NS   (1000 * NS_PER_MS)

/* --- Whom it talks to --- */

struct session_name session_name(lum_endpoint host)
{
    struct session_name name;
    const size_t len = strlen(number_format_address(host.address, name.text));
    if (host.port != LUM_PORT) {
        (void)snprintf(name.text + len, sizeof name.text - len, ":%u",
                       (unsigned)host.port);
    }
    return name;
}

struct session_ctl session_ctl(const struct ctl *ctl, lum_endpoint host)
{
    struct session_ctl command;
    (void)lum_news_ctl(host, ctl->options.interface, command.text,
                       sizeof command.text);
    return command;
}

lum_endpoint session_host(const struct ctl *ctl)
{
    return ctl->sensor != NULL ? lum_sensor_endpoint(ctl->sensor)
                               : ctl->options.host;
}

bool session_has_owner(const struct ctl *ctl)
{
    return ctl->owns ||
           lum_sensor_is_owned(session_host(ctl), ctl->options.interface, NULL);
}

bool session_is_owned(const struct ctl *ctl, uint16_t status)
{
    return report_lacks_heartbeats(status) && session_has_owner(ctl);
}

static lum_sensor_options describe(const struct ctl *ctl, lum_endpoint host,
                                   bool owns)
{
    const struct ctl_options *from = &ctl->options;
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = host;
    options.interface_name = from->interface;
    options.layout = ctl->layout;
    options.owns = owns;
    options.timeout_ms = from->requests.timeout_ms;
    options.retries = from->requests.retries;
    options.has_sequence = from->requests.has_sequence;
    options.sequence = from->requests.sequence;
    options.cancel = ctl->cancel;
    if (from->owner.rate_hz > 0.0) {
        options.heartbeat_ms = (uint32_t)(1000.0 / from->owner.rate_hz);
    }
    return options;
}

lum_net_result session_try(const struct ctl *ctl, lum_endpoint host, bool owns,
                           lum_sensor **out, lum_error *error)
{
    const lum_sensor_options options = describe(ctl, host, owns);
    if (owns) {
        interrupt_insist(); /* its heartbeats keep a laser on */
    }
    return lum_sensor_open(&options, out, error);
}

/* What the session before had to do with the laser goes on. Who types in a
 * shell that owns the sensor switches it on and off. */
static lum_laser_want want_of(const struct ctl *ctl, bool owns,
                              const lum_laser_session_view *before)
{
    const bool guards = before->laser != LUM_LASER_UNTOUCHED ||
                        (owns && ctl->options.owner.heartbeat);
    return before->is_off_due ? LUM_WANT_OFF
           : guards           ? LUM_WANT_GUARD
                              : LUM_WANT_LOOK;
}

/* A command is one request; one that keeps the laser on tries as long as others
 * do. */
static int open_laser(struct ctl *ctl, lum_endpoint host, bool owns,
                      lum_laser_session **out, lum_error *error)
{
    const lum_sensor_options session = describe(ctl, host, owns);
    lum_laser_session_view before = {.struct_size = sizeof before};
    lum_laser_session_options options;
    lum_laser_session_options_default(&options, &session);
    if (ctl->laser != NULL) {
        (void)lum_laser_session_look(ctl->laser, &before);
    }
    if (!ctl->options.owner.laser) {
        options.give_up_ms = 0;
        options.attempts = 1;
    }
    options.laser = want_of(ctl, owns, &before);
    ctl->was_up = before.laser == LUM_LASER_UP;
    return lum_laser_session_new(&options, lum_time_monotonic_ns(), out, error);
}

void session_end(struct ctl *ctl)
{
    lum_laser_session_free(ctl->laser);
    lum_sensor_close(ctl->sensor);
    ctl->laser = NULL;
    ctl->sensor = NULL;
    ctl_complain_hurry(false);
}

enum exit_status session_change(struct ctl *ctl, lum_endpoint host, bool owns)
{
    lum_sensor *sensor = NULL;
    lum_laser_session *laser = NULL;
    lum_error error = {""};
    if (session_try(ctl, host, owns, &sensor, &error) != LUM_NET_OK ||
        open_laser(ctl, host, owns, &laser, &error) != 0) {
        lum_sensor_close(sensor);
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    session_end(ctl);
    ctl->sensor = sensor;
    ctl->laser = laser;
    ctl->owns = owns;
    ctl_complain_hurry(owns);
    return EXIT_DONE;
}

enum exit_status ctl_open(struct ctl *ctl, bool owns)
{
    return ctl->sensor != NULL && (ctl->owns || !owns)
               ? EXIT_DONE
               : session_change(ctl, session_host(ctl), owns);
}

/* Its answer is no answer to what the laser session asks. */
static void lend(struct ctl *ctl)
{
    lum_sensor_give_up(ctl->sensor);
    lum_laser_session_lend(ctl->laser, lum_time_monotonic_ns());
}

lum_result session_request(struct ctl *ctl, const void *tlvs, size_t len)
{
    lend(ctl);
    return lum_sensor_request(ctl->sensor, tlvs, len);
}

lum_result session_request_time(struct ctl *ctl)
{
    lend(ctl);
    return lum_sensor_request_time(ctl->sensor);
}

lum_result session_command(struct ctl *ctl, const char *text)
{
    lum_sensor_give_up(ctl->sensor);
    lum_laser_session_note_owner(ctl->laser, session_has_owner(ctl));
    return lum_laser_session_command(ctl->laser, ctl->sensor, text,
                                     lum_time_monotonic_ns());
}

/* --- Answers --- */

static void add_debug(char *out, size_t size, const lum_tlv *tlv)
{
    size_t n = strlen(out);
    if (n != 0 && n + 1 < size) {
        out[n++] = '\n';
        out[n] = '\0';
    }
    (void)printable(tlv->value, tlv->length, out + n, size - n);
}

static void add_other(char *out, size_t size, const lum_tlv *tlv)
{
    size_t n = strlen(out);
    const size_t need = 2u * tlv->length + sizeof "\n65535:";
    if (size - n < need) {
        return;
    }
    n += (size_t)snprintf(out + n, size - n, "%s%u:", n != 0 ? "\n" : "",
                          (unsigned)tlv->type);
    for (size_t i = 0; i < tlv->length; i++) {
        n += (size_t)snprintf(out + n, size - n, "%02x",
                              (unsigned)tlv->value[i]);
    }
}

/* An alert may have told of a hazard that is over in the answer. */
void session_read_answer(struct ctl *ctl, const lum_sensor_event *event,
                         struct ctl_answer *out)
{
    const uint16_t *numbers = ctl->layout.profile.tlv;
    lum_tlv_reader reader = event->tlvs;
    lum_tlv tlv;
    *out = (struct ctl_answer){
        .has_status = event->has_status,
        .status = (uint16_t)(event->status | ctl->refused),
        .tries = event->tries,
        .round_trip_ns =
            event->tries == 1 ? event->received_ns - event->sent_ns : 0};
    ctl->refused = 0;
    if (event->has_status) {
        ctl->has_status = true;
        ctl->status = event->status;
    }
    while (lum_tlv_next(&reader, &tlv) == LUM_OK) {
        if (tlv.type == numbers[LUM_TLV_DEBUG]) {
            add_debug(out->debug, sizeof out->debug, &tlv);
        } else if (tlv.type != numbers[LUM_TLV_STATUS]) {
            add_other(out->others, sizeof out->others, &tlv);
        }
    }
}

/* What owns the sensor waits for no reader: its heartbeats come first. */
static bool may_tell(const struct ctl *ctl)
{
    return !ctl->owns || writable(stderr, 0);
}

/* Printed if it differs from the last. */
static void note_status(struct ctl *ctl, uint16_t status)
{
    const bool was_up = ctl->has_status && lum_laser_is_on(ctl->status);
    const bool is_own = lum_sensor_is_waiting(ctl->sensor);
    if ((!ctl->has_status || ctl->status != status) && may_tell(ctl)) {
        (void)fprintf(stderr, "lumctl: %s: %s%s\n",
                      session_name(session_host(ctl)).text,
                      report_line(status, session_is_owned(ctl, status)).text,
                      is_own ? "" : report_cause(status, was_up));
    }
    ctl->has_status = true;
    ctl->status = status;
}

/* Commands say themselves what became of their requests; is_alone: there are
 * none. */
static bool is_said(const struct ctl *ctl, const lum_sensor_event *event,
                    lum_news_kind kind, bool is_alone)
{
    const bool is_of_laser = ctl->options.owner.laser && is_alone &&
                             kind <= LUM_NEWS_LASER_CAME_UP &&
                             lum_news_weigh(kind) != LUM_NEWS_INFO;
    const bool is_of_data =
        kind >= LUM_NEWS_NO_ANSWER_YET && kind <= LUM_NEWS_RESTARTED;
    const bool is_of_answers = kind == LUM_NEWS_UNHEARD ||
                               kind == LUM_NEWS_LATE_ANSWERS ||
                               kind == LUM_NEWS_NO_STATUS;
    return is_of_data || is_of_laser || kind == LUM_NEWS_LASER_FELL ||
           kind == LUM_NEWS_OFF_UNANSWERED || kind == LUM_NEWS_LINK_DOWN ||
           kind == LUM_NEWS_LINK_UP || (is_of_answers && is_alone) ||
           (kind == LUM_NEWS_TEXT && event->kind == LUM_SENSOR_ALERT);
}

/* A sensor that nobody owned yet tells so at first. */
static bool is_trouble(const lum_news *news)
{
    const lum_news_kind kind = news->kind;
    return (kind >= LUM_NEWS_LASER_FELL && kind <= LUM_NEWS_LASER_CAME_UP) ||
           (kind == LUM_NEWS_HAZARD &&
            news->status != LUM_LASER_HEARTBEAT_TIMEOUT) ||
           (kind >= LUM_NEWS_NO_ANSWER_YET && kind <= LUM_NEWS_DATA_STOPPED) ||
           kind == LUM_NEWS_MOVED || kind == LUM_NEWS_RESTARTED ||
           kind == LUM_NEWS_NO_ANSWER;
}

/* Printed even with --quiet: it is what the sensor says, or a person must know.
 */
void session_tell(struct ctl *ctl, const lum_sensor_event *event, bool is_alone)
{
    lum_news news = {.struct_size = sizeof news};
    while (lum_laser_session_next(ctl->laser, &news)) {
        char text[LUM_ERROR_BYTES];
        if (ctl->trouble.kind == 0 && is_trouble(&news)) {
            ctl->trouble = news;
        }
        ctl->refused =
            news.kind == LUM_NEWS_LASER_REFUSED ? news.status : ctl->refused;
        if (is_said(ctl, event, news.kind, is_alone) && may_tell(ctl)) {
            (void)ctl_complain(EXIT_FAILED, "%s",
                               lum_news_tell(&news, text, sizeof text));
        }
    }
}

static bool is_off_due(const struct ctl *ctl)
{
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(ctl->laser, &view);
    return view.is_off_due;
}

bool session_serve_off(struct ctl *ctl)
{
    const bool is_due = is_off_due(ctl);
    if (is_due) {
        lum_laser_session_serve(ctl->laser, ctl->sensor,
                                lum_time_monotonic_ns());
    }
    return is_due;
}

void session_receive(struct ctl *ctl, int64_t deadline_ns,
                     lum_sensor_event *out)
{
    lum_sensor_receive(ctl->sensor, deadline_ns, out);
    lum_laser_session_take(ctl->laser, out, lum_time_monotonic_ns());
}

lum_sensor_event_kind session_wait(struct ctl *ctl, int64_t deadline_ns,
                                   lum_sensor_event *out)
{
    session_receive(ctl, deadline_ns, out);
    session_tell(ctl, out, false);
    if (out->kind == LUM_SENSOR_ALERT && out->has_status) {
        note_status(ctl, out->status);
    }
    return out->kind;
}

void session_rest(struct ctl *ctl, int64_t ns)
{
    const int64_t end = lum_time_monotonic_ns() + ns;
    while (lum_time_monotonic_ns() < end) {
        lum_sensor_event event;
        (void)session_serve_off(ctl);
        const lum_sensor_event_kind kind = session_wait(ctl, end, &event);
        if (kind == LUM_SENSOR_CANCELLED || kind == LUM_SENSOR_FAILED) {
            return;
        }
    }
}

void session_keep_alive(struct ctl *ctl)
{
    lum_sensor_event event;
    if (ctl->sensor != NULL) {
        session_receive(ctl, 0, &event);
        (void)session_serve_off(ctl);
    }
}

bool session_goes_on(void *owner)
{
    struct ctl *ctl = owner;
    if (lum_cancel_is_raised(ctl->cancel)) {
        return false;
    }
    session_keep_alive(ctl);
    return true;
}

/* --- Requests and their ends --- */

enum exit_status session_complain_silence(const struct ctl *ctl, unsigned tries)
{
    char how[64] = "";
    if (tries > 0) {
        (void)snprintf(how, sizeof how, " (tried %u %s, %u ms%s)", tries,
                       tries == 1 ? "time" : "times",
                       (unsigned)ctl->options.requests.timeout_ms,
                       tries == 1 ? "" : " each");
    } else if (ctl->options.repeat.duration_s > 0.0) {
        (void)snprintf(how, sizeof how, " (waited for %.6g s)",
                       ctl->options.repeat.duration_s);
    }
    return ctl_complain(EXIT_NO_ANSWER,
                        "%s does not answer%s; to find out why: %s doctor",
                        session_name(session_host(ctl)).text, how,
                        session_ctl(ctl, session_host(ctl)).text);
}

/* The hazard that came meanwhile was told. */
static enum exit_status yield_to_off(struct ctl *ctl)
{
    (void)session_serve_off(ctl);
    return ctl_complain(EXIT_FAILED, "laser off comes first: whether the "
                                     "sensor got the request is not known");
}

enum exit_status session_finish(struct ctl *ctl, lum_sensor_event *out)
{
    const bool was_due = is_off_due(ctl); /* by the request itself */
    for (;;) {
        const lum_sensor_event_kind kind =
            session_wait(ctl, lum_time_monotonic_ns() + LOOK_NS, out);
        if (kind == LUM_SENSOR_ANSWER || kind == LUM_SENSOR_TIME) {
            return EXIT_DONE;
        }
        if (kind == LUM_SENSOR_NO_ANSWER) {
            return session_complain_silence(ctl, out->tries);
        }
        if (kind == LUM_SENSOR_CANCELLED) {
            lum_sensor_give_up(ctl->sensor);
            return ctl_complain(EXIT_FAILED, "interrupted: whether the sensor "
                                             "got the request is not known");
        }
        if (kind == LUM_SENSOR_FAILED) {
            return ctl_complain(EXIT_FAILED, "%s", out->error.text);
        }
        if (!was_due && is_off_due(ctl)) {
            return yield_to_off(ctl);
        }
    }
}
