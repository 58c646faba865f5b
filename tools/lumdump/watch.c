#include "watch.h"

#include "../common/laser_bits.h"
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

/* A run that was held up for so long sends no laser on: its heartbeats have
 * ended, and nobody may expect it any more. */
#define HELD_UP_NS (2 * SECOND_NS)

void watch_begin(struct watch *watch, struct say *say, lum_sensor *sensor,
                 const lum_layout *layout, bool laser, int64_t now_ns)
{
    *watch = (struct watch){.say = say,
                            .sensor = sensor,
                            .layout = layout,
                            .laser = laser ? WATCH_ASKED : WATCH_UNTOUCHED,
                            .began_ns = now_ns,
                            .tick_ns = now_ns,
                            .next_ns = now_ns};
    (void)number_format_address(lum_sensor_endpoint(sensor).address,
                                watch->address);
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
            laser_bits_name(hazards, LUM_LASER_HAZARDS, names, sizeof names));
    }
}

/* Hazards that heartbeats do not end. */
static unsigned lasting_hazards(uint16_t status)
{
    return status & LUM_LASER_HAZARDS & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT;
}

/* The laser is down and has to stay so: where the command "on" still stands, it
 * would come up with the hazard's end. */
static void leave_down(struct watch *watch, uint16_t status, const char *what)
{
    char names[256];
    watch->laser = WATCH_DOWN;
    watch->off_due = (status & LUM_LASER_TLV_CMD_OFF) == 0;
    watch->next_ns = watch->off_due ? 0 : watch->next_ns;
    say_warn(watch->say,
             "the laser of %s %s (%s); it is not switched on again by itself: "
             "when that is safe, lumctl --host %s laser on; the recording goes "
             "on",
             watch->address, what,
             laser_bits_name(status, LUM_LASER_ALL_DOWN, names, sizeof names),
             watch->address);
}

/* What a laser does that was given up. Another program may switch it on; where
 * a hazard refuses that, the command must not stand either. */
static void follow_down(struct watch *watch, uint16_t status)
{
    if (lasting_hazards(status) != 0 && (status & LUM_LASER_TLV_CMD_OFF) == 0) {
        watch->off_due = true;
    } else if (!lum_laser_is_down(status) && !watch->off_due) {
        watch->laser = WATCH_UP;
        say_warn(watch->say, "the laser of %s is on", watch->address);
    }
}

