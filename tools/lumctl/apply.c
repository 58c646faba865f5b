#include "../common/input_files.h"
#include "remember.h"
#include "report.h"
#include "session.h"
#include "setting.h"
#include "text.h"
#include "yscan/yscan.h"

#include "lum/config/settings.h"

#include <stdio.h>
#include <string.h>

#define PLAN_BYTES 128 /* of all commands of a plan, parted by spaces */

/* One setting on its way to the sensor. */
struct item {
    const char *setting;
    char value[YSCAN_TEXT_BYTES];
    char command[LUM_COMMAND_TEXT_BYTES + 1]; /* "table": the Y-scan table */
    bool was_answered;
    bool is_refused;
};

/* A file's settings in the order in which they are sent, and their results. */
struct plan {
    const char *file;
    struct item items[LUM_COMMANDS];
    size_t count;
    bool has_table;
    size_t table_at; /* its item */
    struct yscan_table table;
    bool has_answer;
    struct ctl_answer answer; /* the last */
    bool has_unnamed; /* something was refused that no item is named by */
};

/* --- The plan: what is sent --- */

static void add_command(struct plan *plan, const lum_settings *from,
                        const struct setting *o)
{
    const lum_command command = {o->id, from->value[o->id]};
    struct item *item = &plan->items[plan->count];
    size_t len = 0;
    const unsigned value = o->id == LUM_COMMAND_LINE_MODE
                               ? setting_lines(command.value)
                               : command.value;
    if (lum_command_format(&command, item->command, &len) == LUM_OK) {
        item->command[len] = '\0';
        item->setting = o->name;
        (void)snprintf(item->value, sizeof item->value, "%u%s", value,
                       o->id == LUM_COMMAND_YSCAN ? " degrees" : "");
        plan->count++;
    }
}

static void add_table(struct plan *plan)
{
    struct item *item = &plan->items[plan->count];
    plan->has_table = true;
    plan->table_at = plan->count++;
    item->setting = "yscan";
    (void)yscan_describe(&plan->table, item->value);
    (void)snprintf(item->command, sizeof item->command, "table");
}

/* What a Y scan needs to know of the eyes. */
static enum exit_status prepare_yscan(const struct ctl *ctl,
                                      const lum_settings *from,
                                      struct plan *plan)
{
    lum_calibration calibration;
    enum exit_status status = yscan_load_calibration(ctl, &calibration);
    if (status == EXIT_DONE && from->has_shape) {
        status = yscan_fill(&from->shape, &calibration,
                            setting_lines(from->value[LUM_COMMAND_LINE_MODE]),
                            &plan->table);
    }
    if (status == EXIT_DONE && from->has_shape) {
        status = yscan_encode(ctl, &calibration, &plan->table);
    }
    if (status != EXIT_DONE) {
        return status;
    }
    if (from->has[LUM_COMMAND_YSCAN]) {
        yscan_note_view(ctl, &calibration, from->value[LUM_COMMAND_YSCAN]);
    }
    if (from->has_shape && !from->has[LUM_COMMAND_LINE_MODE]) {
        ctl_note(ctl,
                 "%s names no lines: the table is for %u, because a sensor "
                 "cannot be asked",
                 plan->file, YSCAN_LINES);
    }
    if (from->has_shape) {
        yscan_note_eyes(ctl, &plan->table);
    }
    return EXIT_DONE;
}

static enum exit_status make_plan(struct ctl *ctl, const char *file,
                                  struct plan *out)
{
    char name[MEMORY_FROM_BYTES];
    lum_settings from;
    lum_error error = {""};
    memset(out, 0, sizeof *out);
    out->file = file;
    if (input_files_check(&(struct input_file){file, "the settings file"}, 1,
                          "-", &error) != 0 ||
        lum_settings_load(file, &from, &error) != 0) {
        return ctl_complain(EXIT_BAD, "%s", error.text);
    }
    const enum exit_status status = prepare_yscan(ctl, &from, out);
    if (status != EXIT_DONE) {
        return status;
    }
    if (from.has_shape) {
        remember_table(ctl, &from.shape, yscan_name_calibration(ctl, name));
    }
    for (size_t i = 0; i < SETTINGS; i++) {
        if (from.has[settings[i].id]) {
            add_command(out, &from, &settings[i]);
        } else if (settings[i].id == LUM_COMMAND_YSCAN && from.has_shape) {
            add_table(out);
        }
    }
    return EXIT_DONE;
}

/* --- Answers --- */

static const char *outcome_of(const struct item *item)
{
    return !item->was_answered ? "" : item->is_refused ? "refused" : "done";
}

