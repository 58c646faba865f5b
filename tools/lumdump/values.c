/* The value of each option, from text into a struct options, or why it is
 * refused. */
#define _POSIX_C_SOURCE 200809L
#include "values.h"

#include "rig.h"

#include "../common/host.h"
#include "../common/number.h"
#include "../common/option_table.h"
#include "../common/ring.h"
#include "cloud/presets.h"
#include "lum/picture/picture.h"
#include "lum/smooth.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- Which points --- */

static const struct option_word returns[] = {
    {"all", LUM_RETURNS_ALL},
    {"first", LUM_RETURNS_FIRST},
    {"last", LUM_RETURNS_LAST},
    {"strongest", LUM_RETURNS_STRONGEST},
    {NULL, 0}};

static bool look_up(const struct option_word *words, const char *text,
                    unsigned *out)
{
    for (; words->text != NULL; words++) {
        if (strcmp(words->text, text) == 0) {
            *out = words->number;
            return true;
        }
    }
    return false;
}

bool values_take_return(void *options, const char *text, lum_error *why)
{
    lum_selection *out = &((struct options *)options)->choice.points;
    (void)why;
    unsigned choice = 0;
    int64_t number = 0;
    if (look_up(returns, text, &choice)) {
        out->returns = (lum_return_choice)choice;
        return true;
    }
    if (number_parse_int(text, 1, UINT16_MAX, &number)) {
        out->returns = LUM_RETURNS_NUMBER;
        out->return_number = (uint16_t)number;
        return true;
    }
    return false;
}

/* A text of len bytes. False: it does not fit. */
static bool copy(const char *text, size_t len, char *out, size_t size)
{
    return len < size && snprintf(out, size, "%.*s", (int)len, text) >= 0;
}

/* Splits MIN:MAX in a copy; either may be empty. */
static bool split(const char *from, char *text, size_t size, char **min,
                  char **max)
{
    char *colon =
        copy(from, strlen(from), text, size) ? strchr(text, ':') : NULL;
    if (colon == NULL || strchr(colon + 1, ':') != NULL) {
        return false;
    }
    *colon = '\0';
    *min = text;
    *max = colon + 1;
    return true;
}

static bool parse_limits(const char *text, float *min, float *max)
{
    char room[128];
    char *low = NULL;
    char *high = NULL;
    double a = -INFINITY;
    double b = INFINITY;
    if (!split(text, room, sizeof room, &low, &high) ||
        (*low != '\0' && !number_parse_real(low, -1e6, 1e6, &a)) ||
        (*high != '\0' && !number_parse_real(high, -1e6, 1e6, &b)) || a > b) {
        return false;
    }
    *min = (float)a;
    *max = (float)b;
    return true;
}

bool values_take_range(void *options, const char *text, lum_error *why)
{
    lum_selection *out = &((struct options *)options)->choice.points;
    (void)why;
    out->has_range = parse_limits(text, &out->range_min, &out->range_max);
    return out->has_range;
}

bool values_take_box(void *options, const char *text, lum_error *why)
{
    lum_selection *out = &((struct options *)options)->choice.points;
    (void)why;
    const char *p = text;
    for (unsigned axis = 0; axis < 3; axis++) {
        const size_t len = strcspn(p, ",");
        char limits[64];
        const bool is_last = p[len] == '\0';
        if (!copy(p, len, limits, sizeof limits) || is_last != (axis == 2) ||
            !parse_limits(limits, &out->box_min[axis], &out->box_max[axis])) {
            return false;
        }
        p += len + 1;
    }
    out->has_box = true;
    return true;
}

