#include "presets.h"

#include "base/text.h"
#include "decimal.h"
#include "le.h"
#include "text_columns.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- The table --- */

#define XYZ(x, y, z)                                                           \
    {x, LUM_NUMBER_F32, LUM_VALUE_X}, {y, LUM_NUMBER_F32, LUM_VALUE_Y},        \
    {                                                                          \
        z, LUM_NUMBER_F32, LUM_VALUE_Z                                         \
    }

const lum_preset lum_presets[LUM_PRESETS] = {
    {"autoware",
     true,
     10,
     {XYZ("x", "y", "z"),
      {"intensity", LUM_NUMBER_U8, LUM_VALUE_WIDTH_255},
      {"return_type", LUM_NUMBER_U8, LUM_VALUE_RETURN_TYPE},
      {"channel", LUM_NUMBER_U16, LUM_VALUE_RING},
      {"azimuth", LUM_NUMBER_F32, LUM_VALUE_AZIMUTH},
      {"elevation", LUM_NUMBER_F32, LUM_VALUE_ELEVATION},
      {"distance", LUM_NUMBER_F32, LUM_VALUE_DISTANCE},
      {"time_stamp", LUM_NUMBER_U32, LUM_VALUE_TIME_NS}}},
    {"lio-sam",
     false,
     6,
     {XYZ("x", "y", "z"),
      {"intensity", LUM_NUMBER_F32, LUM_VALUE_WIDTH_NS},
      {"ring", LUM_NUMBER_U16, LUM_VALUE_RING},
      {"time", LUM_NUMBER_F32, LUM_VALUE_TIME_S}}},
    {"fast-lio",
     false,
     6,
     {XYZ("x", "y", "z"),
      {"intensity", LUM_NUMBER_F32, LUM_VALUE_WIDTH_NS},
      {"time", LUM_NUMBER_F32, LUM_VALUE_TIME_S},
      {"ring", LUM_NUMBER_U16, LUM_VALUE_RING}}},
    {"kitti",
     true,
     4,
     {XYZ("x", "y", "z"), {"intensity", LUM_NUMBER_F32, LUM_VALUE_WIDTH_1}}},
    {"argoverse2",
     false,
     6,
     {XYZ("x", "y", "z"),
      {"intensity", LUM_NUMBER_U8, LUM_VALUE_WIDTH_255},
      {"laser_number", LUM_NUMBER_U8, LUM_VALUE_RING},
      {"offset_ns", LUM_NUMBER_I32, LUM_VALUE_TIME_NS}}},
    {"pdal",
     false,
     8,
     {XYZ("x", "y", "z"),
      {"Intensity", LUM_NUMBER_U16, LUM_VALUE_WIDTH_CNS},
      {"ReturnNumber", LUM_NUMBER_U8, LUM_VALUE_RETURN},
      {"NumberOfReturns", LUM_NUMBER_U8, LUM_VALUE_RETURNS},
      {"ScanChannel", LUM_NUMBER_U8, LUM_VALUE_EYE},
      {"GpsTime", LUM_NUMBER_F64, LUM_VALUE_TIMESTAMP_S}}},
};

const lum_preset lum_preset_of_messages = {
    "messages",
    false,
    8,
    {XYZ("x", "y", "z"),
     {"intensity", LUM_NUMBER_F32, LUM_VALUE_WIDTH_NS},
     {"time", LUM_NUMBER_F32, LUM_VALUE_TIME_S},
     {"ring", LUM_NUMBER_U16, LUM_VALUE_RING},
     {"return", LUM_NUMBER_U8, LUM_VALUE_RETURN},
     {"eye", LUM_NUMBER_U8, LUM_VALUE_EYE}}};

const lum_preset lum_preset_of_voxels = {
    "voxels",
    false,
    6,
    {XYZ("x", "y", "z"),
     {"intensity", LUM_NUMBER_F32, LUM_VALUE_WIDTH_NS},
     {"timestamp", LUM_NUMBER_F64, LUM_VALUE_VOXEL_US},
     {"points", LUM_NUMBER_U32, LUM_VALUE_POINTS}}};

const lum_preset *lum_preset_find(const char *name, lum_error *error)
{
    char all[128] = "";
    for (unsigned i = 0; i < LUM_PRESETS; i++) {
        if (strcmp(lum_presets[i].name, name) == 0) {
            return &lum_presets[i];
        }
        lum_text_list(all, sizeof all, ", ", lum_presets[i].name);
    }
    (void)lum_error_set(error, "'%.40s' is not a preset; presets are %s", name,
                        all);
    errno = EINVAL;
    return NULL;
}

