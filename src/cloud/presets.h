/** @file
 * The fields of a point that programs which read clouds expect: one table for
 * all formats (docs/consumers.md). Internal to cloud; lumdump reads the table
 * to check clouds. */
#ifndef LUM_CLOUD_PRESETS_H
#define LUM_CLOUD_PRESETS_H

#include "numbers.h"

#include "lum/base/error.h"
#include "lum/cloud/writer.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** What a field holds of a point. */
typedef enum lum_field_value {
    LUM_VALUE_X,           /**< metres */
    LUM_VALUE_Y,           /**< metres */
    LUM_VALUE_Z,           /**< metres */
    LUM_VALUE_WIDTH_NS,    /**< pulse width */
    LUM_VALUE_WIDTH_CNS,   /**< pulse width in 0.01 ns, as LAS has it */
    LUM_VALUE_DISTANCE,    /**< metres, of x, y and z */
    LUM_VALUE_AZIMUTH,     /**< radians, of x and y */
    LUM_VALUE_ELEVATION,   /**< radians, of x, y and z */
    LUM_VALUE_WIDTH_255,   /**< pulse width, 255 is 25.5 ns and more */
    LUM_VALUE_WIDTH_1,     /**< pulse width, 1 is 25.5 ns and more */
    LUM_VALUE_RING,        /**< 2 x line, plus 1 of the green eye */
    LUM_VALUE_EYE,         /**< an ::lum_eye */
    LUM_VALUE_RETURN,      /**< number of the return */
    LUM_VALUE_RETURNS,     /**< how many the pixel has */
    LUM_VALUE_RETURN_TYPE, /**< by nebula's numbers */
    LUM_VALUE_TIME_S,      /**< from the beginning of the frame */
    LUM_VALUE_TIME_NS,     /**< likewise */
    LUM_VALUE_TIMESTAMP_S, /**< of the line */
    LUM_VALUE_VOXEL_US,    /**< timestamp of a voxel's point */
    LUM_VALUE_POINTS       /**< of a voxel */
} lum_field_value;

/** A field of a point. */
typedef struct lum_preset_field {
    const char *name; /**< as the consumer spells it */
    uint8_t type;     /**< a ::lum_number_type */
    uint8_t value;    /**< a ::lum_field_value */
} lum_preset_field;

/** Most fields of a preset. */
#define LUM_PRESET_FIELDS_MAX 10u

/** The fields that a consumer reads, one behind the other without gaps. */
typedef struct lum_preset {
    const char *name;  /**< as in options */
    bool is_in_places; /**< the consumer finds fields by their place; others
                            find them by name */
    uint8_t count;     /**< of fields */
    lum_preset_field fields[LUM_PRESET_FIELDS_MAX]; /**< in their order */
} lum_preset;

/** How many there are. */
#define LUM_PRESETS 6u

/** All of them. */
extern const lum_preset lum_presets[LUM_PRESETS];

/** What a message has without a preset, to compare clouds with: its fields
 * "ring" and "return" have other rules (ros_points.h). */
extern const lum_preset lum_preset_of_messages;

/** What voxels have (lum_writer_options.voxels). */
extern const lum_preset lum_preset_of_voxels;

/** Find one by name.
 * @return it, or NULL with the list of names in error; then errno is EINVAL. */
const lum_preset *lum_preset_find(const char *name, lum_error *error);

/** Bytes of a point. */
size_t lum_preset_bytes(const lum_preset *preset);

/** Bytes before a field. */
size_t lum_preset_offset(const lum_preset *preset, unsigned field);

/** Whether it has a time of each point. */
bool lum_preset_has_times(const lum_preset *preset);

/* --- Rows of files --- */

/** Rows of a line. */
typedef struct lum_preset_line {
    const lum_preset *preset;     /**< which */
    const lum_line_samples *line; /**< of it */
    char separator;               /**< between fields, in text */
} lum_preset_line;

/** Write rows of n samples as text; a lum_put_rows of writer_internal.h.
 * @param context a lum_preset_line; samples are of its line. */
char *lum_preset_put_text(char *p, void *context, const lum_sample *samples,
                          size_t n);

/** The same in binary, little-endian and without padding. */
char *lum_preset_put_binary(char *p, void *context, const lum_sample *samples,
                            size_t n);

/* --- Points of messages --- */

/** Write a sample, little-endian and without padding.
 * @param time in seconds from the beginning of the frame.
 * @return the end of it. */
unsigned char *lum_preset_put_row(unsigned char *p, const lum_preset *preset,
                                  const lum_line_samples *line,
                                  const lum_sample *s, double time);

/** Write its time again, where it has one. */
void lum_preset_put_time(unsigned char *row, const lum_preset *preset,
                         double time);

#endif
