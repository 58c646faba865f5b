/* What is remembered of a sensor's settings, for people, as JSON and as YAML
 * that apply takes. */
#include "remember.h"

#include "ctl_session.h"
#include "setting.h"
#include "status_report.h"
#include "yscan/yscan_table.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const char *const remarks[MEMORY_STANDINGS] = {
    [MEMORY_DONE] = "",
    [MEMORY_UNSURE] = "  was sent; whether it took effect is not known",
    [MEMORY_OLD] = "  whether it has restarted since is not known",
};

/* --- show --- */

/* A sensor's name and its interface's. */
struct who {
    char text[SESSION_NAME_BYTES + MEMORY_NAME_BYTES + 8];
};

static struct who who(const struct remembered *r)
{
    struct who out;
    const lum_endpoint host = {r->key.address, r->key.port};
    (void)snprintf(out.text, sizeof out.text, "%s%s%s", session_name(host).text,
                   r->key.interface[0] != '\0' ? " on " : "", r->key.interface);
    return out;
}

/* Of a calibration without a file there is what was set alone. */
static const char *how_made(const struct remembered *r)
{
    return strncmp(r->memory.table.from, "--set ", 6) == 0
               ? "with"
               : "with --calibration";
}

static bool is_known(const struct remembered *r, lum_command_id id)
{
    return r->memory.entries[id].standing != MEMORY_NOTHING;
}

/* What the sensor's clock says about the time since. */
static void print_run(FILE *out, const struct remembered *r, const char *before)
{
    if (!r->has_answered) {
        (void)fprintf(out,
                      "%sIt does not answer: whether it has restarted since is "
                      "not known.\n",
                      before);
    } else if (r->run == MEMORY_SAME_RUN) {
        (void)fprintf(out,
                      "%sIts clock shows no restart since; one would be missed "
                      "in %.2g %% of cases.\n",
                      before, 100.0 * r->missed);
    } else if (r->run == MEMORY_RUN_UNKNOWN) {
        (void)fprintf(
            out, "%sIts clock does not show whether it has restarted since.\n",
            before);
    }
}

static void print_table(const struct remembered *r)
{
    (void)printf("%s, as far as this host knows:\n", who(r).text);
    (void)printf("  %-15s  %-22s  %s\n", "setting", "value", "sent at");
    for (size_t i = 0; i < SETTINGS; i++) {
        const struct memory_entry *e = &r->memory.entries[settings[i].id];
        if (e->standing != MEMORY_NOTHING) {
            (void)printf("  %-15s  %-22s  %s%s\n", settings[i].name,
                         memory_value(&r->memory, settings[i].id).text,
                         report_utc(e->utc_ns).text, remarks[e->standing]);
        }
    }
    if (is_known(r, LUM_COMMAND_YSCAN) &&
        r->memory.table.scan != MEMORY_DEGREES &&
        r->memory.table.from[0] != '\0') {
        (void)printf("  the table was made %s %s\n",
                     r->memory.table.scan == MEMORY_SHAPE ? how_made(r)
                                                          : "from",
                     r->memory.table.from);
    }
    print_run(stdout, r, "  ");
    (void)puts("  What others set, and what is not listed, is not known: the "
               "sensor cannot be asked.");
}

static void put_restart(struct json *json, const struct memory *memory)
{
    if (memory->restart_to_ns == 0) {
        json_null(json, "restart");
        return;
    }
    json_open_object(json, "restart");
    json_text(json, "after", report_utc(memory->restart_from_ns).text);
    json_text(json, "before", report_utc(memory->restart_to_ns).text);
    json_close_object(json);
}

static void put_setting(struct json *json, const struct memory *memory,
                        lum_command_id id)
{
    const struct memory_entry *e = &memory->entries[id];
    json_open_object(json, NULL);
    json_text(json, "setting", setting_name(id));
    json_text(json, "value", memory_value(memory, id).text);
    json_text(json, "time", report_utc(e->utc_ns).text);
    json_text(json, "standing", memory_standings[e->standing]);
    json_close_object(json);
}

static void print_json(const struct remembered *r)
{
    struct json json;
    const lum_endpoint host = {r->key.address, r->key.port};
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", session_name(host).text);
    json_text(&json, "interface", r->key.interface);
    json_bool(&json, "answers", r->has_answered);
    if (r->has_file && r->run != MEMORY_RUN_UNKNOWN) {
        json_bool(&json, "restarted", r->run == MEMORY_OTHER_RUN);
        json_real(&json, "missed", r->missed, 6);
    } else {
        json_null(&json, "restarted");
        json_null(&json, "missed");
    }
    put_restart(&json, &r->memory);
    json_open_array(&json, "settings");
    for (size_t i = 0; i < SETTINGS; i++) {
        if (is_known(r, settings[i].id)) {
            put_setting(&json, &r->memory, settings[i].id);
        }
    }
    json_close_array(&json);
    json_end_line(&json);
}

