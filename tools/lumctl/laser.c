#include "laser.h"

#include "../common/interrupt.h"
#include "../common/laser_end.h"
#include "report.h"
#include "session.h"
#include "text.h"

#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

/* What keeps the laser down, and what to do. */
static enum exit_status complain_down(const struct ctl *ctl,
                                      const struct ctl_answer *answer)
{
    const uint16_t status = answer->status;
    const bool is_owned = session_is_owned(ctl, status);
    char name[SESSION_NAME_BYTES];
    char line[REPORT_LINE_BYTES];
    (void)session_name(session_host(ctl), name);
    if (report_has_hazard(status, is_owned)) {
        (void)ctl_complain(EXIT_HAZARD,
                           "the laser stays down during a hazard:");
        report_status(stderr, status, is_owned, report_may_colour(stderr));
        return EXIT_HAZARD;
    }
    if (report_is_idle(status, is_owned)) {
        return ctl_complain(
            EXIT_FAILED,
            "the laser stays down: nobody sends heartbeats. Start lumdump "
            "udp://%s --laser, or lumctl --host %s heartbeat, then say laser "
            "on again",
            name, name);
    }
    return ctl_complain(EXIT_FAILED, "the laser did not come up: %s",
                        report_line(status, is_owned, line));
}

enum laser_wish laser_wish_of(const char *text)
{
    enum laser_wish wish = LASER_ANY;
    for (; *text != '\0'; text++) {
        wish = *text == 'u' ? LASER_ON : *text == 'd' ? LASER_OFF : wish;
    }
    return wish;
}

bool laser_is_as(enum laser_wish wish, const struct ctl_answer *answer)
{
    return wish == LASER_ANY ||
           (answer->has_status &&
            report_laser_is_up(answer->status) == (wish == LASER_ON));
}

lum_laser_off laser_switch_down(struct ctl *ctl, lum_news *end)
{
    interrupt_hold();
    const lum_laser_off result =
        laser_end(ctl->keeper, ctl->sensor, "lumctl", end);
    interrupt_release();
    if (result == LUM_LASER_OFF_SEEN || result == LUM_LASER_OFF_REFUSED) {
        ctl->has_status = true;
        ctl->status = end->status;
    }
    return result;
}

enum laser_undo laser_take_back(struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer)
{
    lum_news end;
    if (wish != LASER_ON || (answer != NULL && laser_is_as(wish, answer))) {
        return LASER_STANDS;
    }
    const lum_laser_off result = laser_switch_down(ctl, &end);
    if (end.kind == LUM_NEWS_ENDED_ON) {
        return LASER_IS_ON;
    }
    return result == LUM_LASER_OFF_SEEN &&
                   (end.status & LUM_LASER_TLV_CMD_ON) == 0
               ? LASER_TAKEN_BACK
               : LASER_MAY_COME_UP;
}

static void complain_undo(const struct ctl *ctl, enum laser_undo undo)
{
    char name[SESSION_NAME_BYTES];
    (void)session_name(session_host(ctl), name);
    switch (undo) {
    case LASER_TAKEN_BACK:
        (void)ctl_complain(EXIT_FAILED,
                           "taken back: it will not come up by itself");
        return;
    case LASER_MAY_COME_UP:
        (void)ctl_complain(
            EXIT_FAILED,
            "NOT taken back, since no answer shows it: the laser WILL COME UP "
            "by itself when what keeps it down ends. Run lumctl --host %s "
            "laser off, or end the programs that send heartbeats",
            name);
        return;
    case LASER_IS_ON:
        (void)ctl_complain(
            EXIT_FAILED,
            "taking it back failed: the laser is ON now, and stays up. End the "
            "programs that send heartbeats, or cut its power");
        return;
    case LASER_STANDS:
    default:
        return;
    }
}

enum exit_status laser_complain(const struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer,
                                enum laser_undo undo)
{
    char line[REPORT_LINE_BYTES];
    enum exit_status status = EXIT_FAILED;
    if (!answer->has_status) {
        (void)ctl_complain(
            EXIT_FAILED,
            "no status came that shows it %s: the answer has no TLV %u, which "
            "is the status's number by tlv.status of the profile",
            wish == LASER_ON ? "on" : "off",
            (unsigned)ctl->layout.profile.tlv[LUM_TLV_STATUS]);
    } else if (wish == LASER_ON) {
        status = complain_down(ctl, answer);
    } else {
        (void)ctl_complain(EXIT_FAILED,
                           "the laser is ON: the command was answered, and it "
                           "stays up (%s)",
                           report_line(answer->status, false, line));
    }
    complain_undo(ctl, undo);
    return status;
}

