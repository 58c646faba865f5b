/* The commands send, laser and tlv. */
#include "../common/number.h"
#include "ctl_session.h"
#include "laser_outcome.h"
#include "status_report.h"
#include "text_command.h"

#include "lum/command.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* --- Texts of commands --- */

/* A text that was sent and did not show the laser as it was to be is not left
 * at that. After any other failure the session is of no use any more. */
static bool may_undo(const struct ctl *ctl, enum exit_status status)
{
    return ctl->sensor != NULL &&
           (status == EXIT_DONE || status == EXIT_NO_ANSWER ||
            lum_cancel_is_raised(ctl->cancel));
}

/* A text, and what is known of it. */
struct deed {
    const char *text;
    const char *typed;
    lum_laser_want want;
    bool is_as_wanted;
    bool was_undone;
    lum_news end; /* of that */
};

/* Prints its answer. Whether it is done. */
static bool report(const struct ctl *ctl, const struct deed *deed,
                   const struct ctl_answer *answer)
{
    struct refusal refusal;
    char what[TEXT_BYTES + 16];
    const bool is_refused = refusal_find(deed->text, answer->debug, &refusal);
    const bool is_done = !is_refused && deed->is_as_wanted;
    const bool is_taken_back = deed->was_undone && deed->want == LUM_WANT_ON;
    const struct text_outcome outcome = {deed->text, is_done, refusal.names,
                                         is_taken_back ? &deed->end : NULL};
    if (ctl->options.json) {
        text_print_json(ctl, &outcome, answer);
    } else {
        (void)snprintf(what, sizeof what, "%s %s", deed->typed,
                       is_done ? "done" : "sent");
        text_print_answer(ctl, what, answer);
    }
    if (is_refused) {
        (void)text_complain_refusal(deed->text, deed->typed, &refusal,
                                    answer->debug);
    }
    return is_done;
}

enum exit_status ctl_command_words(struct ctl *ctl, const char *text,
                                   const char *typed)
{
    struct ctl_answer answer;
    struct deed deed = {text,  typed, lum_laser_session_want_of(text),
                        false, false, {0}};
    bool was_sent = false;
    const enum exit_status status = text_send(ctl, text, &answer, &was_sent);
    const bool has_answer = status == EXIT_DONE && was_sent;
    deed.is_as_wanted = has_answer && laser_is_as(ctl, deed.want);
    if (was_sent && deed.want != LUM_WANT_LOOK && !deed.is_as_wanted &&
        may_undo(ctl, status)) {
        deed.was_undone = true;
        (void)laser_switch_down(ctl, &deed.end);
    }
    if (has_answer) {
        const bool is_done = report(ctl, &deed, &answer);
        if (!deed.is_as_wanted) {
            return laser_complain(ctl, deed.want, &answer, &deed.end);
        }
        return is_done ? EXIT_DONE : EXIT_FAILED;
    }
    if (deed.was_undone) {
        laser_tell_undo(deed.want, &deed.end);
    }
    return status;
}

enum exit_status command_send(struct ctl *ctl, int count, char **words)
{
    if (count != 2) {
        return ctl_complain(EXIT_BAD, "send takes one text; quote it where it "
                                      "has spaces: lumctl send '50p 15y u'");
    }
    return ctl_command_words(ctl, words[1], words[1]);
}

/* --- The laser --- */

struct command_text {
    char text[LUM_COMMAND_TEXT_BYTES];
};

/* Of a command without a number. */
static struct command_text text_of(lum_command_id id)
{
    struct command_text out;
    size_t len = 0;
    const lum_command command = {.id = id};
    const lum_result result = lum_command_format(&command, out.text, &len);
    out.text[result == LUM_OK ? len : 0] = '\0';
    return out;
}

static enum exit_status switch_on(struct ctl *ctl)
{
    const enum exit_status status =
        ctl_command_words(ctl, text_of(LUM_COMMAND_LASER_ON).text, "laser on");
    if (status == EXIT_DONE && !ctl->options.dry_run) {
        ctl_note(ctl,
                 "the laser goes off 3 s after the last heartbeat%s; full "
                 "strength takes several seconds",
                 session_has_owner(ctl) ? ""
                                        : ", and no program of this host "
                                          "sends heartbeats");
    }
    return status;
}

