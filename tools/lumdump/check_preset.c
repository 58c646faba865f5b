/* `--check-preset`: which fields of a point a cloud has, by its header, and
 * what it lacks for a program that reads it. */
#include "runs.h"

#include "../common/source_url.h"
#include "capture/mcap_messages.h"
#include "cloud/presets.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_MAX_BYTES 4096u
#define HEADER_LINES   4096u

#define FIELDS_MAX 64u

struct cloud_field {
    char name[64];
    unsigned type; /* a lum_number_type, or LUM_NUMBER_TYPES: another */
    char word[16]; /* the type as the file has it */
    uint64_t offset;
};

struct cloud_fields {
    unsigned count;
    bool has_types;  /* CSV has none */
    bool has_places; /* a point has all fields one behind the other */
    struct cloud_field at[FIELDS_MAX];
};

static struct cloud_field *add(struct cloud_fields *out, const char *name,
                               size_t n)
{
    if (out->count == FIELDS_MAX) {
        return NULL;
    }
    struct cloud_field *f = &out->at[out->count++];
    *f = (struct cloud_field){.type = LUM_NUMBER_TYPES, .word = "?"};
    (void)snprintf(f->name, sizeof f->name, "%.*s", (int)(n < 63u ? n : 63u),
                   name);
    return f;
}

/* Those of messages that have no preset. */
static void take_default_messages(struct cloud_fields *out)
{
    const lum_preset *preset = &lum_preset_of_messages;
    *out = (struct cloud_fields){.has_types = true, .has_places = true};
    for (unsigned i = 0; i < preset->count; i++) {
        struct cloud_field *f =
            add(out, preset->fields[i].name, strlen(preset->fields[i].name));
        f->type = preset->fields[i].type;
        f->offset = lum_preset_offset(preset, i);
    }
}

/* --- Text headers --- */

/* The next word of a line. */
static size_t next_word(const char **p)
{
    *p += strspn(*p, " \t\r\n");
    return strcspn(*p, " \t\r\n");
}

static bool is_word(const char *p, size_t n, const char *word)
{
    return word != NULL && strlen(word) == n && strncmp(p, word, n) == 0;
}

/* A line of PCD behind its key: a word for each field. */
static void take_pcd(struct cloud_fields *out, char key, const char *p)
{
    unsigned i = 0;
    for (size_t n = next_word(&p); n > 0; n = next_word(&p), i++) {
        struct cloud_field *f = i < out->count ? &out->at[i] : NULL;
        if (key == 'F') {
            (void)add(out, p, n);
        } else if (f != NULL && key == 'S') {
            f->offset = (uint64_t)strtoul(p, NULL, 10); /* its size, as yet */
        } else if (f != NULL && key == 'T') {
            (void)snprintf(f->word, sizeof f->word, "%c%u", *p,
                           (unsigned)f->offset & 0xffu);
        }
        p += n;
    }
}

static void finish_pcd(struct cloud_fields *out)
{
    uint64_t offset = 0;
    for (unsigned i = 0; i < out->count; i++) {
        struct cloud_field *f = &out->at[i];
        const uint64_t bytes = f->offset;
        for (unsigned k = 0; k < LUM_NUMBER_TYPES; k++) {
            if (f->word[0] == lum_number_types[k].pcd &&
                bytes == lum_number_types[k].bytes) {
                f->type = k;
            }
        }
        f->offset = offset;
        offset += bytes;
    }
}

static int read_pcd(FILE *file, struct cloud_fields *out)
{
    char line[LINE_MAX_BYTES];
    for (unsigned i = 0;
         i < HEADER_LINES && fgets(line, (int)sizeof line, file) != NULL; i++) {
        const char *p = line;
        const size_t n = next_word(&p);
        if (is_word(p, n, "FIELDS") || is_word(p, n, "SIZE") ||
            is_word(p, n, "TYPE")) {
            take_pcd(out, *p, p + n);
        }
        if (is_word(p, n, "DATA")) {
            finish_pcd(out);
            return 0;
        }
    }
    return -1;
}

/* PLY has two names for each type. */
static unsigned ply_type(const char *p, size_t n)
{
    for (unsigned k = 0; k < LUM_NUMBER_TYPES; k++) {
        if (is_word(p, n, lum_number_types[k].ply) ||
            is_word(p, n, lum_number_types[k].other_ply)) {
            return k;
        }
    }
    return LUM_NUMBER_TYPES;
}

static void take_ply(struct cloud_fields *out, const char *p)
{
    const char *type = p;
    const size_t type_n = next_word(&type);
    const char *name = type + type_n;
    const size_t n = next_word(&name);
    struct cloud_field *f = n > 0 ? add(out, name, n) : NULL;
    if (f != NULL) {
        f->type = ply_type(type, type_n);
        (void)snprintf(f->word, sizeof f->word, "%.*s",
                       (int)(type_n < 15u ? type_n : 15u), type);
    }
}

