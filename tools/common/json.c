#include "json.h"

#include <float.h>
#include <inttypes.h>
#include <string.h>

void json_init(struct json *json, FILE *out)
{
    *json = (struct json){.out = out};
}

/* Number of bytes of the UTF-8 sequence with this first byte, and the range of
 * its second byte, which excludes overlong forms, surrogates and values beyond
 * Unicode. */
static const struct {
    unsigned char first;
    unsigned char last;
    unsigned char bytes;
    unsigned char second_min;
    unsigned char second_max;
} sequences[] = {
    {0x00u, 0x7fu, 1, 0x00u, 0xffu}, {0xc2u, 0xdfu, 2, 0x80u, 0xbfu},
    {0xe0u, 0xe0u, 3, 0xa0u, 0xbfu}, {0xe1u, 0xecu, 3, 0x80u, 0xbfu},
    {0xedu, 0xedu, 3, 0x80u, 0x9fu}, {0xeeu, 0xefu, 3, 0x80u, 0xbfu},
    {0xf0u, 0xf0u, 4, 0x90u, 0xbfu}, {0xf1u, 0xf3u, 4, 0x80u, 0xbfu},
    {0xf4u, 0xf4u, 4, 0x80u, 0x8fu},
};

/* The sequence's length, or 0 where it breaks off. */
static size_t continue_utf8(const unsigned char *p, size_t n)
{
    for (size_t i = 2; i < n; i++) {
        if ((p[i] & 0xc0u) != 0x80u) {
            return 0;
        }
    }
    return n;
}

/* Length of the UTF-8 sequence that begins here, 0 where none does. */
static size_t utf8_length(const unsigned char *p)
{
    for (size_t i = 0; i < sizeof sequences / sizeof sequences[0]; i++) {
        if (p[0] >= sequences[i].first && p[0] <= sequences[i].last) {
            return p[1] >= sequences[i].second_min &&
                           p[1] <= sequences[i].second_max
                       ? continue_utf8(p, sequences[i].bytes)
                       : 0;
        }
    }
    return 0;
}

static void put_text(FILE *out, const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    (void)fputc('"', out);
    while (*p != '\0') {
        const size_t n = utf8_length(p);
        if (n == 0) {
            (void)fputs("\\ufffd", out);
        } else if (*p < 0x20u) {
            (void)fprintf(out, "\\u%04x", (unsigned)*p);
        } else {
            (void)fputs(*p == '"' || *p == '\\' ? "\\" : "", out);
            (void)fwrite(p, 1, n, out);
        }
        p += n == 0 ? 1 : n;
    }
    (void)fputc('"', out);
}

static void begin(struct json *json, const char *key)
{
    if (json->has_before) {
        (void)fputs(", ", json->out);
    }
    json->has_before = true;
    if (key != NULL) {
        put_text(json->out, key);
        (void)fputs(": ", json->out);
    }
}

static void open_bracket(struct json *json, const char *key, char bracket)
{
    begin(json, key);
    (void)fputc(bracket, json->out);
    json->has_before = false;
}

static void close_bracket(struct json *json, char bracket)
{
    (void)fputc(bracket, json->out);
    json->has_before = true;
}

void json_open_object(struct json *json, const char *key)
{
    open_bracket(json, key, '{');
}

void json_close_object(struct json *json)
{
    close_bracket(json, '}');
}

void json_open_array(struct json *json, const char *key)
{
    open_bracket(json, key, '[');
}

void json_close_array(struct json *json)
{
    close_bracket(json, ']');
}

void json_int(struct json *json, const char *key, int64_t value)
{
    begin(json, key);
    (void)fprintf(json->out, "%" PRId64, value);
}

void json_uint(struct json *json, const char *key, uint64_t value)
{
    begin(json, key);
    (void)fprintf(json->out, "%" PRIu64, value);
}

void json_real(struct json *json, const char *key, double value,
               unsigned decimals)
{
    char text[400];
    if (!(value >= -DBL_MAX && value <= DBL_MAX)) {
        json_null(json, key);
        return;
    }
    begin(json, key);
    (void)snprintf(text, sizeof text, "%.*f", (int)decimals, value);
    char *comma = strchr(text, ',');
    if (comma != NULL) {
        *comma = '.';
    }
    (void)fputs(text, json->out);
}

void json_bool(struct json *json, const char *key, bool value)
{
    begin(json, key);
    (void)fputs(value ? "true" : "false", json->out);
}

void json_text(struct json *json, const char *key, const char *text)
{
    begin(json, key);
    put_text(json->out, text);
}

void json_null(struct json *json, const char *key)
{
    begin(json, key);
    (void)fputs("null", json->out);
}

void json_end(struct json *json)
{
    (void)fputc('\n', json->out);
    json->has_before = false;
}
