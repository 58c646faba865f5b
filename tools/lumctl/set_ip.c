/* The command set-ip: another address, and a look where the sensor is. */
#include "ctl.h"

#include "../common/host.h"
#include "../common/json.h"
#include "../common/number.h"
#include "ctl_session.h"
#include "options.h"
#include "remember.h"
#include "set_ip_check.h"

#include "lum/base/time.h"

#include <stdio.h>

#define MS_NS       INT64_C(1000000)
#define ROUNDS_MIN  7u /* of sending and looking */
#define LOOK_MIN_MS 5000u
#define ROUND_NS    (200 * MS_NS) /* at least, where sending fails */
#define LOOKS_NEW   3u            /* tries at the new address in each round */
#define LOOKS_ELSE  4u
#define LOOK_MS     200u
#define FIRST_MS    100u /* before anything is sent */
#define FIRST       3u
#define SLOT_NS     (50 * MS_NS) /* longest time without serving a session */

/* Where a sensor has been seen to answer. */
enum found {
    FOUND_NOWHERE,
    FOUND_NEW,
    FOUND_OLD,
    FOUND_REVERSED
};

static const char *const found_names[] = {"nowhere", "new", "old", "reversed"};

struct move {
    struct ctl *ctl;
    lum_endpoint old;
    lum_endpoint new;
    lum_endpoint reversed;
    struct arp_answers sensor; /* the hardware at the old address, if known */
    lum_error error; /* why the new address could not be looked at; may be
                        empty */
};

/* --- Asking the sensor at an address --- */

static lum_endpoint reverse(lum_endpoint host)
{
    const uint32_t a = host.address;
    const lum_endpoint out = {a << 24 | (a << 8 & 0xff0000u) |
                                  (a >> 8 & 0xff00u) | a >> 24,
                              host.port};
    return out;
}

/* The session of a shell continues: it may own the sensor. */
static bool await_time(struct ctl *ctl, lum_sensor *sensor, lum_error *error)
{
    lum_sensor_event event;
    if (lum_sensor_request_time(sensor) != LUM_OK) {
        return false;
    }
    do {
        session_keep_alive(ctl);
        lum_sensor_receive(sensor, lum_time_monotonic_ns() + SLOT_NS, &event);
        if (event.kind == LUM_SENSOR_LINK && !event.is_up) {
            *error = event.error;
        }
    } while (
        event.kind != LUM_SENSOR_TIME && event.kind != LUM_SENSOR_NO_ANSWER &&
        event.kind != LUM_SENSOR_CANCELLED && event.kind != LUM_SENSOR_FAILED);
    return event.kind == LUM_SENSOR_TIME;
}

/* Whether somebody answers a timestamp there. */
static bool answers(struct move *m, lum_endpoint host, unsigned tries,
                    uint32_t try_ms)
{
    struct ctl looking = *m->ctl;
    lum_sensor *sensor = NULL;
    lum_error other = {""};
    lum_error *error = host.address == m->new.address ? &m->error : &other;
    looking.options.requests.timeout_ms = try_ms;
    looking.options.requests.retries = tries - 1;
    if (lum_cancel_is_raised(m->ctl->cancel) ||
        session_try(&looking, host, false, &sensor, error) != LUM_NET_OK) {
        return false;
    }
    const bool has_answered = await_time(m->ctl, sensor, error);
    lum_sensor_close(sensor);
    return has_answered;
}

static bool is_alive(struct move *m, lum_endpoint host, unsigned tries)
{
    return answers(m, host, tries, LOOK_MS);
}

