#include "watch.h"

#include "../common/number.h"
#include "../common/printable.h"
#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

#define POLL_NS    SECOND_NS
#define SILENCE_NS (3 * SECOND_NS)

/* A sensor that has just got its first heartbeat may still refuse the laser for
 * want of one. */
#define AGAIN_NS     (SECOND_NS / 5)
#define ATTEMPTS_MAX 20u
#define GIVE_UP_NS   (5 * SECOND_NS)

#define TEXTS_MAX 20u

void watch_begin(struct watch *watch, struct say *say, lum_sensor *sensor,
                 const lum_layout *layout, bool laser, int64_t now_ns)
{
    *watch = (struct watch){.say = say,
                            .sensor = sensor,
                            .layout = layout,
                            .laser = laser ? WATCH_ASKED : WATCH_UNTOUCHED,
                            .began_ns = now_ns,
                            .next_ns = now_ns};
    (void)number_format_address(lum_sensor_endpoint(sensor).address,
                                watch->address);
}

const char *watch_name_bits(uint16_t status, uint16_t mask, char *out,
                            size_t room)
{
    size_t len = 0;
    (void)snprintf(out, room, "none");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if (((unsigned)(status & mask) >> bit & 1u) != 0 && len < room) {
            const int n = snprintf(out + len, room - len, "%s%s",
                                   len > 0 ? " " : "", lum_laser_bit_name(bit));
            len += n > 0 ? (size_t)n : 0;
        }
    }
    return out;
}

static void warn_of_hazards(struct watch *watch, uint16_t status,
                            int64_t now_ns)
{
    char names[256];
    const bool begins = now_ns - watch->began_ns < SECOND_NS;
    uint16_t hazards =
        (uint16_t)(status & LUM_LASER_HAZARDS & (uint16_t)~watch->told);
    if (begins) {
        hazards &= (uint16_t)~LUM_LASER_HEARTBEAT_TIMEOUT;
    }
    if (hazards != 0) {
        watch->told |= hazards;
        say_warn(
            watch->say, "%s reports a hazard: %s", watch->address,
            watch_name_bits(hazards, LUM_LASER_HAZARDS, names, sizeof names));
    }
}

/* The laser of a run that was asked for it goes and comes. */
static void follow_laser(struct watch *watch, uint16_t status)
{
    char names[256];
    const bool is_down = lum_laser_is_down(status);
    if (watch->laser == WATCH_UP && is_down) {
        watch->laser = WATCH_DOWN;
        say_warn(
            watch->say,
            "the laser of %s went off (%s); it is not switched on again "
            "by itself: when that is safe, lumctl --host %s laser on",
            watch->address,
            watch_name_bits(status, LUM_LASER_ALL_DOWN, names, sizeof names),
            watch->address);
    } else if ((watch->laser == WATCH_DOWN || watch->laser == WATCH_GIVEN_UP) &&
               !is_down) {
        watch->laser = WATCH_UP;
        say_warn(watch->say, "the laser of %s is on", watch->address);
    }
}

static void note_status(struct watch *watch, uint16_t status, int64_t now_ns)
{
    watch->has_status = true;
    watch->status = status;
    warn_of_hazards(watch, status, now_ns);
    follow_laser(watch, status);
}

/* The answer to `u`. */
static void judge_laser(struct watch *watch, uint16_t status, int64_t now_ns)
{
    char names[256];
    const unsigned hazards =
        status & LUM_LASER_HAZARDS & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT;
    if (!lum_laser_is_down(status)) {
        watch->laser = WATCH_UP;
    } else if (hazards == 0 && watch->attempts < ATTEMPTS_MAX) {
        watch->next_ns = now_ns + AGAIN_NS;
    } else {
        watch->laser = WATCH_DOWN;
        say_warn(
            watch->say,
            "the laser of %s stays down (%s); the recording goes on",
            watch->address,
            watch_name_bits(status, LUM_LASER_ALL_DOWN, names, sizeof names));
    }
}

static void show_text(struct watch *watch, const lum_tlv *tlv)
{
    char text[256];
    if (watch->texts >= TEXTS_MAX) {
        return;
    }
    watch->texts++;
    say_warn(watch->say, "%s says: %s%s", watch->address,
             printable(tlv->value, tlv->length, text, sizeof text),
             watch->texts == TEXTS_MAX ? " (more of this is not shown)" : "");
}