size_t lum_preset_offset(const lum_preset *preset, unsigned field)
{
    size_t n = 0;
    for (unsigned i = 0; i < field; i++) {
        n += lum_number_types[preset->fields[i].type].bytes;
    }
    return n;
}

size_t lum_preset_bytes(const lum_preset *preset)
{
    return lum_preset_offset(preset, preset->count);
}

static bool is_time(const lum_preset_field *field)
{
    return field->value == LUM_VALUE_TIME_S ||
           field->value == LUM_VALUE_TIME_NS;
}

bool lum_preset_has_times(const lum_preset *preset)
{
    bool has = false;
    for (unsigned i = 0; i < preset->count; i++) {
        has = has || is_time(&preset->fields[i]);
    }
    return has;
}

/* --- Values --- */

#define WIDTH_MAX_NS 25.5

/* Of nebula::drivers::ReturnType. */
enum {
    RETURN_UNKNOWN = 0,
    RETURN_LAST = 1,
    RETURN_FIRST = 2,
    RETURN_IDENTICAL = 6, /* first and last in one */
    RETURN_SECOND = 7
};

static double return_type(const lum_sample *s)
{
    if (s->number_of_returns == 1) {
        return RETURN_IDENTICAL;
    }
    if (s->return_number == 1) {
        return RETURN_FIRST;
    }
    if (s->return_number != 0 && s->return_number == s->number_of_returns) {
        return RETURN_LAST;
    }
    return s->return_number == 2 ? RETURN_SECOND : RETURN_UNKNOWN;
}

static double share_of_width(const lum_sample *s)
{
    const double share = (double)s->pulse_width / WIDTH_MAX_NS;
    return share > 1.0 ? 1.0 : share; /* NaN stays */
}

static double of_line(lum_field_value value, const lum_line_samples *line)
{
    if (value == LUM_VALUE_RING) {
        return 2.0 * line->line + line->eye;
    }
    return value == LUM_VALUE_EYE
               ? line->eye
               : lum_timestamp_number(line->timestamp_us) * 1e-6;
}

static double of_sample(lum_field_value value, const lum_sample *s)
{
    static const uint8_t floats[] = {
        [LUM_VALUE_X] = offsetof(lum_sample, x),
        [LUM_VALUE_Y] = offsetof(lum_sample, y),
        [LUM_VALUE_Z] = offsetof(lum_sample, z),
        [LUM_VALUE_WIDTH_NS] = offsetof(lum_sample, pulse_width),
        [LUM_VALUE_WIDTH_CNS] = offsetof(lum_sample, pulse_width)};
    static const double scales[] = {1, 1, 1, 1, 100};
    float v;
    memcpy(&v, (const unsigned char *)s + floats[value], sizeof v);
    return (double)v * scales[value];
}

/* A consumer takes them for those of x, y and z. The sample's own are of its
 * eye, before its mount. */
static double polar(lum_field_value value, const lum_sample *s)
{
    const double x = (double)s->x;
    const double y = (double)s->y;
    const double z = (double)s->z;
    if (value == LUM_VALUE_AZIMUTH) {
        return atan2(y, x);
    }
    const double ground = sqrt(x * x + y * y);
    return value == LUM_VALUE_ELEVATION ? atan2(z, ground)
                                        : sqrt(ground * ground + z * z);
}

static double of_voxel(lum_field_value value, const lum_line_samples *line,
                       const lum_sample *s)
{
    const size_t i = (size_t)(s - line->samples);
    return value == LUM_VALUE_POINTS ? (double)line->counts[i]
                                     : (double)line->times_ns[i] * 1e-3;
}

static double value_of(lum_field_value value, const lum_line_samples *line,
                       const lum_sample *s, double time)
{
    if (value <= LUM_VALUE_WIDTH_CNS) {
        return of_sample(value, s);
    }
    if (value <= LUM_VALUE_ELEVATION) {
        return polar(value, s);
    }
    if (value <= LUM_VALUE_WIDTH_1) {
        return share_of_width(s) * (value == LUM_VALUE_WIDTH_1 ? 1.0 : 255.0);
    }
    if (value == LUM_VALUE_RETURN || value == LUM_VALUE_RETURNS) {
        return value == LUM_VALUE_RETURN ? s->return_number
                                         : s->number_of_returns;
    }
    if (value == LUM_VALUE_RETURN_TYPE) {
        return return_type(s);
    }
    if (value == LUM_VALUE_TIME_S || value == LUM_VALUE_TIME_NS) {
        return value == LUM_VALUE_TIME_S ? time : time * 1e9;
    }
    return value >= LUM_VALUE_VOXEL_US ? of_voxel(value, line, s)
                                       : of_line(value, line);
}