static void print_plan(FILE *out, const struct plan *plan)
{
    size_t width = strlen("value");
    for (size_t i = 0; i < plan->count; i++) {
        const size_t len = strlen(plan->items[i].value);
        width = len > width ? len : width;
    }
    (void)fprintf(out, "%-15s  %-*s  %s\n", "setting", (int)width, "value",
                  "command");
    for (size_t i = 0; i < plan->count; i++) {
        const struct item *item = &plan->items[i];
        const char *outcome = outcome_of(item);
        (void)fprintf(out, "%-15s  %-*s  %s%*s%s\n", item->setting, (int)width,
                      item->value, item->command,
                      *outcome != '\0' ? 9 - (int)strlen(item->command) : 0, "",
                      outcome);
    }
}

static void gather(char text[PLAN_BYTES], const char *command)
{
    const size_t used = strlen(text);
    (void)snprintf(text + used, PLAN_BYTES - used, "%s%s", used != 0 ? " " : "",
                   command);
}

/* Notes which of the items from first up to end the answer names. */
static void read_answer(struct plan *plan, size_t first, size_t end)
{
    const char *debug = plan->answer.debug;
    char all[PLAN_BYTES] = "";
    struct refusal refusal;
    plan->has_answer = true;
    for (size_t i = first; i < end; i++) {
        struct item *item = &plan->items[i];
        item->was_answered = true;
        item->is_refused = plan->has_table && i == plan->table_at
                               ? yscan_is_refused(debug)
                               : refusal_find(item->command, debug, &refusal) &&
                                     refusal.names[0] != '\0';
        gather(all, item->command);
    }
    (void)refusal_find(all, debug, &refusal);
    plan->has_unnamed = plan->has_unnamed || refusal.has_unnamed;
}

/* A packet of the plan being filled. */
struct packet {
    uint8_t bytes[LUM_SENSOR_REQUEST_BYTES];
    lum_tlv_writer writer;
    char text[PLAN_BYTES]; /* commands that follow, not yet in it */
    size_t first;          /* item of the plan that it begins with */
};

/* --- Sending --- */

static enum exit_status begin(struct packet *packet, size_t first)
{
    packet->first = first;
    return lum_tlv_begin(&packet->writer, packet->bytes, sizeof packet->bytes,
                         0) == LUM_OK
               ? EXIT_DONE
               : EXIT_FAILED;
}

/* Sends the packet, which holds the items up to end. */
static enum exit_status send_packet(struct ctl *ctl, struct plan *plan,
                                    const struct packet *packet, size_t end)
{
    bool was_sent = false;
    const enum exit_status status = ctl_request(
        ctl, packet->bytes + LUM_TLV_PACKET_BYTES,
        packet->writer.len - LUM_TLV_PACKET_BYTES, &plan->answer, &was_sent);
    if (status == EXIT_DONE && was_sent) {
        read_answer(plan, packet->first, end);
    }
    ctl->options.sequence += ctl->options.dry_run ? 1u : 0u;
    return status;
}

static lum_result add_text(const struct ctl *ctl, struct packet *packet)
{
    return lum_tlv_add(&packet->writer,
                       ctl->layout.profile.tlv[LUM_TLV_COMMAND], packet->text,
                       (uint16_t)strlen(packet->text));
}

static lum_result add_yscan(const struct ctl *ctl, const struct plan *plan,
                            struct packet *packet)
{
    return lum_yscan_add(&packet->writer,
                         ctl->layout.profile.tlv[LUM_TLV_YSCAN],
                         plan->table.raw, plan->table.count);
}

/* Puts the text that has gathered, or else the table, which is the plan's item
 * at, into the packet; into a new one where it does not fit. */
static enum exit_status add_tlv(struct ctl *ctl, struct plan *plan,
                                struct packet *packet, size_t at)
{
    const bool is_text = packet->text[0] != '\0';
    for (int tries = 0; tries < 2; tries++) {
        const lum_result result =
            is_text ? add_text(ctl, packet) : add_yscan(ctl, plan, packet);
        if (result == LUM_OK) {
            packet->text[0] = '\0';
            return EXIT_DONE;
        }
        enum exit_status status = send_packet(ctl, plan, packet, at);
        status = status == EXIT_DONE ? begin(packet, at) : status;
        if (status != EXIT_DONE) {
            return status;
        }
    }
    return ctl_complain(EXIT_FAILED, "%s: a setting does not fit a packet",
                        plan->file);
}