/* A text that was to switch it off may be lost, and that is not left to it. */
static void insist(struct ctl *ctl)
{
    lum_news end;
    const lum_laser_off off = laser_switch_down(ctl, &end);
    (void)ctl_complain(EXIT_FAILED,
                       off == LUM_LASER_OFF_SEEN
                           ? "the laser is off; whether the rest of the text "
                             "was done is not known"
                           : "the laser MAY BE ON: it goes off 3 s after the "
                             "last heartbeat");
}

enum exit_status laser_give_up(struct ctl *ctl, enum laser_wish wish,
                               enum exit_status status, bool was_sent)
{
    /* After any other failure the session is of no use any more. */
    const bool is_usable =
        status == EXIT_NO_ANSWER || lum_cancel_is_raised(ctl->cancel);
    if (status == EXIT_DONE || !was_sent || ctl->sensor == NULL || !is_usable) {
        return status;
    }
    if (wish == LASER_OFF) {
        insist(ctl);
    } else {
        complain_undo(ctl, laser_take_back(ctl, wish, NULL));
    }
    return status;
}

static enum exit_status switch_on(struct ctl *ctl)
{
    struct ctl_answer answer;
    struct refusal refusal;
    bool was_sent = false;
    const enum exit_status status = text_send(ctl, "u", &answer, &was_sent);
    if (status != EXIT_DONE || !was_sent) {
        return laser_give_up(ctl, LASER_ON, status, was_sent);
    }
    const enum laser_undo undo = laser_take_back(ctl, LASER_ON, &answer);
    const bool is_refused = refusal_find("u", answer.debug, &refusal);
    const bool is_on = laser_is_as(LASER_ON, &answer);
    const bool is_up = is_on && !is_refused;
    if (ctl->options.json) {
        const struct text_outcome outcome = {"u", is_up, refusal.names, undo};
        text_print_json(ctl, &outcome, &answer);
    } else {
        text_print_answer(ctl,
                          is_up   ? "laser on"
                          : is_on ? "laser ON, though the command was refused"
                                  : "laser not on",
                          &answer);
    }
    if (is_up) {
        ctl_note(ctl, "it goes off 3 s after the last heartbeat; full strength "
                      "takes several seconds");
        return EXIT_DONE;
    }
    if (is_refused) {
        (void)text_complain_refusal("u", "u", &refusal, answer.debug);
    }
    return is_on ? EXIT_FAILED : laser_complain(ctl, LASER_ON, &answer, undo);
}

static void print_off(const struct ctl *ctl, lum_laser_off result,
                      uint16_t status)
{
    char name[SESSION_NAME_BYTES];
    char line[REPORT_LINE_BYTES];
    struct json json;
    (void)session_name(session_host(ctl), name);
    if (!ctl->options.json) {
        if (result == LUM_LASER_OFF_SEEN) {
            (void)printf(
                "%s: laser off; %s\n", name,
                report_line(status, session_is_owned(ctl, status), line));
        }
        return;
    }
    json_init(&json, stdout);
    json_open_object(&json, NULL);
    json_text(&json, "sensor", name);
    json_text(&json, "command", "d");
    json_bool(&json, "done", result == LUM_LASER_OFF_SEEN);
    if (result == LUM_LASER_OFF_SEEN || result == LUM_LASER_OFF_REFUSED) {
        report_json(&json, status, session_is_owned(ctl, status));
    }
    json_close_object(&json);
    json_end(&json);
}

static enum exit_status switch_off(struct ctl *ctl)
{
    char text[LUM_ERROR_BYTES];
    lum_news end;
    const enum exit_status opened = ctl_open(ctl, false);
    if (opened != EXIT_DONE) {
        return opened;
    }
    const lum_laser_off result = laser_switch_down(ctl, &end);
    print_off(ctl, result, end.status);
    return result == LUM_LASER_OFF_SEEN
               ? EXIT_DONE
               : ctl_complain(result == LUM_LASER_OFF_UNKNOWN ? EXIT_NO_ANSWER
                                                              : EXIT_FAILED,
                              "%s", lum_news_tell(&end, text, sizeof text));
}

static enum exit_status print_off_packet(struct ctl *ctl)
{
    struct ctl_answer answer;
    bool was_sent = false;
    return text_send(ctl, "d", &answer, &was_sent);
}

enum exit_status command_laser(struct ctl *ctl, int count, char **words)
{
    if (count < 2) {
        return ctl_complain(EXIT_BAD, "laser: a word is missing: on or off");
    }
    if (count > 2) {
        return ctl_complain(EXIT_BAD,
                            "laser: '%s' is one word too many: only on or off",
                            words[2]);
    }
    if (strcmp(words[1], "on") == 0) {
        return switch_on(ctl);
    }
    if (strcmp(words[1], "off") != 0) {
        return ctl_complain(EXIT_BAD, "laser: '%s' is not on or off", words[1]);
    }
    return ctl->options.dry_run ? print_off_packet(ctl) : switch_off(ctl);
}
