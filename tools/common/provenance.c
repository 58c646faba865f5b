#include "provenance.h"

#include "base/system.h"
#include "utf8.h"

#include "lum/version.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define ITEM_BYTES 320u /* of a text in quotes; a longer one is cut */

/* A text in the making, cut where it is full. */
struct text {
    char *at;
    size_t len;
    size_t room;
};

LUM_PRINTF(2, 3)
static void add(struct text *t, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int n =
        vsnprintf(t->at + t->len, t->room - t->len, format, arguments);
    va_end(arguments);
    const size_t left = t->room - t->len - 1u;
    t->len += n < 0 ? 0u : (size_t)n < left ? (size_t)n : left;
}

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

static void add_quoted(struct text *t, const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    char item[ITEM_BYTES];
    struct text quoted = {item, 0, sizeof item};
    item[0] = '\0';
    while (*p != '\0') {
        const size_t n = utf8_length(p);
        char escaped[12];
        escape(p, n, escaped);
        if (quoted.len + strlen(escaped) + sizeof "..." > sizeof item) {
            add(&quoted, "...");
            break;
        }
        add(&quoted, "%s", escaped);
        p += n == 0 ? 1 : n;
    }
    add(t, "\"%s\"", item);
}

/* The folders of a file are nobody else's business. */
static const char *name_of(const char *source)
{
    if (strcmp(source, "-") == 0) {
        return "standard input";
    }
    return strncmp(source, "udp://", 6) == 0 ? source : lum_system_base(source);
}

/* The sensors' places in it, by which files name them. */
static void add_rig(struct text *t, const struct provenance_run *run)
{
    add(t, "%s", run->sensor_count > 0 ? "rig:\n" : "");
    for (size_t i = 0; i < run->sensor_count; i++) {
        add(t, "  - ");
        add_quoted(t, run->sensors[i]);
        add(t, "\n");
    }
}

static void make_origin(const struct provenance_run *run,
                        const struct geometry *geometry, struct provenance *out)
{
    static const char *const uses[] = {"built-in", "below"};
    struct text t = {out->origin, 0, sizeof out->origin};
    add(&t, PROVENANCE_MARK "origin 1\nprogram: ");
    add_quoted(&t, out->program);
    add(&t, "\nsource: ");
    add_quoted(&t, name_of(run->source));
    add(&t, "\n%s", run->option_count > 0 ? "options:\n" : "");
    for (size_t i = 0; i < run->option_count; i++) {
        add(&t, "  - ");
        add_quoted(&t, run->options[i]);
        add(&t, "\n");
    }
    add_rig(&t, run);
    if (run->sensor_count < 2u) {
        add(&t, "calibration: %s\nprofile: %s\n",
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
    struct text t = {out->text, 0, sizeof out->text};
    for (size_t i = 0; i < out->comment_count; i++) {
        add(&t, "%s%s", i > 0 ? "---\n" : "", out->comments[i]);
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
