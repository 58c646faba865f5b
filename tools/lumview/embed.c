/* Part of the build: files into a C source of assets.h.
 *   embed OUTPUT IMPORTMAP SHA256 PATH=FILE...
 * The file IMPORTMAP takes the place of the page's import map; SHA256 is that
 * file's, in hex. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HASH_BYTES 32u
#define LINE_BYTES 1024u

static const char map_begin[] = "<script type=\"importmap\">";
static const char map_end[] = "</script>";

struct file {
    char *bytes; /* a NUL behind them */
    size_t len;
};

static const char *const types[][2] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".txt", "text/plain; charset=utf-8"},
};

static void fail(const char *name, const char *why)
{
    (void)fprintf(stderr, "embed: %s: %s\n", name, why);
    exit(1);
}

static struct file read_file(const char *name)
{
    struct file out = {NULL, 0};
    FILE *in = fopen(name, "rb");
    if (in == NULL || fseek(in, 0, SEEK_END) != 0) {
        fail(name, "cannot be read");
    }
    const long len = ftell(in);
    out.bytes = len >= 0 ? malloc((size_t)len + 1u) : NULL;
    if (out.bytes == NULL || fseek(in, 0, SEEK_SET) != 0) {
        fail(name, "cannot be read");
    }
    out.len = fread(out.bytes, 1, (size_t)len, in);
    if (out.len != (size_t)len || fclose(in) != 0) {
        fail(name, "cannot be read");
    }
    out.bytes[out.len] = '\0';
    return out;
}

static const char *find_type(const char *path)
{
    const char *ending = strrchr(path, '.');
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (ending != NULL && strcmp(ending, types[i][0]) == 0) {
            return types[i][1];
        }
    }
    fail(path, "its ending tells no content type");
    return "";
}

static void write_bytes(FILE *out, const char *bytes, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)bytes[i];
        if (i % LINE_BYTES == 0) {
            (void)fputs(i == 0 ? "\"" : "\"\n\"", out);
        }
        /* a question mark might begin a trigraph */
        if (c < ' ' || c > '~' || strchr("\"\\?", c) != NULL) {
            (void)fprintf(out, "\\%03o", (unsigned)c);
        } else {
            (void)fputc(c, out);
        }
    }
    (void)fputs(len == 0 ? "\"\"" : "\"", out);
}

/* The length of what was written. */
static size_t write_file(FILE *out, const struct file *f,
                         const struct file *map)
{
    const char *found = strstr(f->bytes, map_begin);
    if (found == NULL) {
        write_bytes(out, f->bytes, f->len);
        return f->len;
    }
    found += sizeof map_begin - 1u;
    const char *behind = strstr(found, map_end);
    if (behind == NULL) {
        fail("the page", "its import map does not end");
        return 0;
    }
    const size_t before = (size_t)(found - f->bytes);
    const size_t after = f->len - (size_t)(behind - f->bytes);
    write_bytes(out, f->bytes, before);
    (void)fputc('\n', out);
    write_bytes(out, map->bytes, map->len);
    (void)fputc('\n', out);
    write_bytes(out, behind, after);
    return before + map->len + after;
}

static void write_asset(FILE *out, const char *path, const char *name,
                        const struct file *map)
{
    struct file f = read_file(name);
    (void)fprintf(out, "{\"%s\", \"%s\",\n", path, find_type(path));
    const size_t len = write_file(out, &f, map);
    (void)fprintf(out, ",\n%lu},\n", (unsigned long)len);
    free(f.bytes);
}

static void write_assets(FILE *out, int count, char **pairs,
                         const struct file *map)
{
    (void)fputs("const struct asset assets[] = {\n", out);
    for (int i = 0; i < count; i++) {
        char *name = strchr(pairs[i], '=');
        if (name == NULL) {
            fail(pairs[i], "is not PATH=FILE");
        } else {
            *name = '\0';
            write_asset(out, pairs[i], name + 1, map);
        }
    }
    (void)fprintf(out, "};\nconst size_t assets_count = %d;\n", count);
}

static void read_hash(const char *hex, unsigned char out[HASH_BYTES + 1u])
{
    if (strlen(hex) != 2u * HASH_BYTES) {
        fail(hex, "is no SHA-256 in hex");
    }
    for (size_t i = 0; i < HASH_BYTES; i++) {
        const char digits[3] = {hex[2u * i], hex[2u * i + 1u], '\0'};
        out[i] = (unsigned char)strtoul(digits, NULL, 16);
    }
    out[HASH_BYTES] = 0;
}

/* 32 bytes are 43 digits and a filler. */
static void write_hash(FILE *out, const char *hex)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                 "abcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char hash[HASH_BYTES + 1u];
    read_hash(hex, hash);
    (void)fputs("const char assets_import_map_hash[] = \"", out);
    for (size_t i = 0; i < 43u; i++) {
        const size_t bit = 6u * i;
        const unsigned two =
            (unsigned)hash[bit / 8u] << 8 |
            (bit / 8u + 1u <= HASH_BYTES ? hash[bit / 8u + 1u] : 0u);
        (void)fputc(digits[two >> (10u - bit % 8u) & 63u], out);
    }
    (void)fputs("=\";\n", out);
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        fail("usage", "embed OUTPUT IMPORTMAP SHA256 PATH=FILE...");
    }
    struct file map = read_file(argv[2]);
    FILE *out = fopen(argv[1], "w");
    if (out == NULL) {
        fail(argv[1], "cannot be written");
        return 1;
    }
    (void)fputs("#include \"assets.h\"\n", out);
    write_hash(out, argv[3]);
    write_assets(out, argc - 4, argv + 4, &map);
    free(map.bytes);
    if (ferror(out) || fclose(out) != 0) {
        (void)remove(argv[1]);
        fail(argv[1], "cannot be written");
    }
    return 0;
}
