/* What is written: a text in C. */
#ifndef LUMTABLE_C_TEXT_H
#define LUMTABLE_C_TEXT_H

#include "../common/set_keys.h"
#include "lum/base/error.h"
#include "lum/points_fixed.h"
#include "lum/profile.h"

#include <stddef.h>
#include <stdint.h>

#define SOURCE_BYTES 16384u

/* Cut where there is no room, and is_cut says so. Begins as all 0. */
struct source {
    char text[SOURCE_BYTES];
    size_t len;
    int is_cut;
};

/* Where the values come from, for the comment; NULL: built in. */
struct origin {
    const char *name; /* of the constants */
    const char *profile;
    const char *calibration;
    const struct set_keys *set; /* on top of these */
};

LUM_PRINTF(2, 3) void put(struct source *out, const char *format, ...);

/* Lines of the comment at the head. */
void put_origin(struct source *out, const char *what, const char *path);
void put_settings(struct source *out, const struct set_keys *set);

/* As the headers have them; a field without LUM_FIELD_ before it. */
const char *field_name(unsigned field);
const char *order_name(uint8_t byte_order);
const char *angle_order_name(uint8_t angle_order);

/* A layout and a projector as constants. */
void tables_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout,
                  const lum_fixed_projector *projector);

/* The code that reads the packets of one layout. */
void layout_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout);

#endif
