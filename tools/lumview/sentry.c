#include "sentry.h"

#include "../common/laser_bits.h"
#include "../common/number.h"
#include "lum/laser.h"

#include <stdarg.h>
#include <stdio.h>

#define SECOND_NS INT64_C(1000000000)

#define SILENCE_NS (LUM_SENSOR_SILENCE_MS * INT64_C(1000000))

/* Something that takes this long is reported. */
#define PATIENCE_NS (3 * SECOND_NS)

void sentry_begin(struct sentry *sentry, lum_sensor *sensor,
                  enum laser_fate laser, int64_t now_ns)
{
    *sentry = (struct sentry){.sensor = sensor};
    laser_keeper_begin(&sentry->laser, laser, now_ns);
    (void)number_format_address(lum_sensor_endpoint(sensor).address,
                                sentry->address);
}

static void take_link(struct sentry *s, const lum_sensor_event *event)
{
    s->is_cut_off = !event->is_up;
    if (s->is_cut_off) {
        (void)snprintf(s->why, sizeof s->why, "%.*s", (int)sizeof s->why - 1,
                       event->error.text);
    }
}

static void note_news(struct sentry *s, enum laser_news news)
{
    s->news = news != LASER_NO_NEWS ? news : s->news;
}

void sentry_take(struct sentry *sentry, const lum_sensor_event *event,
                 int64_t now_ns)
{
    switch (event->kind) {
    case LUM_SENSOR_ANSWER:
        sentry->is_unheard = false;
        break;
    case LUM_SENSOR_NO_ANSWER:
        sentry->is_unheard = true;
        break;
    case LUM_SENSOR_LINK:
        take_link(sentry, event);
        break;
    case LUM_SENSOR_IDLE:
    case LUM_SENSOR_CANCELLED:
    case LUM_SENSOR_DATAGRAMS:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_ALERT:
    case LUM_SENSOR_FAILED:
        break;
    }
    note_news(sentry, laser_keeper_take(&sentry->laser, event, now_ns));
}

void sentry_tick(struct sentry *sentry, int64_t now_ns)
{
    note_news(sentry, laser_keeper_tick(&sentry->laser, now_ns));
    laser_keeper_ask(&sentry->laser, sentry->sensor, now_ns);
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

/* Why the laser was given up; names has the bits with which. */
static const char *name_news(enum laser_news news, const char *names)
{
    switch (news) {
    case LASER_HELD_UP:
        return "lumview was held up while it switched it on";
    case LASER_UNSEEN:
        return "the answer to on had no status (tlv.status of the profile)";
    case LASER_UNANSWERED:
        return "no answer to on";
    case LASER_NO_NEWS: /* its socket broke */
    case LASER_WENT_OFF:
    case LASER_STAYS_DOWN:
    case LASER_CAME_UP:
    default:
        return names[0] != '\0' ? names : "no heartbeats";
    }
}

static void say_laser(const struct sentry *s, struct message *m)
{
    char names[200] = "";
    const struct laser_keeper *laser = &s->laser;
    if (laser->fate == LASER_UNTOUCHED && laser->has_status &&
        lum_laser_is_down(laser->status)) {
        say(m,
            "the laser is off: start lumview with --laser, or: lumctl --host "
            "%s laser on",
            s->address);
    } else if (laser->fate == LASER_DOWN) {
        if (laser->fell != 0) {
            laser_bits_name(laser->fell, LUM_LASER_ALL_DOWN, names,
                            sizeof names);
        }
        say(m,
            "the laser %s (%s); it is left so: when it is safe, lumctl --host "
            "%s laser on",
            laser->off_due ? "is being switched off" : "is down",
            name_news(s->news, names), s->address);
    }
}

/* A laser that is to be off, and does not say so. */
static void say_laser_unheard(const struct sentry *s, struct message *m)
{
    if (s->laser.fate == LASER_DOWN && s->laser.off_due) {
        say(m,
            "%s does not answer to laser off: until it does, its laser may be "
            "on, or come on by itself when a hazard ends",
            s->address);
    }
}

static void say_hazards(const struct laser_keeper *laser, const char *address,
                        struct message *m)
{
    char names[200];
    if (laser->has_status && lum_laser_has_hazard(laser->status)) {
        laser_bits_name(laser->status, LUM_LASER_HAZARDS, names, sizeof names);
        say(m, "%s reports a hazard: %s", address, names);
    }
}

static void say_waiting(const struct sentry *s, struct message *m)
{
    if (s->has_unknown) {
        say(m,
            "%s sends packets, and none of them fits the layout: is a "
            "--profile needed?",
            s->address);
    } else if (s->laser.has_status) {
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

static void say_move(lum_endpoint to, const char *address, struct message *m)
{
    char new[16];
    (void)number_format_address(to.address, new);
    say(m,
        "the data comes from %s now, not from %s: the sensor has got that "
        "address. It ends in 3 s, since the heartbeats go to %s: start lumview "
        "udp://%s",
        new, address, address, new);
}

static void say_data(const struct sentry *s, int64_t now_ns, struct message *m)
{
    lum_endpoint new = {0, 0};
    if (lum_sensor_moved_to(s->sensor, &new)) {
        say_move(new, s->address, m);
    } else if (s->is_cut_off) {
        say(m, "sending to %s fails: %s", s->address, s->why);
    } else if (sentry_is_silent(s, now_ns)) {
        say(m,
            "no data from %s for %u s, waiting (a sensor that was restarted is "
            "at 10.42.0.37 again; lumctl --host %s doctor finds out more)",
            s->address, LUM_SENSOR_SILENCE_MS / 1000u, s->address);
    } else if (!s->has_data && now_ns - s->laser.began_ns >= PATIENCE_NS) {
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
    if (sentry->is_unheard) {
        say_laser_unheard(sentry, &m);
    } else if (!sentry_is_silent(sentry, now_ns)) {
        say_laser(sentry, &m);
        say_hazards(&sentry->laser, sentry->address, &m);
    }
    return out;
}