bool values_take_frames(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    char room[64];
    char *first = NULL;
    char *last = NULL;
    int64_t whole = 0;
    (void)why;
    out->choice.frame_first = INT64_MIN;
    out->choice.frame_last = INT64_MAX;
    if (strncmp(text, "whole:", 6) == 0) {
        const bool is_fine = number_parse_int(text + 6, 1, UINT32_MAX, &whole);
        out->choice.whole = (uint32_t)whole;
        return is_fine;
    }
    out->choice.whole = 0;
    return split(text, room, sizeof room, &first, &last) &&
           (*first == '\0' || number_parse_int(first, INT64_MIN, INT64_MAX,
                                               &out->choice.frame_first)) &&
           (*last == '\0' || number_parse_int(last, INT64_MIN, INT64_MAX,
                                              &out->choice.frame_last)) &&
           out->choice.frame_first <= out->choice.frame_last;
}

bool values_take_sensor(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    out->sensor.text = text; /* of a rig it is a name */
    (void)why;
    return true;
}

bool values_take_duration(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    double seconds = 0;
    (void)why;
    if (!number_parse_real(text, 1e-6, 1e9, &seconds)) {
        return false;
    }
    out->choice.duration_ns = (int64_t)(seconds * 1e9);
    return true;
}

/* --- Sizes and times --- */

/* Units and what one of them is. */
struct unit {
    const char *name;
    double factor;
};

static const struct unit sizes[] = {
    {"B", 1},         {"kB", 1e3},         {"MB", 1e6},
    {"GB", 1e9},      {"TB", 1e12},        {"KiB", 1024},
    {"MiB", 1048576}, {"GiB", 1073741824}, {NULL, 0}};
static const struct unit times[] = {
    {"s", 1e9}, {"min", 60e9}, {"h", 3600e9}, {"d", 86400e9}, {NULL, 0}};

/* A number and its unit, without a space between. */
static bool parse_quantity(const char *text, const struct unit *units,
                           double min, double max, double *out)
{
    char number[32];
    const size_t len = strspn(text, "0123456789.");
    if (!copy(text, len, number, sizeof number)) {
        return false;
    }
    for (; units->name != NULL; units++) {
        if (strcmp(units->name, text + len) == 0) {
            double value = 0;
            const bool is_number = number_parse_real(number, 0, 1e12, &value);
            *out = value * units->factor;
            return is_number && *out >= min && *out <= max;
        }
    }
    return false;
}

static bool take_limit(const char *text, double max_ns, struct rotation *out)
{
    double value = 0;
    *out = (struct rotation){0};
    if (parse_quantity(text, sizes, 10e3, 1e15, &value)) {
        out->bytes = (uint64_t)value;
        return true;
    }
    if (parse_quantity(text, times, 1e9, max_ns, &value)) {
        out->ns = (int64_t)value;
        return true;
    }
    return false;
}

bool values_take_rotation(void *options, const char *text, lum_error *why)
{
    (void)why;
    return take_limit(text, 1e16, &((struct options *)options)->files.rotation);
}

bool values_take_keep(void *options, const char *text, lum_error *why)
{
    (void)why;
    return take_limit(text, 1e18, &((struct options *)options)->files.keep);
}

bool values_take_buffer(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    double value = 0;
    (void)why;
    if (!parse_quantity(text, sizes, RING_BYTES_MIN, 64e9, &value)) {
        return false;
    }
    out->live.buffer = (uint64_t)value;
    return true;
}

bool values_take_receive_buffer(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    double value = 0;
    (void)why;
    if (!parse_quantity(text, sizes, 65536, 1e9, &value)) {
        return false;
    }
    out->live.receive_buffer = (size_t)value;
    return true;
}

bool values_take_set(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    return set_keys_add(&o->config.set, text, why);
}