/* The laser of a run that was asked for it goes and comes. */
static void follow_laser(struct watch *watch, uint16_t status)
{
    if (watch->laser == WATCH_UP && lum_laser_is_down(status)) {
        leave_down(watch, status, "went off");
    } else if (watch->laser == WATCH_DOWN || watch->laser == WATCH_GIVEN_UP) {
        follow_down(watch, status);
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
    if (!lum_laser_is_down(status)) {
        watch->laser = WATCH_UP;
    } else if (lasting_hazards(status) == 0 && watch->attempts < ATTEMPTS_MAX) {
        watch->next_ns = now_ns + AGAIN_NS;
    } else {
        leave_down(watch, status, "stays down");
    }
}

/* It can be neither seen nor trusted. */
static void give_up(struct watch *watch)
{
    watch->laser = WATCH_GIVEN_UP;
    watch->off_due = true;
    watch->next_ns = 0;
}

/* The answer to a request for the laser. */
static void judge_answer(struct watch *watch, enum watch_request request,
                         const lum_sensor_event *event, int64_t now_ns)
{
    if (request == WATCH_OFF) {
        watch->off_due = event->has_status && !lum_laser_is_down(event->status);
    } else if (request == WATCH_ON && event->has_status) {
        judge_laser(watch, event->status, now_ns);
    } else if (request == WATCH_ON) {
        give_up(watch);
        say_warn(watch->say,
                 "%s answered to laser on without a status: whether it is on "
                 "is not known, so it is switched off (see tlv: in the wire "
                 "profile)",
                 watch->address);
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
    const enum watch_request request = watch->request;
    watch->request = WATCH_LOOK;
    watch->is_unheard = false;
    show_texts(watch, event->tlvs);
    if (event->has_status) {
        note_status(watch, event->status, now_ns);
    }
    judge_answer(watch, request, event, now_ns);
}

/* Laser on is asked for again, until it is given up. */
static void take_no_laser(struct watch *watch, const lum_sensor_event *event,
                          int64_t now_ns)
{
    if (now_ns - watch->began_ns >= GIVE_UP_NS) {
        give_up(watch);
        say_warn(watch->say,
                 "%s did not answer to laser on (sent %u times): it is "
                 "switched off; look with lumctl --host %s status",
                 watch->address, event->tries, watch->address);
    }
}

/* Laser off is asked for again and again. */
static void take_no_off(struct watch *watch)
{
    if (!watch->told_off_due) {
        watch->told_off_due = true;
        say_warn(watch->say,
                 "%s does not answer to laser off: until it does, its laser "
                 "may come on by itself when the hazard ends",
                 watch->address);
    }
}

static void take_no_answer(struct watch *watch, const lum_sensor_event *event,
                           int64_t now_ns)
{
    const bool has_data =
        watch->has_data && now_ns - watch->data_ns < SECOND_NS;
    const enum watch_request request = watch->request;
    watch->request = WATCH_LOOK;
    if (request == WATCH_ON) {
        take_no_laser(watch, event, now_ns);
    } else if (request == WATCH_OFF) {
        take_no_off(watch);
    } else if (has_data && !watch->is_unheard) {
        watch->is_unheard = true;
        say_warn(watch->say,
                 "%s sends data, but does not answer when asked for its status",
                 watch->address);
    }
}

/* It may be older than what is known, so the sensor is asked. A hazard counts
 * at once: it may be over before the answer. */
static void take_alert(struct watch *watch, const lum_sensor_event *event,
                       int64_t now_ns)
{
    watch->next_ns = now_ns;
    show_texts(watch, event->tlvs);
    if (event->has_status && watch->laser == WATCH_UP &&
        lasting_hazards(event->status) != 0) {
        leave_down(watch, event->status, "went off");
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
        take_alert(watch, event, now_ns);
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

static enum watch_request next_request(const struct watch *watch)
{
    if (watch->laser == WATCH_ASKED) {
        return WATCH_ON;
    }
    return watch->off_due ? WATCH_OFF : WATCH_LOOK;
}

static void ask(struct watch *watch, int64_t now_ns)
{
    const enum watch_request request = next_request(watch);
    const lum_result r =
        request == WATCH_LOOK
            ? lum_sensor_request(watch->sensor, NULL, 0)
            : lum_sensor_command(watch->sensor,
                                 request == WATCH_ON ? "u" : "d");
    if (r == LUM_OK) {
        watch->request = request;
        watch->attempts += request == WATCH_ON ? 1u : 0u;
        watch->next_ns = now_ns + POLL_NS;
    }
}

static void watch_pauses(struct watch *watch, int64_t now_ns)
{
    const int64_t since_ns = now_ns - watch->tick_ns;
    watch->tick_ns = now_ns;
    if (watch->laser == WATCH_ASKED && since_ns >= HELD_UP_NS) {
        give_up(watch);
        say_warn(watch->say,
                 "this run was held up for %.1f s while it switched the laser "
                 "of %s on: it is switched off",
                 (double)since_ns * 1e-9, watch->address);
    }
}

void watch_tick(struct watch *watch, int64_t now_ns)
{
    watch_pauses(watch, now_ns);
    watch_silence(watch, now_ns);
    if (now_ns >= watch->next_ns && !lum_sensor_is_waiting(watch->sensor)) {
        ask(watch, now_ns);
    }
}

/* Data comes, so heartbeats arrive, whatever an early status says of them. */
bool watch_darkness(const struct watch *watch, char *out, size_t room)
{
    char names[256];
    const unsigned hazards = lasting_hazards(watch->status);
    if (!watch->has_status || !lum_laser_is_down(watch->status)) {
        return false;
    }
    if (hazards != 0) {
        (void)snprintf(out, room, "a hazard keeps the laser down: %s",
                       laser_bits_name(watch->status, (uint16_t)hazards, names,
                                       sizeof names));
    } else if (watch->laser == WATCH_UNTOUCHED) {
        (void)snprintf(out, room,
                       "the laser is off: use --laser, or switch it on by "
                       "lumctl --host %s laser on",
                       watch->address);
    } else {
        (void)snprintf(out, room, "the laser went off, or did not come on");
    }
    return true;
}

const char *watch_laser_text(const struct watch *watch)
{
    if (!watch->has_status) {
        return "laser ?";
    }
    return lum_laser_is_down(watch->status) ? "laser off" : "laser on";
}
