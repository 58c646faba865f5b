#include "settings_plan.h"

#include "refusal.h"
#include "remember.h"
#include "setting.h"

#include "base/text.h"

#include <string.h>

#define PLAN_BYTES 128 /* of all commands of a plan, parted by spaces */

/* --- The plan: what is sent --- */

static void add_command(struct settings_plan *plan, const lum_settings *from,
                        const struct setting *o)
{
    const lum_command command = {o->id, from->value[o->id]};
    struct plan_item *item = &plan->items[plan->count];
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

static void add_table(struct settings_plan *plan)
{
    struct plan_item *item = &plan->items[plan->count];
    plan->has_table = true;
    plan->table_at = plan->count++;
    item->setting = "yscan";
    (void)yscan_describe(&plan->table, item->value);
    (void)snprintf(item->command, sizeof item->command, "table");
}

/* What a Y scan needs to know of the eyes. */
static enum exit_status prepare_yscan(const struct ctl *ctl,
                                      const lum_settings *from,
                                      struct settings_plan *plan)
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

enum exit_status plan_make(struct ctl *ctl, const char *file,
                           const lum_settings *from, struct settings_plan *out)
{
    char name[MEMORY_FROM_BYTES];
    memset(out, 0, sizeof *out);
    out->file = file;
    const enum exit_status status = prepare_yscan(ctl, from, out);
    if (status != EXIT_DONE) {
        return status;
    }
    if (from->has_shape) {
        remember_table(ctl, &from->shape, yscan_name_calibration(ctl, name));
    }
    for (size_t i = 0; i < SETTINGS; i++) {
        if (from->has[settings[i].id]) {
            add_command(out, from, &settings[i]);
        } else if (settings[i].id == LUM_COMMAND_YSCAN && from->has_shape) {
            add_table(out);
        }
    }
    return EXIT_DONE;
}

/* --- Answers --- */

static const char *outcome_of(const struct plan_item *item)
{
    return !item->was_answered ? "" : item->is_refused ? "refused" : "done";
}

void plan_print(FILE *out, const struct settings_plan *plan)
{
    size_t width = strlen("value");
    for (size_t i = 0; i < plan->count; i++) {
        const size_t len = strlen(plan->items[i].value);
        width = len > width ? len : width;
    }
    (void)fprintf(out, "%-15s  %-*s  %s\n", "setting", (int)width, "value",
                  "command");
    for (size_t i = 0; i < plan->count; i++) {
        const struct plan_item *item = &plan->items[i];
        const char *outcome = outcome_of(item);
        (void)fprintf(out, "%-15s  %-*s  %s%*s%s\n", item->setting, (int)width,
                      item->value, item->command,
                      *outcome != '\0' ? 9 - (int)strlen(item->command) : 0, "",
                      outcome);
    }
}

/* Notes which of the items from first up to end the answer names. */
static void read_answer(struct settings_plan *plan, size_t first, size_t end)
{
    const char *debug = plan->answer.debug;
    char all[PLAN_BYTES] = "";
    struct refusal refusal;
    plan->has_answer = true;
    for (size_t i = first; i < end; i++) {
        struct plan_item *item = &plan->items[i];
        item->was_answered = true;
        item->is_refused = plan->has_table && i == plan->table_at
                               ? yscan_is_refused(debug)
                               : refusal_find(item->command, debug, &refusal) &&
                                     refusal.names[0] != '\0';
        plan->refused += item->is_refused;
        lum_text_list(all, PLAN_BYTES, " ", item->command);
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
static enum exit_status send_packet(struct ctl *ctl, struct settings_plan *plan,
                                    const struct packet *packet, size_t end)
{
    bool was_sent = false;
    const enum exit_status status = ctl_request(
        ctl, packet->bytes + LUM_TLV_PACKET_BYTES,
        packet->writer.len - LUM_TLV_PACKET_BYTES, &plan->answer, &was_sent);
    if (status == EXIT_DONE && was_sent) {
        read_answer(plan, packet->first, end);
    }
    ctl->options.requests.sequence += ctl->options.dry_run ? 1u : 0u;
    return status;
}

static lum_result add_text(const struct ctl *ctl, struct packet *packet)
{
    return lum_tlv_add(&packet->writer,
                       ctl->layout.profile.tlv[LUM_TLV_COMMAND], packet->text,
                       (uint16_t)strlen(packet->text));
}

static lum_result add_yscan(const struct ctl *ctl,
                            const struct settings_plan *plan,
                            struct packet *packet)
{
    return lum_yscan_add(&packet->writer,
                         ctl->layout.profile.tlv[LUM_TLV_YSCAN],
                         plan->table.raw, plan->table.count);
}

/* Puts the text that has gathered, or else the table, which is the plan's item
 * at, into the packet; into a new one where it does not fit. */
static enum exit_status add_tlv(struct ctl *ctl, struct settings_plan *plan,
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
enum exit_status plan_send(struct ctl *ctl, struct settings_plan *plan)
{
    struct packet packet = {.text = ""};
    size_t text_at = 0; /* the first item in packet.text */
    enum exit_status status = begin(&packet, 0);
    for (size_t i = 0; i < plan->count && status == EXIT_DONE; i++) {
        if (!plan->has_table || i != plan->table_at) {
            lum_text_list(packet.text, PLAN_BYTES, " ", plan->items[i].command);
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

/* --- What came of it --- */

static void list_refused(const struct settings_plan *plan, char *names,
                         size_t size)
{
    names[0] = '\0';
    for (size_t i = 0; i < plan->count; i++) {
        const struct plan_item *item = &plan->items[i];
        if (item->is_refused) {
            lum_text_add(names, size, "%s%s (%s)", *names != '\0' ? ", " : "",
                         item->setting, item->command);
        }
    }
}

enum exit_status plan_judge(const struct settings_plan *plan)
{
    char names[512];
    list_refused(plan, names, sizeof names);
    if (plan->refused > 0) {
        return ctl_complain(EXIT_FAILED,
                            "%s: the sensor names in its answer, and so "
                            "refused: %s",
                            plan->file, names);
    }
    return !plan->has_unnamed
               ? EXIT_DONE
               : ctl_complain(EXIT_FAILED,
                              "%s: the sensor's answer reports a refusal "
                              "and does not say of what",
                              plan->file);
}