/* Nothing is known: why. */
static enum exit_status complain_nothing(const struct remembered *r)
{
    const struct who sensor = who(r);
    if (r->memory.restart_to_ns == 0) {
        return ctl_complain(
            EXIT_FAILED,
            "nothing is known of %s: there is no record that it acknowledged "
            "a setting that lumctl of this user on this host sent",
            sensor.text);
    }
    return ctl_complain(
        EXIT_FAILED,
        "nothing is known of %s any more: by its clock it has restarted "
        "between %s and %s and forgotten its settings (or it is another "
        "sensor, or this host's clock was set)",
        sensor.text, report_utc(r->memory.restart_from_ns).text,
        report_utc(r->memory.restart_to_ns).text);
}

enum exit_status command_show(struct ctl *ctl, int count, char **words)
{
    struct remembered r;
    (void)count;
    (void)words;
    const enum exit_status status = remember_look(ctl, &r);
    const bool has_any = memory_has_any(&r.memory);
    if (ctl->options.json) {
        print_json(&r);
    } else if (has_any) {
        print_table(&r);
    }
    if (!has_any) {
        const enum exit_status nothing = complain_nothing(&r);
        return status == EXIT_DONE ? nothing : status;
    }
    return status;
}

/* --- save: the Y scan --- */

/* Millionths of a degree, without what says nothing. */
static void put_degrees(const char *key, int32_t udeg)
{
    const int64_t size = udeg < 0 ? -(int64_t)udeg : udeg;
    char text[32];
    const int n = snprintf(text, sizeof text, "%s%" PRId64 ".%06" PRId64,
                           udeg < 0 ? "-" : "", size / 1000000, size % 1000000);
    size_t len = n > 0 ? (size_t)n : 0;
    while (len > 0 && text[len - 1] == '0') {
        len--;
    }
    len -= len > 0 && text[len - 1] == '.' ? 1u : 0u;
    (void)printf("%s: %.*s", key, (int)len, text);
}

static void put_regions(const lum_yscan_shape *s)
{
    (void)puts("  regions:");
    for (size_t i = 0; i < s->region_count; i++) {
        (void)printf("    %u: {", (unsigned)i + 1u);
        put_degrees("min_deg", s->regions[i].min_udeg);
        (void)fputs(", ", stdout);
        put_degrees("max_deg", s->regions[i].max_udeg);
        (void)printf(", weight: %" PRIu32 "}\n", s->regions[i].weight);
    }
}

static void put_row(const char *key, int32_t udeg)
{
    (void)fputs("  ", stdout);
    put_degrees(key, udeg);
    (void)putchar('\n');
}

static void put_shape(const lum_yscan_shape *s)
{
    (void)printf("yscan:\n  shape: %s\n", setting_shapes[s->kind]);
    if (s->kind == LUM_YSCAN_REGIONS) {
        put_regions(s);
        return;
    }
    if (s->min_udeg != INT32_MIN) {
        put_row("min_deg", s->min_udeg);
    }
    if (s->max_udeg != INT32_MAX) {
        put_row("max_deg", s->max_udeg);
    }
    if (s->kind == LUM_YSCAN_GAUSSIAN) {
        put_row("center_deg", s->center_udeg);
        put_row("sigma_deg", s->sigma_udeg);
    }
}

/* --- save: known and unknown settings --- */

static bool is_sure(const struct remembered *r, lum_command_id id)
{
    return is_known(r, id) && r->memory.entries[id].standing != MEMORY_UNSURE;
}

static unsigned lines_of(const struct remembered *r)
{
    return setting_lines(r->memory.entries[LUM_COMMAND_LINE_MODE].value);
}

/* Why a setting cannot be written to a file; NULL: it can. */
static const char *lack_of(const struct remembered *r, lum_command_id id)
{
    const struct memory *m = &r->memory;
    const unsigned table_lines = m->entries[LUM_COMMAND_YSCAN].value;
    if (!is_sure(r, id)) {
        return "it was sent, and whether it took effect is not known";
    }
    if (id != LUM_COMMAND_YSCAN || m->table.scan == MEMORY_DEGREES) {
        return NULL;
    }
    if (m->table.scan == MEMORY_TABLE) {
        return "no settings file can hold single elevations";
    }
    if (is_sure(r, LUM_COMMAND_LINE_MODE) && lines_of(r) != table_lines) {
        return "its table is for other lines than those that were set";
    }
    return table_lines == YSCAN_LINES || table_lines == YSCAN_LINES_FEW
               ? NULL
               : "its table is for other lines than a frame has";
}

