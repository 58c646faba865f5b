/* A file under its name is whole, at any moment (docs/man/lumdump.1, FILES). */
#include "judge.h"
#include "packets.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char whole[] = "file-whole";

static void broken(const judge_file *file, const char *why, struct verdict *out)
{
    verdict_broken(out, whole, file->t_ns, "%s: %s", file->name, why);
}

/* --- Text --- */

static size_t count_of(const uint8_t *bytes, size_t size, uint8_t byte)
{
    size_t n = 0;
    for (size_t i = 0; i < size; i++) {
        n += bytes[i] == byte ? 1 : 0;
    }
    return n;
}

static void judge_text(const judge_file *file, struct verdict *out)
{
    if (file->size > 0 && file->bytes[file->size - 1] != '\n') {
        broken(file, "its last line has no end", out);
    }
}

/* All lines have as many commas as the first. */
static void judge_csv(const judge_file *file, struct verdict *out)
{
    const uint8_t *first = memchr(file->bytes, '\n', file->size);
    if (first == NULL) {
        broken(file, "its first line has no end", out);
        return;
    }
    const size_t commas =
        count_of(file->bytes, (size_t)(first - file->bytes), ',');
    const size_t lines = count_of(file->bytes, file->size, '\n');
    judge_text(file, out);
    if (count_of(file->bytes, file->size, ',') != commas * lines) {
        broken(file, "its lines differ in their commas", out);
    }
}

/* The text behind a word of a header; NULL: it has none. */
static const char *find(const judge_file *file, const char *word,
                        size_t header_size)
{
    const size_t len = strlen(word);
    for (size_t i = 0; i + len <= header_size; i++) {
        if ((i == 0 || file->bytes[i - 1] == '\n') &&
            memcmp(file->bytes + i, word, len) == 0) {
            return (const char *)file->bytes + i + len;
        }
    }
    return NULL;
}

/* Bytes until behind a line; 0: it is not there. */
static size_t header_of(const judge_file *file, const char *line)
{
    const char *at = find(file, line, file->size);
    const char *end =
        at != NULL
            ? memchr(at, '\n',
                     file->size - (size_t)(at - (const char *)file->bytes))
            : NULL;
    return end != NULL ? (size_t)(end - (const char *)file->bytes) + 1 : 0;
}

/* --- Points --- */

static size_t ply_size(const char *type)
{
    static const struct {
        const char *name;
        size_t size;
    } types[] = {{"float ", 4},  {"double ", 8}, {"uchar ", 1},  {"char ", 1},
                 {"ushort ", 2}, {"short ", 2},  {"uint16 ", 2}, {"int16 ", 2},
                 {"uint ", 4},   {"int ", 4}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (strncmp(type, types[i].name, strlen(types[i].name)) == 0) {
            return types[i].size;
        }
    }
    return 0;
}

static void compare(const judge_file *file, size_t header, uint64_t points,
                    size_t stride, struct verdict *out)
{
    const uint64_t size =
        stride == 0 ? count_of(file->bytes + header, file->size - header, '\n')
                    : (file->size - header) / stride;
    if (size != points || (stride > 0 && (file->size - header) % stride != 0)) {
        char why[120];
        (void)snprintf(why, sizeof why,
                       "its header says %llu points, and %zu bytes follow it",
                       (unsigned long long)points, file->size - header);
        broken(file, why, out);
    }
}

static void judge_ply(const judge_file *file, struct verdict *out)
{
    static const char property[] = "\nproperty ";
    const size_t header = header_of(file, "end_header");
    const char *points = find(file, "element vertex ", header);
    size_t stride = 0;
    if (points == NULL) {
        broken(file, "it has no whole header", out);
        return;
    }
    for (size_t i = 0; i + sizeof property < header; i++) {
        if (memcmp(file->bytes + i, property, sizeof property - 1) == 0) {
            stride +=
                ply_size((const char *)file->bytes + i + sizeof property - 1);
        }
    }
    const bool is_text = find(file, "format ascii", header) != NULL;
    compare(file, header, strtoull(points, NULL, 10), is_text ? 0 : stride,
            out);
}