/* Commands go as texts, as many in one as follow each other. */
static enum exit_status send_plan(struct ctl *ctl, struct plan *plan)
{
    struct packet packet = {.text = ""};
    size_t text_at = 0; /* the first item in packet.text */
    enum exit_status status = begin(&packet, 0);
    for (size_t i = 0; i < plan->count && status == EXIT_DONE; i++) {
        if (!plan->has_table || i != plan->table_at) {
            gather(packet.text, plan->items[i].command);
            continue;
        }
        if (packet.text[0] != '\0') {
            status = add_tlv(ctl, plan, &packet, text_at);
        }
        if (status == EXIT_DONE) {
            status = add_tlv(ctl, plan, &packet, i);
        }
        text_at = i + 1;
    }
    if (status == EXIT_DONE && packet.text[0] != '\0') {
        status = add_tlv(ctl, plan, &packet, text_at);
    }
    return status == EXIT_DONE ? send_packet(ctl, plan, &packet, plan->count)
                               : status;
}

/* --- What is shown --- */

static size_t count_refused(const struct plan *plan, char *names, size_t size)
{
    size_t count = 0;
    size_t n = 0;
    names[0] = '\0';
    for (size_t i = 0; i < plan->count; i++) {
        const struct item *item = &plan->items[i];
        if (item->is_refused && n < size) {
            n += (size_t)snprintf(names + n, size - n, "%s%s (%s)",
                                  count != 0 ? ", " : "", item->setting,
                                  item->command);
        }
        count += item->is_refused;
    }
    return count;
}

static void print_json(const struct ctl *ctl, const struct plan *plan,
                       bool is_done)
{
    struct json json;
    char name[SESSION_NAME_BYTES];
    json_init(&json, stdout);
    json_open_object(&json, NULL);
    json_text(&json, "sensor", session_name(session_host(ctl), name));
    json_text(&json, "file", plan->file);
    json_bool(&json, "done", is_done);
    json_open_array(&json, "settings");
    for (size_t i = 0; i < plan->count; i++) {
        const struct item *item = &plan->items[i];
        json_open_object(&json, NULL);
        json_text(&json, "setting", item->setting);
        json_text(&json, "value", item->value);
        json_text(&json, "command", item->command);
        json_bool(&json, "done", item->was_answered && !item->is_refused);
        json_close_object(&json);
    }
    json_close_array(&json);
    if (plan->answer.has_status) {
        report_json(&json, plan->answer.status,
                    session_is_owned(ctl, plan->answer.status));
    }
    report_json_lines(&json, "debug", plan->answer.debug);
    json_uint(&json, "tries", plan->answer.tries);
    json_close_object(&json);
    json_end(&json);
}

static void print_text(const struct ctl *ctl, const struct plan *plan,
                       size_t refused)
{
    char what[64];
    print_plan(stdout, plan);
    (void)snprintf(what, sizeof what, "%u of %u settings done",
                   (unsigned)(plan->count - refused), (unsigned)plan->count);
    text_print_answer(ctl, what, &plan->answer);
}

/* --- The command --- */

static enum exit_status finish(const struct ctl *ctl, const struct plan *plan)
{
    char names[512];
    const size_t refused = count_refused(plan, names, sizeof names);
    const bool is_done = refused == 0 && !plan->has_unnamed;
    if (ctl->options.json) {
        print_json(ctl, plan, is_done);
    } else {
        print_text(ctl, plan, refused);
    }
    if (refused > 0) {
        return ctl_complain(EXIT_FAILED,
                            "%s: the sensor names in its answer, and so "
                            "refused: %s",
                            plan->file, names);
    }
    return is_done ? EXIT_DONE
                   : ctl_complain(EXIT_FAILED,
                                  "%s: the sensor's answer reports a refusal "
                                  "and does not say of what",
                                  plan->file);
}

enum exit_status command_apply(struct ctl *ctl, int count, char **words)
{
    struct plan plan;
    if (count != 2) {
        return ctl_complain(
            EXIT_BAD, count < 2 ? "apply: give a file of settings, such as the "
                                  "sample calib/settings.yaml"
                                : "apply: one file of settings, not more");
    }
    if (ctl->in_shell && strcmp(words[1], "-") == 0) {
        return ctl_complain(EXIT_BAD, "apply: '-' would read what is typed "
                                      "here; give a file");
    }
    enum exit_status status = make_plan(ctl, words[1], &plan);
    if (status != EXIT_DONE) {
        return status;
    }
    if (plan.count == 0) {
        ctl_note(ctl, "%s names no setting: nothing to send", plan.file);
        return EXIT_DONE;
    }
    if (ctl->options.dry_run && !ctl->options.quiet) {
        print_plan(stderr, &plan);
    }
    status = send_plan(ctl, &plan);
    return status == EXIT_DONE && plan.has_answer ? finish(ctl, &plan) : status;
}
