#include "cloud_fields.h"

#include "capture/source_internal.h"
#include "capture/unpack.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_MAX_BYTES  4096u
#define HEADER_LINES    4096u
#define CHUNK_BYTES_MAX (UINT64_C(1) << 28)

static struct cloud_field *add(struct cloud_fields *out, const char *name,
                               size_t n)
{
    if (out->count == CLOUD_FIELDS_MAX) {
        return NULL;
    }
    struct cloud_field *f = &out->at[out->count++];
    *f = (struct cloud_field){.type = LUM_NUMBER_TYPES, .word = "?"};
    (void)snprintf(f->name, sizeof f->name, "%.*s", (int)(n < 63u ? n : 63u),
                   name);
    return f;
}

void cloud_fields_of_messages(struct cloud_fields *out)
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

struct cursor {
    const unsigned char *at;
    size_t left;
    size_t done; /* since the alignment's begin */
    bool failed;
};

static const unsigned char *take_bytes(struct cursor *c, uint64_t n)
{
    const unsigned char *at = c->at;
    if (n > c->left) {
        c->failed = true;
        c->left = 0;
        return at;
    }
    c->at += n;
    c->left -= (size_t)n;
    c->done += (size_t)n;
    return at;
}

static uint64_t take(struct cursor *c, size_t n)
{
    const unsigned char *at = take_bytes(c, n);
    uint64_t v = 0;
    for (size_t i = 0; i < n && !c->failed; i++) {
        v |= (uint64_t)at[i] << 8u * i;
    }
    return v;
}

static uint32_t take_aligned(struct cursor *c)
{
    (void)take_bytes(c, (4u - c->done % 4u) % 4u);
    return (uint32_t)take(c, 4);
}

/* A sensor_msgs/msg/PointCloud2 up to its fields. */
static int take_cloud(struct cursor c, struct cloud_fields *out)
{
    (void)take(&c, 4); /* how it is written */
    c.done = 0;
    (void)take(&c, 8); /* stamp */
    (void)take_bytes(&c, take_aligned(&c));
    (void)take_aligned(&c); /* height */
    (void)take_aligned(&c); /* width */
    const uint32_t count = take_aligned(&c);
    for (uint32_t i = 0; i < count && !c.failed; i++) {
        const uint32_t n = take_aligned(&c);
        const unsigned char *name = take_bytes(&c, n);
        const uint32_t offset = take_aligned(&c);
        const uint64_t type = take(&c, 1);
        (void)take_aligned(&c);
        struct cloud_field *f =
            c.failed || n == 0 ? NULL : add(out, (const char *)name, n - 1u);
        if (f == NULL) {
            return -1;
        }
        f->offset = offset;
        (void)snprintf(f->word, sizeof f->word, "type %u", (unsigned)type);
        for (unsigned k = 0; k < LUM_NUMBER_TYPES; k++) {
            const bool is_it = type != 0 && lum_number_types[k].ros == type;
            f->type = is_it ? k : f->type;
        }
    }
    return c.failed ? -1 : 0;
}

/* Records that are looked at. */
enum {
    SCHEMA = 3,
    CHANNEL = 4,
    MESSAGE = 5,
    CHUNK = 6,
    DATA_END = 15
};

/* Which ids are those of clouds. */
struct ids {
    bool is_schema[UINT16_MAX + 1];
    bool is_channel[UINT16_MAX + 1];
};

/* What one record says. 1: it was a cloud; 0: go on. */
static int take_inner(unsigned op, struct cursor r, struct ids *ids,
                      struct cloud_fields *out)
{
    static const char type[] = "sensor_msgs/msg/PointCloud2";
    const uint16_t id = (uint16_t)take(&r, 2);
    if (op == SCHEMA) {
        const uint32_t len = (uint32_t)take(&r, 4);
        const unsigned char *name = take_bytes(&r, len);
        ids->is_schema[id] = !r.failed && len == sizeof type - 1u &&
                             memcmp(name, type, len) == 0;
    } else if (op == CHANNEL) {
        ids->is_channel[id] = ids->is_schema[(uint16_t)take(&r, 2)];
    } else if (op == MESSAGE && ids->is_channel[id]) {
        (void)take_bytes(&r, 20); /* number and times */
        return take_cloud(r, out) == 0 ? 1 : -1;
    }
    return r.failed ? -1 : 0;
}

/* 1: a cloud; 0: none yet. */
static int take_records(struct cursor c, struct ids *ids,
                        struct cloud_fields *out)
{
    int result = 0;
    while (c.left > 0 && result == 0) {
        const unsigned op = (unsigned)take(&c, 1);
        const uint64_t whole = take(&c, 8);
        /* Of a cloud that is cut, the beginning is enough. */
        const uint64_t n = op == MESSAGE && whole > c.left ? c.left : whole;
        const unsigned char *at = take_bytes(&c, n);
        const struct cursor r = {at, c.failed ? 0 : (size_t)n, 0, c.failed};
        result = take_inner(op, r, ids, out);
    }
    return result;
}

