/* A profile as YAML, with the evidence. */
#include "lum/infer/infer.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Text that is cut where its room ends, and counted on. */
typedef struct text {
    char *out;
    size_t room;
    size_t len;
} text;

LUM_PRINTF(2, 3)
static void add(text *t, const char *format, ...)
{
    char line[2 * LUM_INFER_TEXT_BYTES];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    for (const char *c = line; *c != '\0'; c++) {
        if (t->len + 1 < t->room) {
            t->out[t->len] = *c;
            t->out[t->len + 1] = '\0';
        }
        t->len++;
    }
}

static void add_comments(text *t, const lum_infer_finding *f,
                         const char *indent)
{
    add(t, "%s# %s%s\n", indent, f->is_told ? "" : "Not told. ", f->evidence);
    if (f->equal[0] != '\0') {
        add(t, "%s# Fits as well: %s\n", indent, f->equal);
    }
    if (f->look[0] != '\0') {
        add(t, "%s# To decide: %s\n", indent, f->look);
    }
}

/* The last part of a key. */
static const char *last_of(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot == NULL ? name : dot + 1;
}

/* The clock's unit is a value of its field. */
static void add_clock(text *t, const lum_infer_finding *clock,
                      const lum_infer_finding *unit)
{
    const size_t len = strlen(clock->value);
    add_comments(t, clock, "  ");
    if (clock->value[0] != '{') {
        add(t, "  timestamp: %s\n", clock->value);
        return;
    }
    add_comments(t, unit, "  ");
    add(t, "  timestamp: %.*s, unit_ns: %s}\n", (int)(len - 1u), clock->value,
        unit->value);
}

static void add_group(text *t, const lum_infer_result *result)
{
    const lum_infer_finding *all = result->findings;
    add(t, "group:\n");
    for (unsigned key = LUM_INFER_TAG; key <= LUM_INFER_SAMPLES; key++) {
        if (key == LUM_INFER_TIMESTAMP) {
            add_clock(t, &all[LUM_INFER_TIMESTAMP], &all[LUM_INFER_CLOCK_UNIT]);
        } else if (key != LUM_INFER_CLOCK_UNIT) {
            add_comments(t, &all[key], "  ");
            add(t, "  %s: %s\n", last_of(all[key].name), all[key].value);
        }
    }
}

size_t lum_infer_write_yaml(const lum_infer_result *result, char *out,
                            size_t room)
{
    text t = {.out = out, .room = room};
    if (room > 0) {
        out[0] = '\0';
    }
    if (!result->has_profile) {
        return 0;
    }
    const lum_infer_finding *all = result->findings;
    add(&t, "# The layout that explains a capture: %s.\n", result->text);
    add(&t, "version: 1\n");
    add_comments(&t, &all[LUM_INFER_DATA_PACKET_TYPE], "");
    add(&t, "data_packet_type: %s\n", all[LUM_INFER_DATA_PACKET_TYPE].value);
    add_group(&t, result);
    for (unsigned key = LUM_INFER_EYE_VALUES; key < LUM_INFER_KEYS; key++) {
        add_comments(&t, &all[key], "");
        add(&t, "%s: %s\n", all[key].name, all[key].value);
    }
    return t.len;
}