/* The lines that a table was made for, where no command has set them. */
static bool needs_lines(const struct remembered *r)
{
    return !is_sure(r, LUM_COMMAND_LINE_MODE) &&
           is_known(r, LUM_COMMAND_YSCAN) &&
           r->memory.table.scan == MEMORY_SHAPE &&
           lack_of(r, LUM_COMMAND_YSCAN) == NULL;
}

static void put_value(const struct remembered *r, lum_command_id id)
{
    const struct memory_entry *e = &r->memory.entries[id];
    (void)printf("# %s: sent %s%s\n", setting_name(id),
                 report_utc(e->utc_ns).text,
                 e->standing == MEMORY_OLD
                     ? "; whether it has restarted since is not known"
                     : "");
    if (id == LUM_COMMAND_YSCAN && r->memory.table.scan == MEMORY_SHAPE) {
        if (r->memory.table.from[0] != '\0') {
            (void)printf("# %s %s\n", how_made(r), r->memory.table.from);
        }
        put_shape(&r->memory.table.shape);
    } else if (id == LUM_COMMAND_LINE_MODE) {
        (void)printf("lines: %u\n", lines_of(r));
    } else {
        (void)printf("%s: %u\n", setting_name(id), (unsigned)e->value);
    }
}

static void put_lack(const struct remembered *r, lum_command_id id,
                     const char *lack)
{
    (void)printf("# left out: %s, %s, sent %s: %s\n", setting_name(id),
                 memory_value(&r->memory, id).text,
                 report_utc(r->memory.entries[id].utc_ns).text, lack);
}

/* Such as "threshold" of "threshold green". */
static size_t key_length(size_t i)
{
    return strcspn(settings[i].name, " ");
}

/* A setting of each eye has a key that both share. */
static bool is_of_eyes(size_t i)
{
    return settings[i].name[key_length(i)] != '\0';
}

static bool is_same_key(size_t i, size_t k)
{
    const size_t len = key_length(i);
    return len == key_length(k) &&
           memcmp(settings[i].name, settings[k].name, len) == 0;
}

static bool has_key_before(size_t i)
{
    size_t k = 0;
    while (!is_same_key(i, k)) {
        k++;
    }
    return k < i;
}

/* The key stands once, for those eyes whose value is sure. */
static void put_eyes(const struct remembered *r, size_t first)
{
    unsigned count = 0;
    for (size_t i = first; i < SETTINGS; i++) {
        if (!is_same_key(i, first) || !is_sure(r, settings[i].id)) {
            continue;
        }
        if (count == 0) {
            (void)printf("%.*s: {", (int)key_length(i), settings[i].name);
        }
        (void)printf("%s%s: %u", count > 0 ? ", " : "",
                     settings[i].name + key_length(i) + 1,
                     (unsigned)r->memory.entries[settings[i].id].value);
        count++;
    }
    (void)fputs(count > 0 ? "}\n" : "", stdout);
}

/* --- save: the file --- */

/* How many settings had to be left out; each is said. */
static unsigned put_yaml(const struct ctl *ctl, const struct remembered *r)
{
    unsigned left_out = 0;
    if (needs_lines(r)) {
        (void)printf("# lines: those that the Y scan's table is for\n"
                     "lines: %u\n",
                     (unsigned)r->memory.entries[LUM_COMMAND_YSCAN].value);
    }
    for (size_t i = 0; i < SETTINGS; i++) {
        const char *lack =
            is_known(r, settings[i].id) ? lack_of(r, settings[i].id) : NULL;
        if (lack != NULL) {
            put_lack(r, settings[i].id, lack);
            (void)ctl_complain(EXIT_FAILED, "%s is left out: %s",
                               settings[i].name, lack);
            left_out++;
        } else if (is_known(r, settings[i].id) && !is_of_eyes(i)) {
            put_value(r, settings[i].id);
        }
    }
    for (size_t i = 0; i < SETTINGS; i++) {
        if (is_of_eyes(i) && !has_key_before(i)) {
            put_eyes(r, i);
        }
    }
    if (r->run != MEMORY_SAME_RUN) {
        ctl_note(ctl, "whether the sensor has restarted since is not known");
    }
    return left_out;
}

enum exit_status command_save(struct ctl *ctl, int count, char **words)
{
    struct remembered r;
    (void)count;
    (void)words;
    if (ctl->options.json) {
        return ctl_complain(EXIT_BAD, "--json does not go with save, which "
                                      "prints YAML: lumctl show --json");
    }
    const enum exit_status status = remember_look(ctl, &r);
    if (!memory_has_any(&r.memory)) {
        const enum exit_status nothing = complain_nothing(&r);
        return status == EXIT_DONE ? nothing : status;
    }
    (void)printf("# Settings of %s, as far as this host knows.\n",
                 who(&r).text);
    print_run(stdout, &r, "# ");
    (void)puts("version: 1");
    const unsigned left_out = put_yaml(ctl, &r);
    return status == EXIT_DONE && left_out > 0 ? EXIT_FAILED : status;
}
