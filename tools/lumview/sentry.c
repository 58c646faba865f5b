#include "sentry.h"

#include "../common/laser_bits.h"
#include "../common/number.h"
#include "lum/laser.h"

#include <stdarg.h>
#include <stdio.h>

#define SECOND_NS INT64_C(1000000000)

#define POLL_NS    SECOND_NS
#define SILENCE_NS (3 * SECOND_NS)

/* What takes so long is told. */
#define PATIENCE_NS (3 * SECOND_NS)

/* A sensor that has just got its first heartbeat may still refuse the laser for
 * want of one. */
#define AGAIN_NS     (SECOND_NS / 5)
#define ATTEMPTS_MAX 20u
#define GIVE_UP_NS   (5 * SECOND_NS)

/* A session that was held up for so long sends no laser on: its heartbeats have
 * ended, and nobody may expect it any more. */
#define HELD_UP_NS (2 * SECOND_NS)

void sentry_begin(struct sentry *sentry, lum_sensor *sensor,
                  enum sentry_laser laser, int64_t now_ns)
{
    *sentry = (struct sentry){.sensor = sensor,
                              .laser = laser,
                              .began_ns = now_ns,
                              .tick_ns = now_ns,
                              .next_ns = now_ns};
    (void)number_format_address(lum_sensor_endpoint(sensor).address,
                                sentry->address);
}

/* The laser is down, or cannot be trusted; where the command "on" still stands,
 * it would come up with the hazard's end. */
static void fall(struct sentry *s, uint16_t status, int64_t now_ns)
{
    s->laser = SENTRY_FALLING;
    s->fell = status;
    s->next_ns = now_ns;
}

/* Hazards that heartbeats do not end. */
static bool has_lasting_hazard(uint16_t status)
{
    return (status & LUM_LASER_HAZARDS &
            ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT) != 0;
}

/* The answer to `u`. */
static void judge_on(struct sentry *s, uint16_t status, int64_t now_ns)
{
    if (!lum_laser_is_down(status)) {
        s->laser = SENTRY_UP;
    } else if (!has_lasting_hazard(status) && s->attempts < ATTEMPTS_MAX) {
        s->next_ns = now_ns + AGAIN_NS;
    } else {
        fall(s, status, now_ns);
    }
}

/* The answer to a request for the laser. */
static void judge_answer(struct sentry *s, char request,
                         const lum_sensor_event *event, int64_t now_ns)
{
    if (request == 'u' && event->has_status) {
        judge_on(s, event->status, now_ns);
    } else if (request == 'u') {
        fall(s, 0, now_ns);
    } else if (request == 'd' &&
               (!event->has_status || lum_laser_is_down(event->status))) {
        s->laser = SENTRY_DOWN;
    } else if (request == 'd') {
        s->next_ns = now_ns + AGAIN_NS;
    }
}

/* Another program may switch a laser on that was given up; where a hazard
 * refuses that, the command must not stand either. */
static void follow_down(struct sentry *s, uint16_t status, int64_t now_ns)
{
    if (!lum_laser_is_down(status)) {
        s->laser = SENTRY_UP;
    } else if (has_lasting_hazard(status) &&
               (status & LUM_LASER_TLV_CMD_OFF) == 0) {
        fall(s, status, now_ns);
    }
}

static void note_status(struct sentry *s, uint16_t status, int64_t now_ns)
{
    s->has_status = true;
    s->status = status;
    if (s->laser == SENTRY_UP && lum_laser_is_down(status)) {
        fall(s, status, now_ns);
    } else if (s->laser == SENTRY_DOWN) {
        follow_down(s, status, now_ns);
    }
}

static void take_answer(struct sentry *s, const lum_sensor_event *event,
                        int64_t now_ns)
{
    const char request = s->request;
    s->request = '?';
    s->is_unheard = false;
    if (event->has_status) {
        note_status(s, event->status, now_ns);
    }
    judge_answer(s, request, event, now_ns);
}

/* A `u` without answer may have been heard. */
static void take_no_answer(struct sentry *s, int64_t now_ns)
{
    s->is_unheard = true;
    if (s->request == 'u' && now_ns - s->began_ns >= GIVE_UP_NS) {
        fall(s, 0, now_ns);
    }
    s->request = '?';
}

static void take_link(struct sentry *s, const lum_sensor_event *event)
{
    s->is_cut_off = !event->is_up;
    if (s->is_cut_off) {
        (void)snprintf(s->why, sizeof s->why, "%.*s", (int)sizeof s->why - 1,
                       event->error.text);
    }
}

void sentry_take(struct sentry *sentry, const lum_sensor_event *event,
                 int64_t now_ns)
{
    switch (event->kind) {
    case LUM_SENSOR_ANSWER:
        take_answer(sentry, event, now_ns);
        break;
    case LUM_SENSOR_ALERT:
        /* It may be older than what is known: ask. A hazard counts at once: it
         * may be over before the answer. */
        sentry->next_ns = now_ns;
        if (event->has_status && sentry->laser == SENTRY_UP &&
            has_lasting_hazard(event->status)) {
            fall(sentry, event->status, now_ns);
        }
        break;
    case LUM_SENSOR_NO_ANSWER:
        take_no_answer(sentry, now_ns);
        break;
    case LUM_SENSOR_LINK:
        take_link(sentry, event);
        break;
    case LUM_SENSOR_IDLE:
    case LUM_SENSOR_CANCELLED:
    case LUM_SENSOR_DATAGRAMS:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_FAILED:
    default:
        break;
    }
}

