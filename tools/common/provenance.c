#include "provenance.h"

#include "base/system.h"
#include "base/text.h"
#include "printable.h"

#include "lum/version.h"

#include <stdio.h>
#include <string.h>

#define ITEM_BYTES 320u /* of a text in quotes; a longer one is cut */

/* Printable ASCII, as YAML and JSON escape what is not. */
static void escape(const unsigned char *p, size_t length, char out[12])
{
    const uint32_t c = length == 0 ? 0xfffdu : utf8_character(p, length);
    if (c >= 0x20u && c < 0x7fu) {
        const bool is_special = c == '"' || c == '\\';
        (void)snprintf(out, 12, "%s%c", is_special ? "\\" : "", (char)c);
    } else {
        (void)snprintf(out, 12, c <= 0xffffu ? "\\u%04lx" : "\\U%08lx",
                       (unsigned long)c);
    }
}

/* A line: a text in quotes behind a head. */
static void add_quoted(struct provenance *out, const char *head,
                       const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    char item[ITEM_BYTES] = "";
    while (*p != '\0') {
        const size_t n = utf8_length(p);
        char escaped[12];
        escape(p, n, escaped);
        if (strlen(item) + strlen(escaped) + sizeof "..." > sizeof item) {
            lum_text_add(item, sizeof item, "...");
            break;
        }
        lum_text_add(item, sizeof item, "%s", escaped);
        p += n == 0 ? 1 : n;
    }
    lum_text_add(out->origin, sizeof out->origin, "%s\"%s\"\n", head, item);
}

/* The folders of a file are nobody else's business. */
static const char *name_of(const char *source)
{
    if (strcmp(source, "-") == 0) {
        return "standard input";
    }
    return strncmp(source, "udp://", 6) == 0 ? source : lum_system_base(source);
}

static void add_list(struct provenance *out, const char *head,
                     const char *const *list, size_t count)
{
    lum_text_add(out->origin, sizeof out->origin, "%s", count > 0 ? head : "");
    for (size_t i = 0; i < count; i++) {
        add_quoted(out, "  - ", list[i]);
    }
}

/* The places of a rig's sensors are those by which files name them. */
static void make_origin(const struct provenance_run *run,
                        const struct geometry *geometry, struct provenance *out)
{
    static const char *const uses[] = {"built-in", "below"};
    (void)snprintf(out->origin, sizeof out->origin,
                   PROVENANCE_MARK "origin 1\n");
    add_quoted(out, "program: ", out->program);
    add_quoted(out, "source: ", name_of(run->source));
    add_list(out, "options:\n", run->options, run->option_count);
    add_list(out, "rig:\n", run->sensors, run->sensor_count);
    if (run->sensor_count < 2u) {
        lum_text_add(out->origin, sizeof out->origin,
                     "calibration: %s\nprofile: %s\n",
                     uses[geometry->has_calibration ? 1 : 0],
                     uses[geometry->has_profile ? 1 : 0]);
    }
}

static void write_keys(const char *kind, const lum_keys *keys,
                       char out[PROVENANCE_KEYS_BYTES])
{
    const int n =
        snprintf(out, PROVENANCE_KEYS_BYTES, PROVENANCE_MARK "%s 1\n", kind);
    (void)lum_keys_write(keys, out + n, PROVENANCE_KEYS_BYTES - (size_t)n);
}

static void add_comment(struct provenance *out, const char *comment)
{
    if (comment[0] != '\0') {
        out->comments[out->comment_count++] = comment;
    }
}

static void join(struct provenance *out)
{
    out->text[0] = '\0';
    for (size_t i = 0; i < out->comment_count; i++) {
        lum_text_add(out->text, sizeof out->text, "%s%s", i > 0 ? "---\n" : "",
                     out->comments[i]);
    }
}

void provenance_make(const struct provenance_run *run,
                     const struct geometry *geometry,
                     const struct provenance_source *source,
                     struct provenance *out)
{
    lum_keys keys;
    out->comment_count = 0;
    out->calibration[0] = '\0';
    out->profile[0] = '\0';
    (void)snprintf(out->program, sizeof out->program, "%s " LUM_VERSION,
                   run->program);
    make_origin(run, geometry, out);
    if (geometry->has_calibration) {
        lum_keys_of_calibration(&keys, &geometry->calibration);
        write_keys("calibration", &keys, out->calibration);
    }
    if (geometry->has_profile) {
        lum_keys_of_profile(&keys, &geometry->profile);
        write_keys("profile", &keys, out->profile);
    }
    add_comment(out, out->origin);
    add_comment(out, out->calibration);
    add_comment(out, out->profile);
    for (size_t i = 0; source != NULL && i < source->earlier_count; i++) {
        add_comment(out, source->earlier[i]);
    }
    join(out);
}
