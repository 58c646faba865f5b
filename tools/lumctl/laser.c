#include "laser.h"

#include "../common/interrupt.h"
#include "../common/laser_end.h"
#include "report.h"
#include "session.h"
#include "text.h"

#include "lum/command.h"
#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

/* What keeps the laser down, and what to do. */
static enum exit_status complain_down(const struct ctl *ctl,
                                      const struct ctl_answer *answer)
{
    const uint16_t status = answer->status;
    const bool is_owned = session_is_owned(ctl, status);
    char at[SESSION_CTL_BYTES];
    char line[REPORT_LINE_BYTES];
    if (report_has_hazard(status, is_owned)) {
        (void)ctl_complain(EXIT_HAZARD,
                           "the laser stays down during a hazard:");
        report_status(stderr, status, is_owned, report_may_colour(stderr));
        return EXIT_HAZARD;
    }
    if (report_is_idle(status, is_owned)) {
        return ctl_complain(
            EXIT_FAILED,
            "the laser stays down: nobody sends heartbeats. Start a lumdump "
            "with --laser, or %s heartbeat, then say laser on again",
            session_ctl(ctl, session_host(ctl), at));
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

bool laser_is_undone(const lum_news *end)
{
    return end->kind == LUM_NEWS_ENDED_OFF &&
           (end->status & LUM_LASER_TLV_CMD_ON) == 0;
}

void laser_tell_undo(enum laser_wish wish, const lum_news *end)
{
    char text[LUM_ERROR_BYTES];
    if (!laser_is_undone(end)) {
        (void)ctl_complain(EXIT_FAILED, "%s%s",
                           wish == LASER_ON ? "NOT taken back: " : "",
                           lum_news_tell(end, text, sizeof text));
    } else {
        (void)ctl_complain(EXIT_FAILED,
                           wish == LASER_ON
                               ? "taken back: it will not come up by itself"
                               : "the laser is off; whether the rest of the "
                                 "text was done is not known");
    }
}

enum exit_status laser_complain(const struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer,
                                const lum_news *end)
{
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
    }
    laser_tell_undo(wish, end);
    return status;
}

/* The text of a command without a number. */
static const char *text_of(lum_command_id id, char out[LUM_COMMAND_TEXT_BYTES])
{
    size_t len = 0;
    const lum_command command = {.id = id};
    const lum_result result = lum_command_format(&command, out, &len);
    out[result == LUM_OK ? len : 0] = '\0';
    return out;
}

static enum exit_status switch_on(struct ctl *ctl)
{
    char text[LUM_COMMAND_TEXT_BYTES];
    const enum exit_status status =
        ctl_command_words(ctl, text_of(LUM_COMMAND_LASER_ON, text), "laser on");
    if (status == EXIT_DONE && !ctl->options.dry_run) {
        ctl_note(ctl, "it goes off 3 s after the last heartbeat; full strength "
                      "takes several seconds");
    }
    return status;
}

static void print_off(const struct ctl *ctl, lum_laser_off result,
                      uint16_t status)
{
    char name[SESSION_NAME_BYTES];
    char line[REPORT_LINE_BYTES];
    char text[LUM_COMMAND_TEXT_BYTES];
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
    json_text(&json, "command", text_of(LUM_COMMAND_LASER_OFF, text));
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
    char text[LUM_COMMAND_TEXT_BYTES];
    struct ctl_answer answer;
    bool was_sent = false;
    return text_send(ctl, text_of(LUM_COMMAND_LASER_OFF, text), &answer,
                     &was_sent);
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
