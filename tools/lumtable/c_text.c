#include "c_text.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void put(struct source *out, const char *format, ...)
{
    const size_t room = sizeof out->text - out->len;
    va_list arguments;
    va_start(arguments, format);
    const int n = vsnprintf(out->text + out->len, room, format, arguments);
    va_end(arguments);
    if (n < 0 || (size_t)n >= room) {
        out->is_cut = 1;
        return;
    }
    out->len += (size_t)n;
}

/* A text inside of a comment, which it must not end. */
static void put_plain(struct source *out, const char *text)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyz0123456789"
                                "ABCDEFGHIJKLMNOPQRSTUVWXYZ._-+= ";
    for (size_t i = 0; i < 100 && text[i] != '\0'; i++) {
        put(out, "%c", strchr(plain, text[i]) != NULL ? text[i] : '?');
    }
    put(out, "\n");
}

void put_origin(struct source *out, const char *what, const char *path)
{
    if (path == NULL) {
        put(out, " *   %s: built in\n", what);
        return;
    }
    const char *slash = strrchr(path, '/');
    put(out, " *   %s: ", what);
    put_plain(out, slash != NULL ? slash + 1 : path);
}

void put_settings(struct source *out, const struct set_keys *set)
{
    for (size_t i = 0; i < set->count; i++) {
        put(out, " *   set: ");
        put_plain(out, set->list[i].text);
    }
}

const char *field_name(unsigned field)
{
    static const char *const names[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = "TAG",
        [LUM_FIELD_EYE] = "EYE",
        [LUM_FIELD_LINE] = "LINE",
        [LUM_FIELD_NUM_SAMPLES] = "NUM_SAMPLES",
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = "FIRST_SAMPLE_INDEX",
        [LUM_FIELD_TIMESTAMP] = "TIMESTAMP",
    };
    return names[field];
}

const char *order_name(uint8_t byte_order)
{
    return byte_order == LUM_ORDER_LITTLE ? "LUM_ORDER_LITTLE"
                                          : "LUM_ORDER_BIG";
}

const char *angle_order_name(uint8_t angle_order)
{
    return angle_order == LUM_AZIMUTH_ELEVATION ? "LUM_AZIMUTH_ELEVATION"
                                                : "LUM_ELEVATION_AZIMUTH";
}
