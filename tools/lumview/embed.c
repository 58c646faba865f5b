/* Part of the build: files into a C source of assets.h.
 *   embed OUTPUT PATH=FILE...
 * A FILE.gz is served as it is, and its PATH has a hash of what is in it.
 * An OUTPUT that ends in .html is a page that is there already: the files are
 * added to its end, in base64, as elements whose ids are PATH. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 1024u

struct file {
    char *bytes;
    size_t len;
};

static const char *const types[][2] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
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

static bool is_compressed(const char *name)
{
    const char *ending = strrchr(name, '.');
    return ending != NULL && strcmp(ending, ".gz") == 0;
}

static void write_asset(FILE *out, const char *path, const char *name)
{
    struct file f = read_file(name);
    (void)fprintf(out, "{\"%s\", \"%s\",\n", path, find_type(path));
    write_bytes(out, f.bytes, f.len);
    (void)fprintf(out, ",\n%lu, %s},\n", (unsigned long)f.len,
                  is_compressed(name) ? "true" : "false");
    free(f.bytes);
}

static void write_pairs(FILE *out, int count, char **pairs,
                        void (*write)(FILE *out, const char *path,
                                      const char *name))
{
    for (int i = 0; i < count; i++) {
        char *name = strchr(pairs[i], '=');
        if (name == NULL) {
            fail(pairs[i], "is not PATH=FILE");
        } else {
            *name = '\0';
            write(out, pairs[i], name + 1);
        }
    }
}

static void write_assets(FILE *out, int count, char **pairs)
{
    (void)fputs("#include \"assets.h\"\nconst struct asset assets[] = {\n",
                out);
    write_pairs(out, count, pairs, write_asset);
    (void)fprintf(out, "};\nconst size_t assets_count = %d;\n", count);
}

static void write_base64(FILE *out, const struct file *f)
{
    static const char digits[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < f->len; i += 3u) {
        const size_t n = f->len - i < 3u ? f->len - i : 3u;
        unsigned long bits = 0;
        for (size_t k = 0; k < 3u; k++) {
            bits = bits << 8 | (k < n ? (unsigned char)f->bytes[i + k] : 0u);
        }
        for (unsigned k = 0; k < 4u; k++) {
            (void)fputc(k <= n ? digits[bits >> (18u - 6u * k) & 63u] : '=',
                        out);
        }
    }
}

static void write_packed(FILE *out, const char *path, const char *name)
{
    struct file f = read_file(name);
    (void)fprintf(out, "<script type=\"text/plain\" id=\"%s\">", path);
    write_base64(out, &f);
    (void)fputs("</script>\n", out);
    free(f.bytes);
}

int main(int argc, char **argv)
{
    const char *ending = argc > 1 ? strrchr(argv[1], '.') : NULL;
    const bool is_page = ending != NULL && strcmp(ending, ".html") == 0;
    if (argc < 3) {
        fail("usage", "embed OUTPUT PATH=FILE...");
    }
    FILE *out = fopen(argv[1], is_page ? "a" : "w");
    if (out == NULL) {
        fail(argv[1], "cannot be written");
        return 1;
    }
    if (is_page) {
        write_pairs(out, argc - 2, argv + 2, write_packed);
    } else {
        write_assets(out, argc - 2, argv + 2);
    }
    if (ferror(out) || fclose(out) != 0) {
        (void)remove(argv[1]);
        fail(argv[1], "cannot be written");
    }
    return 0;
}