/* Its records as they are, in a zstd frame or not. */
static int take_packed(struct cursor packed, size_t n, struct ids *ids,
                       struct cloud_fields *out)
{
    lum_error error = {""};
    int result = -1;
    lum_source *source =
        lum_source_from_memory("chunk", packed.at, packed.left);
    const size_t wanted = n < LUM_SOURCE_WINDOW_MAX ? n : LUM_SOURCE_WINDOW_MAX;
    if (source != NULL && lum_unpack(&source, &error) == 0) {
        (void)lum_source_has(source, wanted);
        result = take_records(
            (struct cursor){source->at, source->left, 0, false}, ids, out);
    }
    lum_source_close(source);
    return result;
}

static int take_chunk(struct cursor c, struct ids *ids,
                      struct cloud_fields *out)
{
    (void)take_bytes(&c, 16); /* times */
    const uint64_t n = take(&c, 8);
    (void)take(&c, 4); /* check sum */
    const uint64_t name_n = take(&c, 4);
    const unsigned char *name = take_bytes(&c, name_n);
    const uint64_t packed_n = take(&c, 8);
    const unsigned char *at = take_bytes(&c, packed_n);
    const struct cursor packed = {at, c.failed ? 0 : (size_t)packed_n, 0,
                                  c.failed};
    if (c.failed || n > CHUNK_BYTES_MAX) {
        return -1;
    }
    if (name_n == 0) {
        return take_records(packed, ids, out);
    }
    return name_n == 4u && memcmp(name, "zstd", 4) == 0
               ? take_packed(packed, (size_t)n, ids, out)
               : -1;
}

/* One record of the file; 1: it had a cloud. */
static int take_record(FILE *file, struct ids *ids, struct cloud_fields *out)
{
    unsigned char head[9];
    if (fread(head, 1, sizeof head, file) != sizeof head) {
        return -1;
    }
    struct cursor h = {head + 1, 8, 0, false};
    const uint64_t n = take(&h, 8);
    unsigned char *body =
        n <= CHUNK_BYTES_MAX ? malloc(sizeof head + (size_t)n) : NULL;
    int result = -1;
    if (body != NULL &&
        fread(body + sizeof head, 1, (size_t)n, file) == (size_t)n) {
        memcpy(body, head, sizeof head);
        const struct cursor inner = {body + sizeof head, (size_t)n, 0, false};
        const struct cursor whole = {body, sizeof head + (size_t)n, 0, false};
        const bool is_message = head[0] >= SCHEMA && head[0] <= MESSAGE;
        result = head[0] == CHUNK ? take_chunk(inner, ids, out)
                 : is_message     ? take_records(whole, ids, out)
                                  : 0;
        result = head[0] == DATA_END ? -1 : result; /* the end of the data */
    }
    free(body);
    return result;
}

static int read_mcap(FILE *file, struct cloud_fields *out)
{
    static const unsigned char magic[8] = {0x89, 'M', 'C',  'A',
                                           'P',  '0', '\r', '\n'};
    unsigned char first[sizeof magic];
    struct ids *ids = calloc(1, sizeof *ids);
    int result = -1;
    if (ids != NULL && fread(first, 1, sizeof first, file) == sizeof first &&
        memcmp(first, magic, sizeof magic) == 0) {
        do {
            result = take_record(file, ids, out);
        } while (result == 0);
    }
    free(ids);
    return result == 1 ? 0 : -1;
}

/* --- Any of them --- */

int cloud_fields_read(const char *path, struct cloud_fields *out,
                      lum_error *error)
{
    static int (*const readers[LUM_FORMATS])(FILE *, struct cloud_fields *) = {
        [LUM_FORMAT_PCD] = read_pcd,
        [LUM_FORMAT_PLY] = read_ply,
        [LUM_FORMAT_CSV] = read_csv,
        [LUM_FORMAT_MCAP] = read_mcap};
    lum_format format = LUM_FORMAT_LAS;
    *out = (struct cloud_fields){.has_types = true};
    if (lum_format_from_name(path, &format) != 0 || readers[format] == NULL) {
        return lum_error_set(error,
                             "%s: fields are looked for in .pcd, .ply, .csv "
                             "and .mcap, and in captures and sensors",
                             path);
    }
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return lum_error_set(error, "%s: %s", path, strerror(errno));
    }
    out->has_places = format == LUM_FORMAT_PCD || format == LUM_FORMAT_MCAP;
    const int result = readers[format](file, out);
    (void)fclose(file);
    return result == 0 && out->count > 0
               ? 0
               : lum_error_set(error, "%s: no fields of a point are found",
                               path);
}