static int read_ply(FILE *file, struct cloud_fields *out)
{
    char line[LINE_MAX_BYTES];
    bool is_vertex = false;
    for (unsigned i = 0;
         i < HEADER_LINES && fgets(line, (int)sizeof line, file) != NULL; i++) {
        const char *p = line;
        const size_t n = next_word(&p);
        if (is_word(p, n, "element")) {
            p += n;
            is_vertex = is_word(p, next_word(&p), "vertex") ||
                        strncmp(p, "vertex ", 7) == 0;
        } else if (is_word(p, n, "property") && is_vertex) {
            take_ply(out, p + n);
        } else if (is_word(p, n, "end_header")) {
            return 0;
        }
    }
    return -1;
}

static int read_csv(FILE *file, struct cloud_fields *out)
{
    char line[LINE_MAX_BYTES] = "#";
    while (line[0] == '#') {
        if (fgets(line, (int)sizeof line, file) == NULL) {
            return -1;
        }
    }
    for (const char *p = line; *p != '\0';) {
        const size_t n = strcspn(p, ",\r\n");
        if (n > 0) {
            (void)add(out, p, n);
        }
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
    out->has_types = false;
    out->has_places = false;
    return 0;
}

/* --- MCAP --- */

/* A message in CDR of the usual byte order. */
struct cursor {
    const uint8_t *at;
    size_t left;
    size_t done; /* since the alignment's begin */
    bool failed;
};

static const uint8_t *take_bytes(struct cursor *c, size_t n)
{
    const uint8_t *at = c->at;
    if (n > c->left) {
        c->failed = true;
        n = c->left;
    }
    c->at += n;
    c->left -= n;
    c->done += n;
    return at;
}

static uint32_t take_u32(struct cursor *c)
{
    (void)take_bytes(c, (4u - c->done % 4u) % 4u);
    const uint8_t *at = take_bytes(c, 4);
    uint32_t v = 0;
    for (unsigned i = 0; i < 4u && !c->failed; i++) {
        v |= (uint32_t)at[i] << 8u * i;
    }
    return v;
}

static void take_field(struct cursor *c, struct cloud_fields *out)
{
    const uint32_t n = take_u32(c);
    const uint8_t *name = take_bytes(c, n);
    const uint32_t offset = take_u32(c);
    const uint8_t *type = take_bytes(c, 1);
    (void)take_u32(c); /* its count */
    struct cloud_field *f =
        c->failed || n == 0 ? NULL : add(out, (const char *)name, n - 1u);
    if (f == NULL) {
        c->failed = true;
        return;
    }
    f->offset = offset;
    (void)snprintf(f->word, sizeof f->word, "type %u", (unsigned)*type);
    for (unsigned k = 0; k < LUM_NUMBER_TYPES; k++) {
        const bool is_it = *type != 0 && lum_number_types[k].ros == *type;
        f->type = is_it ? k : f->type;
    }
}

/* A sensor_msgs/msg/PointCloud2 up to its fields. */
static int take_cloud(const lum_mcap_message *m, struct cloud_fields *out)
{
    struct cursor c = {m->bytes, m->len, 0, false};
    (void)take_bytes(&c, 4); /* how it is written */
    c.done = 0;
    (void)take_bytes(&c, 8); /* stamp */
    (void)take_bytes(&c, take_u32(&c));
    (void)take_u32(&c); /* height */
    (void)take_u32(&c); /* width */
    const uint32_t count = take_u32(&c);
    for (uint32_t i = 0; i < count && !c.failed; i++) {
        take_field(&c, out);
    }
    return c.failed ? -1 : 0;
}

/* Of the first cloud. */
static int find_cloud(lum_mcap_messages *file, struct cloud_fields *out)
{
    lum_error why;
    lum_mcap_message m;
    lum_mcap_event event = LUM_MCAP_HAS_TOPIC;
    while (event > LUM_MCAP_ENDED) {
        event = lum_mcap_messages_next(file, &m, &why);
        if (event == LUM_MCAP_HAS_MESSAGE &&
            strcmp(m.topic->type, "sensor_msgs/msg/PointCloud2") == 0) {
            return take_cloud(&m, out);
        }
    }
    return -1;
}

static int read_mcap(const char *path, struct cloud_fields *out,
                     lum_error *error)
{
    lum_source *source = NULL;
    if (lum_source_open(path, &source, error) != 0) {
        return -1;
    }
    lum_mcap_messages *file = lum_mcap_messages_new(source, error);
    if (file == NULL || find_cloud(file, out) != 0) {
        out->count = 0;
    }
    lum_mcap_messages_free(file);
    lum_source_close(source);
    return 0;
}

/* --- Any cloud --- */

typedef int text_reader(FILE *file, struct cloud_fields *out);

static int read_text(const char *path, text_reader *read,
                     struct cloud_fields *out, lum_error *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return lum_error_set(error, "%s: %s", path, strerror(errno));
    }
    if (read(file, out) != 0) {
        out->count = 0;
    }
    (void)fclose(file);
    return 0;
}

