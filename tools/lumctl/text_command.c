#include "text_command.h"

#include "ctl_session.h"
#include "setting.h"
#include "status_report.h"

#include "lum/command.h"
#include "lum/host/command_text.h"

#include <stdio.h>
#include <string.h>

/* LUM_COMMANDS: none has this letter. */
static lum_command_id find_command(char letter)
{
    unsigned id = 0;
    while (id < LUM_COMMANDS && lum_command_specs[id].letter != letter) {
        id++;
    }
    return (lum_command_id)id;
}

static enum exit_status refuse_value(const char *word, int len)
{
    char steps[24] = "";
    const lum_command_id id = find_command(word[len - 1]);
    if (id == LUM_COMMANDS) {
        return EXIT_BAD;
    }
    const lum_command_spec *spec = &lum_command_specs[id];
    if (spec->step > 1) {
        (void)snprintf(steps, sizeof steps, " in steps of %u",
                       (unsigned)spec->step);
    }
    return ctl_complain(EXIT_BAD, "'%.*s': %s is %u to %u%s", len, word,
                        id == LUM_COMMAND_LINE_MODE ? "lines (0f: 640, 1f: 64)"
                                                    : setting_name(id),
                        (unsigned)spec->min, (unsigned)spec->max, steps);
}

static char digit_for(char c)
{
    return c == 'O' || c == 'o' ? '0' : c == 'l' || c == 'I' ? '1' : c;
}

bool text_find_digits(const char *word, size_t len, char *out, size_t size,
                      const char **what)
{
    const char *text = out;
    size_t left = len;
    lum_command command;
    if (len < 2 || len >= size) {
        return false;
    }
    for (size_t i = 0; i < len; i++) {
        out[i] = i + 1 < len ? digit_for(word[i]) : word[i];
    }
    out[len] = '\0';
    *what = out[0] == word[0] ? "has a letter among its digits"
            : out[0] == '0'   ? "begins with the letter O, not the digit zero"
                              : "begins with a letter, not the digit one";
    return strncmp(out, word, len) != 0 &&
           lum_command_parse(&text, &left, &command) == LUM_OK && left == 0;
}

/* EXIT_DONE if every word is a command of the manual. */
static enum exit_status check_text(const char *text)
{
    const char *at = text;
    size_t left = strlen(text);
    lum_command command;
    char meant[LUM_COMMAND_TEXT_BYTES + 1];
    const char *what = "";
    if (left == 0 || left > TEXT_BYTES) {
        return ctl_complain(EXIT_BAD,
                            "'%.20s': give commands of the manual, 1 to %u "
                            "characters, such as '50p 15y u'",
                            text, TEXT_BYTES);
    }
    for (;;) {
        const lum_result result = lum_command_parse(&at, &left, &command);
        const int len = (int)strcspn(at, " ");
        if (result == LUM_END) {
            return EXIT_DONE;
        }
        if (result == LUM_E_VALUE) {
            return refuse_value(at, len);
        }
        if (result != LUM_OK &&
            text_find_digits(at, (size_t)len, meant, sizeof meant, &what)) {
            return ctl_complain(EXIT_BAD, "'%.*s' %s; did you mean %s?", len,
                                at, what, meant);
        }
        if (result != LUM_OK) {
            return ctl_complain(
                EXIT_BAD,
                "'%s': '%.*s' is not a command: u, d, or a whole number and "
                "one of p g b f y h G B, separated by one space",
                text, len, at);
        }
    }
}

enum exit_status text_complain_refusal(const char *text, const char *typed,
                                       const struct refusal *refusal,
                                       const char *debug)
{
    char reason[sizeof((struct ctl_answer *)0)->debug];
    const bool is_all = strcmp(refusal->names, text) == 0;
    (void)snprintf(reason, sizeof reason, "%s", debug);
    for (char *at = reason; *at != '\0'; at++) {
        *at = *at == '\n' ? ';' : *at;
    }
    if (refusal->names[0] == '\0') {
        return ctl_complain(EXIT_FAILED,
                            "the answer to '%s' reports a refusal and does not "
                            "name what was refused: %s",
                            typed, reason);
    }
    return ctl_complain(EXIT_FAILED, "the sensor refused '%s'%s: %s",
                        is_all ? typed : refusal->names,
                        is_all                 ? ""
                        : refusal->has_unnamed ? " and more"
                                               : "; the others are done",
                        reason);
}

void text_print_json(const struct ctl *ctl, const struct text_outcome *outcome,
                     const struct ctl_answer *answer)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", session_name(session_host(ctl)).text);
    if (outcome != NULL) {
        json_text(&json, "command", outcome->text);
        json_bool(&json, "done", outcome->is_done);
        json_text(&json, "refused", outcome->refused);
    }
    if (outcome != NULL && outcome->undone != NULL) {
        json_bool(&json, "taken_back", laser_is_undone(outcome->undone));
    }
    if (answer->has_status) {
        report_json(&json, answer->status,
                    session_is_owned(ctl, answer->status));
    }
    report_json_lines(&json, "debug", answer->debug);
    report_json_lines(&json, "tlvs", answer->others);
    json_uint(&json, "tries", answer->tries);
    report_json_trip(&json, answer->round_trip_ns);
    json_end_line(&json);
}

void text_print_answer(const struct ctl *ctl, const char *what,
                       const struct ctl_answer *answer)
{
    (void)printf(
        "%s: %s; %s\n", session_name(session_host(ctl)).text, what,
        answer->has_status
            ? report_line(answer->status, session_is_owned(ctl, answer->status))
                  .text
            : "the answer had no status");
    report_debug(stdout, answer->debug);
    if (*answer->others != '\0') {
        (void)puts(answer->others);
    }
}

static enum exit_status encode(const struct ctl *ctl, const char *text,
                               uint8_t *out, size_t size, size_t *len)
{
    uint8_t packet[LUM_SENSOR_REQUEST_BYTES];
    lum_tlv_writer writer;
    if (lum_tlv_begin(&writer, packet, sizeof packet, 0) != LUM_OK ||
        lum_tlv_add(&writer, ctl->layout.profile.tlv[LUM_TLV_COMMAND], text,
                    (uint16_t)strlen(text)) != LUM_OK ||
        writer.len - LUM_TLV_PACKET_BYTES > size) {
        return ctl_complain(EXIT_BAD, "'%.20s...' does not fit one packet",
                            text);
    }
    *len = writer.len - LUM_TLV_PACKET_BYTES;
    (void)memcpy(out, packet + LUM_TLV_PACKET_BYTES, *len);
    return EXIT_DONE;
}

enum exit_status text_send(struct ctl *ctl, const char *text,
                           struct ctl_answer *answer, bool *was_sent)
{
    uint8_t tlvs[LUM_SENSOR_REQUEST_BYTES];
    size_t len = 0;
    enum exit_status status = check_text(text);
    *was_sent = false;
    if (status == EXIT_DONE) {
        status = encode(ctl, text, tlvs, sizeof tlvs, &len);
    }
    return status == EXIT_DONE
               ? ctl_request_text(ctl, text, tlvs, len, answer, was_sent)
               : status;
}
