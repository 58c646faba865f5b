#include "json.h"

#include "lum/base/error.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "printable.h"

#include <float.h>
#include <inttypes.h>
#include <stdarg.h>
#include <string.h>

void json_init(struct json *json, FILE *out)
{
    *json = (struct json){.out = out};
}

LUM_PRINTF(2, 3)
static void put(struct json *json, const char *format, ...)
{
    va_list arguments;
    if (json->out != NULL) {
        va_start(arguments, format);
        (void)vfprintf(json->out, format, arguments);
        va_end(arguments);
    }
}

static void put_text(const struct json *json, const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    FILE *out = json->out;
    if (out == NULL) {
        return;
    }
    (void)fputc('"', out);
    while (*p != '\0') {
        const size_t n = utf8_length(p);
        if (n == 0) {
            (void)fprintf(out, "\\u%04x", json->keeps_bytes ? *p : 0xfffdu);
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

static void begin_line(struct json *json)
{
    put(json, "\n%*s", (int)(2u * json->depth), "");
}

static void begin(struct json *json, const char *key)
{
    const bool is_line = json->depth > 0 && json->depth <= json->lines;
    put(json, "%s", !json->has_before ? "" : is_line ? "," : ", ");
    if (is_line) {
        begin_line(json);
    }
    json->has_before = true;
    if (key != NULL) {
        put_text(json, key);
        put(json, ": ");
    }
}

static void open_bracket(struct json *json, const char *key, char bracket)
{
    begin(json, key);
    put(json, "%c", bracket);
    json->has_before = false;
    json->depth++;
}

static void close_bracket(struct json *json, char bracket)
{
    const bool is_line = json->depth <= json->lines && json->has_before;
    json->depth--;
    if (is_line) {
        begin_line(json);
    }
    put(json, "%c", bracket);
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
    put(json, "%" PRId64, value);
}

void json_uint(struct json *json, const char *key, uint64_t value)
{
    begin(json, key);
    put(json, "%" PRIu64, value);
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
    put(json, "%s", text);
}

void json_bool(struct json *json, const char *key, bool value)
{
    begin(json, key);
    put(json, "%s", value ? "true" : "false");
}

void json_text(struct json *json, const char *key, const char *text)
{
    if (text == NULL) {
        json_null(json, key);
        return;
    }
    begin(json, key);
    put_text(json, text);
}

void json_null(struct json *json, const char *key)
{
    begin(json, key);
    put(json, "null");
}

void json_laser_bits(struct json *json, const char *key, uint16_t bits)
{
    json_open_array(json, key);
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if ((bits >> bit & 1u) != 0) {
            json_text(json, NULL, lum_laser_bit_name(bit));
        }
    }
    json_close_array(json);
}

void json_begin_line(struct json *json, FILE *out)
{
    json_init(json, out);
    json_open_object(json, NULL);
}

void json_end_line(struct json *json)
{
    json_close_object(json);
    put(json, "\n");
    json->has_before = false;
}