/* -1 with the reason in error. */
static int read_cloud(const char *path, struct cloud_fields *out,
                      lum_error *error)
{
    static text_reader *const readers[LUM_FORMATS] = {
        [LUM_FORMAT_PCD] = read_pcd,
        [LUM_FORMAT_PLY] = read_ply,
        [LUM_FORMAT_CSV] = read_csv};
    lum_format format = LUM_FORMAT_LAS;
    const bool is_known = lum_format_from_name(path, &format) == 0;
    const bool is_mcap = format == LUM_FORMAT_MCAP;
    *out = (struct cloud_fields){.has_types = true};
    if (!is_known || (readers[format] == NULL && !is_mcap)) {
        return lum_error_set(error,
                             "%s: fields are looked for in .pcd, .ply, .csv "
                             "and .mcap, and in captures and sensors",
                             path);
    }
    out->has_places = format == LUM_FORMAT_PCD || is_mcap;
    if ((is_mcap ? read_mcap(path, out, error)
                 : read_text(path, readers[format], out, error)) != 0) {
        return -1;
    }
    return out->count > 0
               ? 0
               : lum_error_set(error, "%s: no fields of a point are found",
                               path);
}

/* --- The check --- */

/* What lumdump makes clouds of. */
static bool is_source(const char *name)
{
    static const char *const endings[] = {".pcap",     ".pcapng",
                                          ".pcap.gz",  ".pcapng.gz",
                                          ".pcap.zst", ".pcapng.zst"};
    bool is = source_url_is_sensor(name);
    for (size_t i = 0; i < sizeof endings / sizeof endings[0]; i++) {
        is = is || options_has_ending(name, endings[i]);
    }
    return is;
}

static const struct cloud_field *find(const struct cloud_fields *cloud,
                                      const char *name)
{
    for (unsigned i = 0; i < cloud->count; i++) {
        if (strcmp(cloud->at[i].name, name) == 0) {
            return &cloud->at[i];
        }
    }
    return NULL;
}

/* Prints a row; whether the field is as it is wanted. */
static bool check(const lum_preset *preset, unsigned i,
                  const struct cloud_fields *cloud)
{
    const lum_preset_field *want = &preset->fields[i];
    const char *type = lum_number_types[want->type].name;
    const struct cloud_field *found = find(cloud, want->name);
    const size_t offset = lum_preset_offset(preset, i);
    if (found == NULL) {
        (void)printf("%-16s %-7s %-7s missing\n", want->name, type, "-");
        return false;
    }
    const char *word = found->type < LUM_NUMBER_TYPES
                           ? lum_number_types[found->type].name
                           : found->word;
    if (cloud->has_types && found->type != want->type) {
        (void)printf("%-16s %-7s %-7s another type\n", want->name, type, word);
        return false;
    }
    if (preset->is_in_places && cloud->has_places && found->offset != offset) {
        (void)printf("%-16s %-7s %-7s at byte %" PRIu64 ", wanted at %zu\n",
                     want->name, type, word, found->offset, offset);
        return false;
    }
    if (preset->is_in_places && !cloud->has_places && found != &cloud->at[i]) {
        (void)printf("%-16s %-7s %-7s in another place\n", want->name, type,
                     word);
        return false;
    }
    (void)printf("%-16s %-7s %-7s none\n", want->name, type, word);
    return true;
}

static int read_fields(const char *name, struct cloud_fields *out,
                       lum_error *error)
{
    if (is_source(name)) {
        take_default_messages(out);
        return 0;
    }
    return read_cloud(name, out, error);
}

enum exit_status check_preset_run(const struct options *options)
{
    struct cloud_fields cloud;
    lum_error error = {""};
    unsigned wrong = 0;
    const lum_preset *preset =
        lum_preset_find(options->instead.check_preset, &error);
    if (preset == NULL || read_fields(options->source, &cloud, &error) != 0) {
        return conclude_error(&error, EXIT_BAD);
    }
    if (is_source(options->source)) {
        (void)printf("%s is packets; this is about the messages that lumdump "
                     "makes of them without --preset.\n",
                     options->source);
    }
    (void)printf("%-16s %-7s %-7s %s\n", "field", "wanted", "found",
                 "difference");
    for (unsigned i = 0; i < preset->count; i++) {
        wrong += check(preset, i, &cloud) ? 0u : 1u;
    }
    (void)printf(wrong == 0 ? "%s can read it.\n"
                            : "%s cannot read it: make it by --preset %s.\n",
                 preset->name, preset->name);
    const enum exit_status status = conclude_stdout();
    return status == EXIT_DONE && wrong > 0 ? EXIT_FAILED : status;
}
