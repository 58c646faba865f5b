/* JSON, written as it comes. Keys are NULL inside arrays. Numbers do not depend
 * on the locale; text is escaped. */
#ifndef LUM_TOOLS_JSON_H
#define LUM_TOOLS_JSON_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct json {
    FILE *out;        /* NULL: nothing is written */
    bool has_before;  /* a comma is due */
    bool keeps_bytes; /* one that is no UTF-8 becomes the character of its
                         number, else U+FFFD */
    unsigned depth;   /* brackets that are open */
    unsigned lines;   /* members have lines of their own within so many */
};

void json_init(struct json *json, FILE *out);
void json_open_object(struct json *json, const char *key);
void json_close_object(struct json *json);
void json_open_array(struct json *json, const char *key);
void json_close_array(struct json *json);
void json_int(struct json *json, const char *key, int64_t value);
void json_uint(struct json *json, const char *key, uint64_t value);

/* value with this many decimals, 0..9; NaN and infinities become null. */
void json_real(struct json *json, const char *key, double value,
               unsigned decimals);
void json_bool(struct json *json, const char *key, bool value);
/* NULL becomes null. */
void json_text(struct json *json, const char *key, const char *text);
void json_null(struct json *json, const char *key);

/* An array with the names of the bits that are set in a laser's status. */
void json_laser_bits(struct json *json, const char *key, uint16_t bits);

/* A line that is one object: its begin, and its end. */
void json_begin_line(struct json *json, FILE *out);
void json_end_line(struct json *json);

#endif