static void print_off(const struct ctl *ctl, lum_laser_off result,
                      uint16_t status)
{
    const struct session_name name = session_name(session_host(ctl));
    struct json json;
    if (!ctl->options.json) {
        if (result == LUM_LASER_OFF_SEEN) {
            (void)printf(
                "%s: laser off; %s\n", name.text,
                report_line(status, session_is_owned(ctl, status)).text);
        }
        return;
    }
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", name.text);
    json_text(&json, "command", text_of(LUM_COMMAND_LASER_OFF).text);
    json_bool(&json, "done", result == LUM_LASER_OFF_SEEN);
    if (result == LUM_LASER_OFF_SEEN || result == LUM_LASER_OFF_REFUSED) {
        report_json(&json, status, session_is_owned(ctl, status));
    }
    json_end_line(&json);
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
    return text_send(ctl, text_of(LUM_COMMAND_LASER_OFF).text, &answer,
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

/* --- Any TLVs --- */

static int hex_digit(char c)
{
    static const char digits[] = "0123456789abcdef";
    const char *at =
        c != '\0' ? strchr(digits, tolower((unsigned char)c)) : NULL;
    return at != NULL ? (int)(at - digits) : -1;
}

/* The bytes of an even number of hex digits; false: they are none, or more
 * than size. */
static bool read_hex(const char *text, uint8_t *out, size_t size, size_t *len)
{
    size_t n = 0;
    for (; text[0] != '\0'; text += 2) {
        const int high = hex_digit(text[0]);
        const int low = hex_digit(text[1]);
        if (high < 0 || low < 0 || n == size) {
            return false;
        }
        out[n++] = (uint8_t)(high * 16 + low);
    }
    *len = n;
    return true;
}

/* Appends one TYPE:HEX. */
static enum exit_status add_word(lum_tlv_writer *writer, const char *word)
{
    uint8_t value[LUM_SENSOR_REQUEST_BYTES];
    char type_text[8];
    int64_t type = 0;
    size_t len = 0;
    const size_t colon = strcspn(word, ":");
    (void)snprintf(type_text, sizeof type_text, "%.*s", (int)colon, word);
    if (word[colon] != ':' || colon >= sizeof type_text ||
        !number_parse_int(type_text, 0, UINT16_MAX, &type)) {
        return ctl_complain(EXIT_BAD,
                            "tlv: '%.40s' is not TYPE:HEX with a type from 0 "
                            "to 65535, such as 1:75",
                            word);
    }
    if (!read_hex(word + colon + 1, value, sizeof value, &len)) {
        return ctl_complain(EXIT_BAD,
                            "tlv: '%.40s': the value is an even number of hex "
                            "digits, at most %u bytes",
                            word, (unsigned)sizeof value);
    }
    if (lum_tlv_add(writer, (uint16_t)type, value, (uint16_t)len) != LUM_OK) {
        return ctl_complain(EXIT_BAD,
                            "tlv: '%.40s' does not fit the packet any more, "
                            "which holds %u bytes in all",
                            word, (unsigned)LUM_SENSOR_REQUEST_BYTES);
    }
    return EXIT_DONE;
}

enum exit_status command_tlv(struct ctl *ctl, int count, char **words)
{
    uint8_t packet[LUM_SENSOR_REQUEST_BYTES];
    lum_tlv_writer writer;
    struct ctl_answer answer;
    bool was_sent = false;
    if (count < 2 ||
        lum_tlv_begin(&writer, packet, sizeof packet, 0) != LUM_OK) {
        return ctl_complain(EXIT_BAD,
                            "tlv: give TYPE:HEX, such as 1:75, or several");
    }
    for (int i = 1; i < count; i++) {
        const enum exit_status status = add_word(&writer, words[i]);
        if (status != EXIT_DONE) {
            return status;
        }
    }
    const enum exit_status status =
        ctl_request(ctl, packet + LUM_TLV_PACKET_BYTES,
                    writer.len - LUM_TLV_PACKET_BYTES, &answer, &was_sent);
    if (status == EXIT_DONE && was_sent && ctl->options.json) {
        text_print_json(ctl, NULL, &answer);
    } else if (status == EXIT_DONE && was_sent) {
        text_print_answer(ctl, "answered", &answer);
    }
    return status;
}