static void ask(struct sentry *s, int64_t now_ns)
{
    lum_result r = LUM_OK;
    char request = '?';
    if (s->laser == SENTRY_ASKED) {
        request = 'u';
        r = lum_sensor_command(s->sensor, "u");
    } else if (s->laser == SENTRY_FALLING) {
        request = 'd';
        r = lum_sensor_command(s->sensor, "d");
    } else {
        r = lum_sensor_request(s->sensor, NULL, 0);
    }
    if (r == LUM_OK) {
        s->request = request;
        s->attempts += request == 'u' ? 1u : 0u;
        s->next_ns = now_ns + POLL_NS;
    }
}

void sentry_tick(struct sentry *sentry, int64_t now_ns)
{
    if (sentry->laser == SENTRY_ASKED &&
        now_ns - sentry->tick_ns >= HELD_UP_NS) {
        fall(sentry, 0, now_ns);
    }
    sentry->tick_ns = now_ns;
    if (now_ns >= sentry->next_ns && !lum_sensor_is_waiting(sentry->sensor)) {
        ask(sentry, now_ns);
    }
}

bool sentry_is_silent(const struct sentry *sentry, int64_t now_ns)
{
    return sentry->has_data && now_ns - sentry->data_ns >= SILENCE_NS;
}

struct message {
    char *out;
    size_t room;
    size_t len;
};

LUM_PRINTF(2, 3)
static void say(struct message *m, const char *format, ...)
{
    va_list arguments;
    if (m->len + 3u >= m->room) {
        return;
    }
    if (m->len > 0) {
        m->out[m->len++] = ';';
        m->out[m->len++] = ' ';
    }
    va_start(arguments, format);
    const int n =
        vsnprintf(m->out + m->len, m->room - m->len, format, arguments);
    va_end(arguments);
    m->len += n > 0 ? (size_t)n : 0;
}

static void say_laser(const struct sentry *s, struct message *m)
{
    char names[200];
    if (s->laser == SENTRY_UNTOUCHED && s->has_status &&
        lum_laser_is_down(s->status)) {
        say(m,
            "the laser is off: start lumview with --laser, or: lumctl --host "
            "%s laser on",
            s->address);
    } else if (s->laser == SENTRY_FALLING || s->laser == SENTRY_DOWN) {
        laser_bits_name(s->fell, LUM_LASER_ALL_DOWN, names, sizeof names);
        say(m,
            "the laser %s (%s); it stays off: when it is safe, lumctl --host "
            "%s laser on",
            s->attempts > 0 && s->fell == 0 ? "was not switched on" : "is down",
            s->fell == 0 ? "no answer" : names, s->address);
    }
}

static void say_hazards(const struct sentry *s, struct message *m)
{
    char names[200];
    const unsigned hazards = s->status & LUM_LASER_HAZARDS;
    if (s->has_status && hazards != 0) {
        laser_bits_name(s->status, LUM_LASER_HAZARDS, names, sizeof names);
        say(m, "%s reports a hazard: %s", s->address, names);
    }
}

static void say_waiting(const struct sentry *s, struct message *m)
{
    if (s->has_unknown) {
        say(m,
            "%s sends what is no data of the layout: is a --profile needed? "
            "lumdump udp://%s tells more",
            s->address, s->address);
    } else if (s->has_status) {
        say(m,
            "%s answers, but sends no data: does a firewall drop it? look with "
            "lumctl --host %s doctor",
            s->address, s->address);
    } else {
        say(m,
            "no answer from %s: is it on, connected and at this address? It "
            "boots at 10.42.0.37; look with lumctl --host %s doctor",
            s->address, s->address);
    }
}

static void say_data(const struct sentry *s, int64_t now_ns, struct message *m)
{
    if (s->is_cut_off) {
        say(m, "sending to %s fails: %s", s->address, s->why);
    } else if (sentry_is_silent(s, now_ns)) {
        say(m,
            "no data from %s for 3 s, waiting (a sensor that was restarted is "
            "at 10.42.0.37 again; lumctl --host %s doctor finds out more)",
            s->address, s->address);
    } else if (!s->has_data && now_ns - s->began_ns >= PATIENCE_NS) {
        say_waiting(s, m);
    } else if (s->has_data && s->is_unheard) {
        say(m, "%s sends data, but does not answer when asked for its status",
            s->address);
    }
}

const char *sentry_message(const struct sentry *sentry, int64_t now_ns,
                           char *out, size_t room)
{
    struct message m = {.out = out, .room = room};
    *out = '\0';
    say_data(sentry, now_ns, &m);
    if (!sentry_is_silent(sentry, now_ns) && !sentry->is_unheard) {
        say_laser(sentry, &m);
        say_hazards(sentry, &m);
    }
    return out;
}
