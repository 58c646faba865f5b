/* The command apply: settings of a file, sent, and what becomes of each. */
#include "../common/input_files.h"
#include "ctl_session.h"
#include "settings_plan.h"
#include "status_report.h"
#include "text_command.h"

#include <stdio.h>
#include <string.h>

static enum exit_status make_plan(struct ctl *ctl, const char *file,
                                  struct settings_plan *out)
{
    lum_settings from;
    lum_error error = {""};
    return input_files_check(&(struct input_file){file, "the settings file"}, 1,
                             "-", &error) != 0 ||
                   lum_settings_load(file, &from, &error) != 0
               ? ctl_complain(EXIT_BAD, "%s", error.text)
               : plan_make(ctl, file, &from, out);
}

static void print_json(const struct ctl *ctl, const struct settings_plan *plan,
                       bool is_done)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", session_name(session_host(ctl)).text);
    json_text(&json, "file", plan->file);
    json_bool(&json, "done", is_done);
    json_open_array(&json, "settings");
    for (size_t i = 0; i < plan->count; i++) {
        const struct plan_item *item = &plan->items[i];
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
    json_end_line(&json);
}

static void print_text(const struct ctl *ctl, const struct settings_plan *plan)
{
    char what[64];
    plan_print(stdout, plan);
    (void)snprintf(what, sizeof what, "%u of %u settings done",
                   (unsigned)(plan->count - plan->refused),
                   (unsigned)plan->count);
    text_print_answer(ctl, what, &plan->answer);
}

static enum exit_status finish(const struct ctl *ctl,
                               const struct settings_plan *plan)
{
    if (ctl->options.json) {
        print_json(ctl, plan, plan->refused == 0 && !plan->has_unnamed);
    } else {
        print_text(ctl, plan);
    }
    return plan_judge(plan);
}

enum exit_status command_apply(struct ctl *ctl, int count, char **words)
{
    struct settings_plan plan = {.file = NULL};
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
        plan_print(stderr, &plan);
    }
    status = plan_send(ctl, &plan);
    return status == EXIT_DONE && plan.has_answer ? finish(ctl, &plan) : status;
}