static void judge_pcd(const judge_file *file, struct verdict *out)
{
    const size_t header = header_of(file, "DATA ");
    const char *points = find(file, "POINTS ", header);
    const char *sizes = find(file, "SIZE ", header);
    size_t stride = 0;
    if (points == NULL || sizes == NULL) {
        broken(file, "it has no whole header", out);
        return;
    }
    while (*sizes != '\n') {
        char *end = NULL;
        stride += strtoul(sizes, &end, 10);
        sizes = end > sizes ? end : sizes + 1;
    }
    const bool is_text = find(file, "DATA ascii", header) != NULL;
    compare(file, header, strtoull(points, NULL, 10), is_text ? 0 : stride,
            out);
}

/* LAS 1.4: the offset of the points, the length of one and their number stand
 * at 96, 105 and 247. */
static void judge_las(const judge_file *file, struct verdict *out)
{
    if (file->size < 375 || memcmp(file->bytes, "LASF", 4) != 0) {
        broken(file, "it has no whole header", out);
        return;
    }
    const size_t header = packets_u32(file->bytes + 96);
    const uint64_t points = packets_u32(file->bytes + 247) |
                            (uint64_t)packets_u32(file->bytes + 251) << 32;
    if (header > file->size) {
        broken(file, "its points would begin behind its end", out);
        return;
    }
    compare(file, header, points, packets_u16(file->bytes + 105), out);
}

/* --- Others --- */

static void judge_png(const judge_file *file, struct verdict *out)
{
    static const uint8_t end[8] = {'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
    if (file->size < 20 ||
        memcmp(file->bytes + file->size - sizeof end, end, sizeof end) != 0) {
        broken(file, "it has no end", out);
    }
}

/* One object, or one for each line: brackets that fit. */
static void judge_json(const judge_file *file, struct verdict *out)
{
    int64_t depth = 0;
    bool in_text = false;
    for (size_t i = 0; i < file->size; i++) {
        const uint8_t c = file->bytes[i];
        if (in_text) {
            i += c == '\\' ? 1 : 0;
            in_text = c != '"';
            continue;
        }
        in_text = c == '"';
        depth += c == '{' || c == '[' ? 1 : 0;
        depth -= c == '}' || c == ']' ? 1 : 0;
    }
    judge_text(file, out);
    if (file->size == 0 || depth != 0 || in_text) {
        broken(file, "it breaks off", out);
    }
}

/* A recording has its name while it grows. */
static void judge_capture(const judge_file *file, struct verdict *out)
{
    struct packets p;
    const uint8_t *payload = NULL;
    size_t len = 0;
    packets_step step = PACKETS_ONE;
    if (!packets_open(&p, file->bytes, file->size)) {
        broken(file, "it has no header of a capture", out);
        return;
    }
    while (step == PACKETS_ONE) {
        step = packets_next(&p, &payload, &len);
    }
    if (step == PACKETS_BROKEN) {
        broken(file, "it has a record that is none", out);
    } else if (step == PACKETS_CUT && file->is_final) {
        broken(file, "it breaks off within a record", out);
    }
}

void judge_whole(const judge_file *file, struct verdict *out)
{
    static const struct {
        const char *ending;
        void (*judge)(const judge_file *file, struct verdict *out);
    } kinds[] = {{".csv", judge_csv},        {".xyz", judge_text},
                 {".yaml", judge_text},      {".ply", judge_ply},
                 {".pcd", judge_pcd},        {".las", judge_las},
                 {".png", judge_png},        {".pcap", judge_capture},
                 {".json", judge_json},      {".prom", judge_text},
                 {".pcapng", judge_capture}, {".mcap", judge_capture}};
    const size_t len = strlen(file->name);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        const size_t n = strlen(kinds[i].ending);
        if (len > n && strcmp(file->name + len - n, kinds[i].ending) == 0) {
            verdict_asked(out, whole);
            kinds[i].judge(file, out);
            return;
        }
    }
}