static enum exit_status send_once(const struct move *m)
{
    lum_error error = {""};
    if (lum_sensor_set_ip(m->ctl->sensor, m->new.address, &error) !=
        LUM_NET_OK) {
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    return EXIT_DONE;
}

/* --- Before: may it have the address --- */

/* An answer at the new address proves a move only if nobody answered there
 * before; also, two sensors with one address could not be distinguished any
 * more. */
static bool is_taken(struct move *m)
{
    const bool is_other = m->new.address != m->old.address;
    return is_other && answers(m, m->new, FIRST, FIRST_MS);
}

static enum exit_status complain_taken(struct move *m)
{
    if (!is_alive(m, m->old, LOOKS_ELSE)) {
        return ctl_complain(EXIT_FAILED,
                            "%s answers already; nothing was sent. If that is "
                            "your sensor, say --host %s; if it is another, "
                            "choose another address",
                            session_name(m->new).text,
                            session_name(m->new).text);
    }
    return ctl_complain(EXIT_FAILED,
                        "another sensor has %s already, beside the one at %s: "
                        "nothing was sent; choose another address",
                        session_name(m->new).text, session_name(m->old).text);
}

/* The device with the old address is the sensor, even if another one answers at
 * the new address. */
static void learn_sensor(struct move *m)
{
    m->sensor = (struct arp_answers){0};
    if (m->new.address != m->old.address &&
        set_ip_can_search(m->ctl, m->old.address)) {
        (void)is_alive(m, m->old, 1); /* for the kernel's table */
        set_ip_search(m->ctl, m->old.address, &m->sensor);
    }
}

/* Another device at the new address, sensor or not. */
static bool find_other(struct move *m, struct arp_answers *who,
                       char mac[INTERFACE_MAC_TEXT_BYTES])
{
    const char *other = NULL;
    if (m->new.address != m->old.address &&
        set_ip_can_search(m->ctl, m->new.address)) {
        set_ip_search(m->ctl, m->new.address, who);
        other = set_ip_other(who, &m->sensor);
    }
    if (other != NULL) {
        (void)snprintf(mac, INTERFACE_MAC_TEXT_BYTES, "%s", other);
    }
    return other != NULL;
}

/* What is sent to the sensor there would go to the other device. */
static enum exit_status check_others(struct move *m)
{
    struct arp_answers who;
    char mac[INTERFACE_MAC_TEXT_BYTES];
    if (m->ctl->options.force || !find_other(m, &who, mac)) {
        return EXIT_DONE;
    }
    return ctl_complain(EXIT_BAD,
                        "set-ip: another device has %s (%s%s), and the sensor "
                        "would be unreachable: nothing was sent. Choose "
                        "another address; --force sends it anyway",
                        number_address(m->new.address).text, mac,
                        who.is_heard ? "" : ", as this host's ARP table says");
}

/* --- Moving it --- */

/* How long to search for the sensor: as long as all tries of a request take. */
static uint32_t look_ms(const struct move *m)
{
    const struct request_options *o = &m->ctl->options.requests;
    const uint64_t ms = (uint64_t)o->timeout_ms * (o->retries + 1u);
    return ms > LOOK_MIN_MS ? (uint32_t)ms : LOOK_MIN_MS;
}

/* Sends, and looks where the sensor is. It is sent again only while the sensor
 * still answers at the old address: then the packet was lost. */
static enum exit_status carry_out(struct move *m, enum found *found)
{
    bool is_old = true;
    int64_t now = lum_time_monotonic_ns();
    const int64_t end = now + look_ms(m) * MS_NS;
    *found = FOUND_NOWHERE;
    for (unsigned round = 0; (round < ROUNDS_MIN || now < end) &&
                             !lum_cancel_is_raised(m->ctl->cancel);
         round++) {
        const int64_t next = now + ROUND_NS;
        const enum exit_status sent = is_old ? send_once(m) : EXIT_DONE;
        if (sent != EXIT_DONE) {
            return sent;
        }
        if (is_alive(m, m->new, LOOKS_NEW)) {
            *found = FOUND_NEW;
            return EXIT_DONE;
        }
        is_old = is_alive(m, m->old, 1);
        now = lum_time_monotonic_ns();
        if (now < next) {
            session_rest(m->ctl, next - now);
            now = lum_time_monotonic_ns();
        }
    }
    if (is_old || is_alive(m, m->old, LOOKS_ELSE)) {
        *found = FOUND_OLD;
    } else if (lum_address_is_host(m->reversed.address) &&
               is_alive(m, m->reversed, LOOKS_ELSE)) {
        *found = FOUND_REVERSED;
    }
    return EXIT_DONE;
}

/* A shell continues at the new address. */
static enum exit_status follow(struct move *m)
{
    return m->ctl->in_shell ? session_change(m->ctl, m->new, m->ctl->owns)
                            : EXIT_DONE;
}

/* --- What is shown --- */

static void print(const struct move *m, enum found found)
{
    const struct session_name name = session_name(m->new);
    struct json json;
    if (m->ctl->options.json) {
        json_begin_line(&json, stdout);
        json_text(&json, "sensor", session_name(m->old).text);
        json_text(&json, "address", name.text);
        json_bool(&json, "done", found == FOUND_NEW);
        json_text(&json, "answers_at", found_names[found]);
        json_end_line(&json);
    } else if (found == FOUND_NEW) {
        (void)printf("%s: the sensor answers there now; %s%s\n", name.text,
                     m->ctl->in_shell ? "this shell goes on with "
                                      : "from now on say --host ",
                     name.text);
    }
}

static enum exit_status complain_reversed(const struct move *m)
{
    return ctl_complain(
        EXIT_FAILED,
        "the sensor took the bytes in the other order and is at %s now: write "
        "'version: 1' and 'set_ip_order: %s' to a file, and run "
        "%s --profile FILE set-ip %s",
        session_name(m->reversed).text,
        m->ctl->layout.profile.set_ip_order == LUM_SET_IP_NETWORK ? "little"
                                                                  : "network",
        session_ctl(m->ctl, m->reversed).text, session_name(m->new).text);
}

static enum exit_status complain_nowhere(struct move *m)
{
    struct arp_answers who;
    char mac[INTERFACE_MAC_TEXT_BYTES];
    const bool has_reversed = lum_address_is_host(m->reversed.address);
    if (m->error.text[0] != '\0') {
        (void)ctl_complain(EXIT_FAILED, "%s", m->error.text);
    }
    if (find_other(m, &who, mac)) {
        (void)ctl_complain(EXIT_FAILED,
                           "another device has %s (%s): what is sent there "
                           "may reach that one instead of the sensor",
                           number_address(m->new.address).text, mac);
    }
    return ctl_complain(
        EXIT_NO_ANSWER,
        "nobody answers at %s, nor at %s%s%s. The packet may still have "
        "arrived, and only its answers were lost. To find out why: %s doctor. "
        "After a power cycle the sensor is at 10.42.0.37",
        session_name(m->new).text, session_name(m->old).text,
        has_reversed ? " or " : "",
        has_reversed ? session_name(m->reversed).text : "",
        session_ctl(m->ctl, m->new).text);
}

static enum exit_status tell(struct move *m, enum found found)
{
    print(m, found);
    if (found == FOUND_NEW) {
        remember_move(m->ctl, m->old, m->new);
        ctl_note(m->ctl, "when its power goes, it boots at 10.42.0.37 again");
        return follow(m);
    }
    if (lum_cancel_is_raised(m->ctl->cancel)) {
        return ctl_complain(EXIT_FAILED,
                            "interrupted: where the sensor is is not known");
    }
    if (found == FOUND_OLD) {
        return ctl_complain(
            EXIT_FAILED,
            "the sensor still answers at %s: it did not take the packet, or "
            "another sensor booted there; power others off and try again",
            session_name(m->old).text);
    }
    if (found == FOUND_REVERSED) {
        remember_move(m->ctl, m->old, m->reversed);
        return complain_reversed(m);
    }
    return complain_nowhere(m);
}

/* --- The command --- */

static enum exit_status move(struct ctl *ctl, uint32_t address)
{
    struct move m = {.ctl = ctl, .error = {""}};
    enum found found = FOUND_NOWHERE;
    enum exit_status status = ctl_open(ctl, false);
    if (status != EXIT_DONE) {
        return status;
    }
    m.old = session_host(ctl);
    m.new = (lum_endpoint){address, m.old.port};
    m.reversed = reverse(m.new);
    if (is_taken(&m)) {
        return complain_taken(&m);
    }
    learn_sensor(&m);
    status = check_others(&m);
    if (status != EXIT_DONE) {
        return status;
    }
    if (lum_cancel_is_raised(ctl->cancel)) {
        return ctl_complain(EXIT_FAILED, "interrupted: nothing was sent");
    }
    m.error.text[0] = '\0';
    status = carry_out(&m, &found);
    return status == EXIT_DONE ? tell(&m, found) : status;
}

enum exit_status command_set_ip(struct ctl *ctl, int count, char **words)
{
    uint8_t packet[LUM_SET_IP_BYTES];
    uint32_t address = 0;
    lum_error why = {""};
    if (count != 2) {
        return ctl_complain(EXIT_BAD, "set-ip takes one address, such as "
                                      "10.42.0.38");
    }
    if (!options_allow_host(&ctl->options, words[1], &why) ||
        !host_parse(words[1], &address, &why)) {
        return ctl_complain(EXIT_BAD, "set-ip: %s", why.text);
    }
    if (lum_set_ip_encode(packet, &ctl->layout, address) != LUM_OK) {
        return ctl_complain(
            EXIT_BAD,
            "set-ip: '%s' is not an address that a sensor can have: neither "
            "0.0.0.0, multicast nor broadcast",
            words[1]);
    }
    const enum exit_status status =
        ctl->options.force ? EXIT_DONE : set_ip_check_reach(ctl, address);
    if (status != EXIT_DONE || !ctl->options.dry_run) {
        return status == EXIT_DONE ? move(ctl, address) : status;
    }
    ctl_note(ctl, "set-ip: not checked in a dry run: whether another device "
                  "has the address");
    return ctl_print_packet(ctl, packet, sizeof packet);
}
