#include "watch.h"

#include "../common/laser_bits.h"
#include "../common/number.h"
#include "../common/printable.h"
#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

#define SILENCE_NS (LUM_SENSOR_SILENCE_MS * INT64_C(1000000))

#define TEXTS_MAX 20u

void watch_begin(struct watch *watch, struct say *say, lum_sensor *sensor,
                 const lum_layout *layout, bool laser, int64_t now_ns)
{
    *watch = (struct watch){.say = say, .sensor = sensor, .layout = layout};
    laser_keeper_begin(&watch->laser, laser ? LASER_ASKED : LASER_UNTOUCHED,
                       now_ns);
    (void)number_format_address(lum_sensor_endpoint(sensor).address,
                                watch->address);
}

static void warn_of_hazards(struct watch *watch, uint16_t status,
                            int64_t now_ns)
{
    char names[256];
    const bool begins = now_ns - watch->laser.began_ns < SECOND_NS;
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

static void warn_of_laser(struct watch *watch, const char *what)
{
    char names[256];
    say_warn(watch->say,
             "the laser of %s %s (%s%s); it is not switched on again "
             "automatically: when it is safe, run lumctl --host %s laser on; "
             "the recording continues",
             watch->address, what,
             laser_bits_name(watch->laser.fell, LUM_LASER_ALL_DOWN, names,
                             sizeof names),
             laser_bits_cause(watch->laser.fell), watch->address);
}

/* tries: how often the request was sent that this is the end of. */
static void tell(struct watch *watch, enum laser_news news, unsigned tries)
{
    switch (news) {
    case LASER_WENT_OFF:
        warn_of_laser(watch, "went off");
        break;
    case LASER_STAYS_DOWN:
        warn_of_laser(watch, "stays down");
        break;
    case LASER_CAME_UP:
        say_warn(watch->say, "the laser of %s is on", watch->address);
        break;
    case LASER_UNSEEN:
        say_warn(watch->say,
                 "%s answered to laser on without a status: whether it is on "
                 "is not known, so it is switched off (see tlv: in the wire "
                 "profile)",
                 watch->address);
        break;
    case LASER_UNANSWERED:
        say_warn(watch->say,
                 "%s did not answer to laser on (sent %u times): it is "
                 "switched off; look with lumctl --host %s status",
                 watch->address, tries, watch->address);
        break;
    case LASER_HELD_UP:
        say_warn(watch->say,
                 "this run was held up for %.1f s while it switched the laser "
                 "of %s on: it is switched off",
                 (double)watch->laser.held_up_ns * 1e-9, watch->address);
        break;
    case LASER_NO_NEWS:
    default:
        break;
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
    watch->is_unheard = false;
    watch->told_off_due = false;
    show_texts(watch, event->tlvs);
    if (event->has_status) {
        warn_of_hazards(watch, event->status, now_ns);
    }
}

/* Laser off is sent repeatedly. */
static void take_no_off(struct watch *watch)
{
    if (!watch->told_off_due) {
        watch->told_off_due = true;
        say_warn(watch->say,
                 "%s does not answer to laser off: until it does, its laser "
                 "may be on, or come on by itself when a hazard ends",
                 watch->address);
    }
}

static void take_no_answer(struct watch *watch, int64_t now_ns)
{
    const bool has_data =
        watch->has_data && now_ns - watch->data_ns < SECOND_NS;
    if (watch->laser.request == LASER_ASK_OFF) {
        take_no_off(watch);
    } else if (watch->laser.request == LASER_ASK_LOOK && has_data &&
               !watch->is_unheard) {
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
        show_texts(watch, event->tlvs);
        break;
    case LUM_SENSOR_NO_ANSWER:
        take_no_answer(watch, now_ns);
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
    tell(watch, laser_keeper_take(&watch->laser, event, now_ns), event->tries);
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

void watch_end(struct watch *watch, int64_t now_ns)
{
    const int64_t ns = now_ns - watch->data_ns;
    watch->silent_ns = watch->has_data && ns >= WATCH_PAUSE_NS ? ns : 0;
}

static void watch_move(struct watch *watch)
{
    char new[16];
    lum_endpoint to = {0, 0};
    const bool is_moved = lum_sensor_moved_to(watch->sensor, &to);
    if (is_moved && !watch->told_move) {
        (void)number_format_address(to.address, new);
        say_warn(watch->say,
                 "the data comes from %s now, not from %s: the sensor has got "
                 "that address. It is not recorded, and ends in 3 s, since the "
                 "heartbeats go to %s: end this run, and say udp://%s",
                 new, watch->address, watch->address, new);
    }
    watch->told_move = is_moved;
}

static void watch_silence(struct watch *watch, int64_t now_ns)
{
    if (watch->has_data && !watch->told_move && !watch->is_silent &&
        now_ns - watch->data_ns >= SILENCE_NS) {
        watch->is_silent = true;
        say_warn(
            watch->say,
            "no data from %s for %u s; heartbeats go on, waiting (a sensor "
            "that was restarted is at 10.42.0.37 again; lumctl --host %s "
            "doctor finds out more)",
            watch->address, LUM_SENSOR_SILENCE_MS / 1000u, watch->address);
    }
}

void watch_tick(struct watch *watch, int64_t now_ns)
{
    tell(watch, laser_keeper_tick(&watch->laser, now_ns), 0);
    watch_move(watch);
    watch_silence(watch, now_ns);
    laser_keeper_ask(&watch->laser, watch->sensor, now_ns);
}

/* Data comes, so heartbeats arrive, even if an early status says otherwise. */
bool watch_darkness(const struct watch *watch, char *out, size_t room)
{
    char names[256];
    const uint16_t status = watch->laser.status;
    const unsigned hazards = laser_keeper_hazards(status);
    if (!watch->laser.has_status || !lum_laser_is_down(status)) {
        return false;
    }
    if (hazards != 0) {
        (void)snprintf(
            out, room, "a hazard keeps the laser down: %s",
            laser_bits_name(status, (uint16_t)hazards, names, sizeof names));
    } else if (watch->laser.fate == LASER_UNTOUCHED) {
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
    if (!watch->laser.has_status) {
        return "laser ?";
    }
    return lum_laser_is_down(watch->laser.status) ? "laser off" : "laser on";
}