/* WINDOW or WINDOW:ORDER; 0 is off. */
bool values_take_smooth(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    char window_text[8];
    int64_t window = 0;
    int64_t order = 0;
    const size_t len = strcspn(text, ":");
    (void)why;
    if (!copy(text, len, window_text, sizeof window_text) ||
        !number_parse_int(window_text, 0, LUM_SMOOTH_WINDOW_MAX, &window)) {
        return false;
    }
    order = LUM_SMOOTH_ORDER(window);
    if (text[len] == ':' &&
        !number_parse_int(text + len + 1, 0, LUM_SMOOTH_ORDER_MAX, &order)) {
        return false;
    }
    lum_smooth smooth;
    out->points.smooth_window = (uint32_t)window;
    out->points.smooth_order = (uint32_t)order;
    return window == 0 || lum_smooth_init(&smooth, out->points.smooth_window,
                                          out->points.smooth_order) == LUM_OK;
}

bool values_take_columns(void *options, const char *text, lum_error *why)
{
    static const lum_writer_extra sensor = {RIG_COLUMN, LUM_NUMBER_U8};
    struct options *out = options;
    const char *p = text;
    out->cloud.columns = text;
    out->cloud.has_times = false;
    if (lum_writer_check_extra(LUM_FORMATS, text, &sensor, 1, why) != 0) {
        return false;
    }
    out->cloud.wants_sensor = lum_writer_check_columns(text, NULL) != 0;
    while (*p != '\0') {
        const size_t n = strcspn(p, ",");
        out->cloud.has_times =
            out->cloud.has_times || (n == 4 && strncmp(p, "time", 4) == 0);
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
    return true;
}

/* --- Pictures --- */

bool values_take_size(void *options, const char *text, lum_error *why)
{
    struct picture_options *out = &((struct options *)options)->cloud.picture;
    char width[16];
    int64_t sides[2];
    const size_t n = strcspn(text, "x");
    (void)why;
    if (text[n] != 'x' || !copy(text, n, width, sizeof width) ||
        !number_parse_int(width, LUM_PICTURE_SIDE_MIN, LUM_PICTURE_SIDE_MAX,
                          &sides[0]) ||
        !number_parse_int(text + n + 1, LUM_PICTURE_SIDE_MIN,
                          LUM_PICTURE_SIDE_MAX, &sides[1])) {
        return false;
    }
    out->width = (unsigned)sides[0];
    out->height = (unsigned)sides[1];
    return true;
}

/* --- Messages --- */

static unsigned content_of(const char *word, size_t n)
{
    static const struct {
        const char *word;
        unsigned content;
    } contents[] = {{"frames", LUM_MCAP_OF_FRAMES},
                    {"lines", LUM_MCAP_OF_LINES},
                    {"packets", LUM_MCAP_OF_DATAGRAMS}};
    for (size_t i = 0; i < sizeof contents / sizeof contents[0]; i++) {
        if (strlen(contents[i].word) == n &&
            strncmp(contents[i].word, word, n) == 0) {
            return contents[i].content;
        }
    }
    return 0;
}

bool values_take_mcap(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    const char *p = text;
    bool is_fine = true;
    (void)why;
    out->mcap.contents = 0;
    while (is_fine) {
        const size_t n = strcspn(p, ",");
        const unsigned content = content_of(p, n);
        is_fine = content != 0 && (out->mcap.contents & content) == 0;
        out->mcap.contents |= content;
        if (p[n] == '\0') {
            break;
        }
        p += n + 1u;
    }
    return is_fine &&
           (out->mcap.contents & (LUM_MCAP_OF_FRAMES | LUM_MCAP_OF_LINES)) !=
               (LUM_MCAP_OF_FRAMES | LUM_MCAP_OF_LINES);
}

bool values_take_frame_id(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    const size_t n = strlen(text);
    (void)why;
    out->mcap.frame_id = text;
    return n >= 1 && n <= LUM_MCAP_FRAME_ID_MAX;
}

bool values_take_preset(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    out->cloud.preset = text;
    return lum_preset_find(text, why) != NULL;
}

bool values_take_check_preset(void *options, const char *text, lum_error *why)
{
    struct options *out = options;
    out->instead.check_preset = text;
    return lum_preset_find(text, why) != NULL;
}