static void show_texts(struct watch *watch, lum_tlv_reader tlvs)
{
    const uint16_t debug = watch->layout->profile.tlv[LUM_TLV_DEBUG];
    lum_tlv tlv;
    while (lum_tlv_next(&tlvs, &tlv) == LUM_OK) {
        if (tlv.type == debug) {
            show_text(watch, &tlv);
        }
    }
}

static void take_answer(struct watch *watch, const lum_sensor_event *event,
                        int64_t now_ns)
{
    const bool was_laser = watch->asks_for_laser;
    watch->asks_for_laser = false;
    watch->is_unheard = false;
    show_texts(watch, event->tlvs);
    if (event->has_status) {
        note_status(watch, event->status, now_ns);
    }
    if (was_laser && event->has_status) {
        judge_laser(watch, event->status, now_ns);
    } else if (was_laser) {
        watch->laser = WATCH_GIVEN_UP;
        say_warn(watch->say,
                 "%s answered to laser on without a status: whether it is on "
                 "is not known (see tlv: in the wire profile)",
                 watch->address);
    }
}

static void take_no_answer(struct watch *watch, const lum_sensor_event *event,
                           int64_t now_ns)
{
    const bool has_data =
        watch->has_data && now_ns - watch->data_ns < SECOND_NS;
    if (watch->asks_for_laser) {
        watch->asks_for_laser = false;
        if (now_ns - watch->began_ns >= GIVE_UP_NS) {
            watch->laser = WATCH_GIVEN_UP;
            say_warn(watch->say,
                     "%s did not answer to laser on (sent %u times); look with "
                     "lumctl --host %s status",
                     watch->address, event->tries, watch->address);
        }
    } else if (has_data && !watch->is_unheard) {
        watch->is_unheard = true;
        say_warn(watch->say,
                 "%s sends data, but does not answer when asked for its status",
                 watch->address);
    }
}

static void take_link(struct watch *watch, const lum_sensor_event *event)
{
    if (event->is_up) {
        say_warn(watch->say, "sending to %s works again", watch->address);
    } else {
        say_warn(watch->say,
                 "sending to %s fails: %s; it is tried again and again",
                 watch->address, event->error.text);
    }
}

void watch_take(struct watch *watch, const lum_sensor_event *event,
                int64_t now_ns)
{
    switch (event->kind) {
    case LUM_SENSOR_ANSWER:
        take_answer(watch, event, now_ns);
        break;
    case LUM_SENSOR_ALERT:
        /* it may be older than what is known: ask */
        watch->next_ns = now_ns;
        show_texts(watch, event->tlvs);
        break;
    case LUM_SENSOR_NO_ANSWER:
        take_no_answer(watch, event, now_ns);
        break;
    case LUM_SENSOR_LINK:
        take_link(watch, event);
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

void watch_note_data(struct watch *watch, int64_t now_ns)
{
    if (watch->is_silent) {
        watch->is_silent = false;
        say_warn(watch->say, "data from %s again, after %.1f s without",
                 watch->address, (double)(now_ns - watch->data_ns) * 1e-9);
    }
    watch->has_data = true;
    watch->data_ns = now_ns;
}

static void watch_silence(struct watch *watch, int64_t now_ns)
{
    if (watch->has_data && !watch->is_silent &&
        now_ns - watch->data_ns >= SILENCE_NS) {
        watch->is_silent = true;
        say_warn(watch->say,
                 "no data from %s for 3 s; heartbeats go on, waiting (a sensor "
                 "that was restarted is at 10.42.0.37 again; lumctl --host %s "
                 "doctor finds out more)",
                 watch->address, watch->address);
    }
}

static void ask(struct watch *watch, int64_t now_ns)
{
    const bool wants_laser = watch->laser == WATCH_ASKED;
    const lum_result r = wants_laser
                             ? lum_sensor_command(watch->sensor, "u")
                             : lum_sensor_request(watch->sensor, NULL, 0);
    if (r == LUM_OK) {
        watch->asks_for_laser = wants_laser;
        watch->attempts += wants_laser ? 1u : 0u;
        watch->next_ns = now_ns + POLL_NS;
    }
}

void watch_tick(struct watch *watch, int64_t now_ns)
{
    watch_silence(watch, now_ns);
    if (now_ns >= watch->next_ns && !lum_sensor_is_waiting(watch->sensor)) {
        ask(watch, now_ns);
    }
}

const char *watch_laser_text(const struct watch *watch)
{
    if (!watch->has_status) {
        return "laser ?";
    }
    return lum_laser_is_down(watch->status) ? "laser off" : "laser on";
}