/* The nearest integer that the type has; 0 for NaN. */
static int64_t whole(double v, lum_number_type type)
{
    static const double highest[] = {[LUM_NUMBER_U8] = UINT8_MAX,
                                     [LUM_NUMBER_U16] = UINT16_MAX,
                                     [LUM_NUMBER_U32] = UINT32_MAX,
                                     [LUM_NUMBER_I32] = INT32_MAX};
    const double lowest = type == LUM_NUMBER_I32 ? (double)INT32_MIN : 0.0;
    if (!(v >= lowest)) {
        return v < lowest ? (int64_t)lowest : 0;
    }
    return v < highest[type] ? (int64_t)floor(v + 0.5) : (int64_t)highest[type];
}

static unsigned char *put_number(unsigned char *p, lum_number_type type,
                                 double v)
{
    if (type == LUM_NUMBER_F64) {
        return lum_put_f64(p, v);
    }
    if (type == LUM_NUMBER_F32) {
        return lum_put_f32(p, (float)v);
    }
    const uint32_t bits = (uint32_t)whole(v, type);
    if (type == LUM_NUMBER_U8) {
        return lum_put_u8(p, (uint8_t)bits);
    }
    return type == LUM_NUMBER_U16 ? lum_put_le16(p, (uint16_t)bits)
                                  : lum_put_le32(p, bits);
}

unsigned char *lum_preset_put_row(unsigned char *p, const lum_preset *preset,
                                  const lum_line_samples *line,
                                  const lum_sample *s, double time)
{
    for (unsigned i = 0; i < preset->count; i++) {
        const lum_preset_field *f = &preset->fields[i];
        p = put_number(p, (lum_number_type)f->type,
                       value_of((lum_field_value)f->value, line, s, time));
    }
    return p;
}

/* --- Rows of files --- */

#define CELL_ROOM 64u

static double time_of(const lum_line_samples *line, const lum_sample *s)
{
    return line->times != NULL ? (double)line->times[s - line->samples] : 0.0;
}

/* A nanosecond shows in a time and in a timestamp by the sensor's clock, and a
 * bit of a float in an angle in radians. */
static int print_cell(char *p, const lum_preset_field *f, double v)
{
    const bool is_float = f->type >= LUM_NUMBER_F32;
    const bool is_length =
        f->value <= LUM_VALUE_Z || f->value == LUM_VALUE_DISTANCE;
    if (!is_float) {
        return snprintf(p, CELL_ROOM, "%lld",
                        (long long)whole(v, (lum_number_type)f->type));
    }
    return snprintf(p, CELL_ROOM, "%.*f",
                    is_length                        ? (int)LUM_METRE_DECIMALS
                    : f->value == LUM_VALUE_WIDTH_NS ? (int)LUM_WIDTH_DECIMALS
                    : f->value == LUM_VALUE_VOXEL_US ? 3
                                                     : 9,
                    v);
}

char *lum_preset_put_text(char *p, void *context, const lum_sample *samples,
                          size_t n)
{
    const lum_preset_line *l = context;
    for (size_t i = 0; i < n; i++) {
        for (unsigned k = 0; k < l->preset->count; k++) {
            const lum_preset_field *f = &l->preset->fields[k];
            const double v =
                value_of((lum_field_value)f->value, l->line, &samples[i],
                         time_of(l->line, &samples[i]));
            p += print_cell(p, f, v);
            *p++ = l->separator;
        }
        p[-1] = '\n';
    }
    return p;
}

char *lum_preset_put_binary(char *p, void *context, const lum_sample *samples,
                            size_t n)
{
    const lum_preset_line *l = context;
    unsigned char *to = (unsigned char *)p;
    for (size_t i = 0; i < n; i++) {
        to = lum_preset_put_row(to, l->preset, l->line, &samples[i],
                                time_of(l->line, &samples[i]));
    }
    return (char *)to;
}

void lum_preset_put_time(unsigned char *row, const lum_preset *preset,
                         double time)
{
    for (unsigned i = 0; i < preset->count; i++) {
        const lum_preset_field *f = &preset->fields[i];
        if (is_time(f)) {
            (void)put_number(row, (lum_number_type)f->type,
                             f->value == LUM_VALUE_TIME_S ? time : time * 1e9);
        }
        row += lum_number_types[f->type].bytes;
    }
}
