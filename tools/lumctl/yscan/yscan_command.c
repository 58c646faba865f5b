/* The command yscan: a field of view, or a shape as a table. */
#include "yscan_table.h"

#include "../remember.h"
#include "../text_command.h"
#include "yscan_shape.h"

#include "lum/command.h"
#include "lum/host/command_text.h"

#include <stdio.h>
#include <string.h>

/* The text of a uniform scan, if the word is a field of view that it takes. */
static bool compose(const char *fov, char *out, size_t size, unsigned *degrees)
{
    const char *at = out;
    lum_command command;
    const int n = snprintf(out, size, "%s%c", fov,
                           lum_command_specs[LUM_COMMAND_YSCAN].letter);
    size_t left = n > 0 && (size_t)n < size ? (size_t)n : 0;
    if (lum_command_parse(&at, &left, &command) != LUM_OK || left != 0) {
        return false;
    }
    *degrees = command.value;
    return true;
}

static enum exit_status send_uniform(struct ctl *ctl, const char *fov)
{
    const lum_command_spec *spec = &lum_command_specs[LUM_COMMAND_YSCAN];
    char text[16];
    char typed[32];
    unsigned degrees = 0;
    lum_calibration calibration;
    if (!compose(fov, text, sizeof text, &degrees)) {
        return ctl_complain(EXIT_BAD,
                            "yscan: '%.40s' is not a whole number of degrees "
                            "from %u to %u; --shape has other distributions",
                            fov, (unsigned)spec->min, (unsigned)spec->max);
    }
    const enum exit_status status = yscan_load_calibration(ctl, &calibration);
    if (status != EXIT_DONE) {
        return status;
    }
    yscan_note_view(ctl, &calibration, degrees);
    (void)snprintf(typed, sizeof typed, "yscan %u", degrees);
    return ctl_command_words(ctl, text, typed);
}

static enum exit_status make_table(struct ctl *ctl,
                                   const lum_calibration *calibration,
                                   struct yscan_table *out)
{
    const char *text = ctl->options.yscan.shape;
    const char *csv = yscan_csv_name(text);
    const size_t lines =
        ctl->options.yscan.lines != 0 ? ctl->options.yscan.lines : YSCAN_LINES;
    char from[MEMORY_FROM_BYTES];
    lum_yscan_shape shape;
    enum exit_status status = EXIT_DONE;
    out->count = lines;
    if (csv != NULL && ctl->in_shell && strcmp(csv, "-") == 0) {
        status = ctl_complain(EXIT_BAD, "yscan: csv:- would read what is typed "
                                        "here; give a file");
    } else if (csv != NULL) {
        status = yscan_read_csv(csv, out->udeg, lines);
        remember_table(ctl, NULL, csv);
    } else {
        status = yscan_parse_shape(text, &shape);
        if (status == EXIT_DONE) {
            status = yscan_fill(&shape, calibration, lines, out);
            remember_table(ctl, &shape, yscan_name_calibration(ctl, from));
        }
    }
    return status == EXIT_DONE ? yscan_encode(ctl, calibration, out) : status;
}

static enum exit_status finish(const struct ctl *ctl, const char *what,
                               const struct ctl_answer *answer)
{
    struct refusal refusal;
    const bool is_refused = yscan_is_refused(answer->debug) ||
                            refusal_find("table", answer->debug, &refusal);
    char text[YSCAN_TEXT_BYTES + 32];
    if (ctl->options.json) {
        const struct text_outcome outcome = {what, !is_refused,
                                             is_refused ? what : "", NULL};
        text_print_json(ctl, &outcome, answer);
    } else {
        (void)snprintf(text, sizeof text, "Y scan %s %s", what,
                       is_refused ? "sent" : "done");
        text_print_answer(ctl, text, answer);
    }
    return is_refused ? ctl_complain(EXIT_FAILED,
                                     "the sensor refused the Y-scan table: "
                                     "%s",
                                     answer->debug)
                      : EXIT_DONE;
}

static enum exit_status send_table(struct ctl *ctl,
                                   const struct yscan_table *table)
{
    uint8_t packet[LUM_SENSOR_REQUEST_BYTES];
    char what[YSCAN_TEXT_BYTES];
    lum_tlv_writer writer;
    struct ctl_answer answer;
    bool was_sent = false;
    if (lum_tlv_begin(&writer, packet, sizeof packet, 0) != LUM_OK ||
        lum_yscan_add(&writer, ctl->layout.profile.tlv[LUM_TLV_YSCAN],
                      table->raw, table->count) != LUM_OK) {
        return ctl_complain(EXIT_BAD, "yscan: %u lines do not fit a packet",
                            (unsigned)table->count);
    }
    const enum exit_status status =
        ctl_request(ctl, packet + LUM_TLV_PACKET_BYTES,
                    writer.len - LUM_TLV_PACKET_BYTES, &answer, &was_sent);
    return status == EXIT_DONE && was_sent
               ? finish(ctl, yscan_describe(table, what), &answer)
               : status;
}

static enum exit_status send_shape(struct ctl *ctl)
{
    lum_calibration calibration;
    struct yscan_table table;
    enum exit_status status = yscan_load_calibration(ctl, &calibration);
    if (status == EXIT_DONE) {
        status = make_table(ctl, &calibration, &table);
    }
    if (status != EXIT_DONE) {
        return status;
    }
    if (ctl->options.yscan.lines == 0) {
        ctl_note(ctl,
                 "the table is for %u lines, because a sensor cannot be asked; "
                 "use --lines %u if it runs with those",
                 YSCAN_LINES, YSCAN_LINES_FEW);
    }
    yscan_note_eyes(ctl, &table);
    if (ctl->options.dry_run) {
        yscan_show(ctl, &calibration, &table);
    }
    return send_table(ctl, &table);
}

enum exit_status command_yscan(struct ctl *ctl, int count, char **words)
{
    const bool has_shape = ctl->options.yscan.shape != NULL;
    const uint32_t lines = ctl->options.yscan.lines;
    if (count > (has_shape ? 1 : 2)) {
        return ctl_complain(EXIT_BAD,
                            "yscan: '%.40s' is one word too many: give a field "
                            "of view or --shape, not more",
                            words[has_shape ? 1 : 2]);
    }
    if (lines != 0 && lines != YSCAN_LINES && lines != YSCAN_LINES_FEW) {
        return ctl_complain(EXIT_BAD, "yscan: --lines %u is not %u or %u",
                            (unsigned)lines, YSCAN_LINES, YSCAN_LINES_FEW);
    }
    if (has_shape) {
        return send_shape(ctl);
    }
    if (lines != 0) {
        return ctl_complain(EXIT_BAD, "yscan: --lines goes with --shape; a "
                                      "field of view needs none");
    }
    return count == 2
               ? send_uniform(ctl, words[1])
               : ctl_complain(EXIT_BAD, "yscan: give a field of view, 11 to 30 "
                                        "degrees, or --shape");
}
