#include "values.h"

#include "rig_run.h"

#include "../common/number.h"
#include "../common/option_table.h"
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

bool values_take_return(void *points, const char *text, lum_error *why)
{
    lum_selection *out = points;
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

bool values_take_range(void *points, const char *text, lum_error *why)
{
    lum_selection *out = points;
    (void)why;
    out->has_range = parse_limits(text, &out->range_min, &out->range_max);
    return out->has_range;
}

bool values_take_box(void *points, const char *text, lum_error *why)
{
    lum_selection *out = points;
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

bool values_take_frames(void *choice, const char *text, lum_error *why)
{
    struct choice_options *out = choice;
    char room[64];
    char *first = NULL;
    char *last = NULL;
    int64_t whole = 0;
    (void)why;
    out->frame_first = INT64_MIN;
    out->frame_last = INT64_MAX;
    if (strncmp(text, "whole:", 6) == 0) {
        const bool is_fine = number_parse_int(text + 6, 1, UINT32_MAX, &whole);
        out->whole = (uint32_t)whole;
        return is_fine;
    }
    out->whole = 0;
    return split(text, room, sizeof room, &first, &last) &&
           (*first == '\0' ||
            number_parse_int(first, INT64_MIN, INT64_MAX, &out->frame_first)) &&
           (*last == '\0' ||
            number_parse_int(last, INT64_MIN, INT64_MAX, &out->frame_last)) &&
           out->frame_first <= out->frame_last;
}

bool values_take_duration(void *duration_ns, const char *text, lum_error *why)
{
    double seconds = 0;
    const bool is_fine = number_parse_real(text, 1e-6, 1e9, &seconds);
    (void)why;
    *(int64_t *)duration_ns = (int64_t)(seconds * 1e9);
    return is_fine;
}

bool values_take_limit(void *rotation, const char *text, lum_error *why)
{
    struct rotation *out = rotation;
    double value = 0;
    (void)why;
    *out = (struct rotation){0};
    if (number_parse_size(text, 10e3, 1e15, &value)) {
        out->bytes = (uint64_t)value;
        return true;
    }
    const bool is_time = number_parse_time(text, 1e9, 1e18, &value);
    out->ns = is_time ? (int64_t)value : 0;
    return is_time;
}

/* WINDOW or WINDOW:ORDER; 0 is off. */
bool values_take_smooth(void *points, const char *text, lum_error *why)
{
    struct point_options *out = points;
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
    out->smooth_window = (uint32_t)window;
    out->smooth_order = (uint32_t)order;
    return window == 0 || lum_smooth_init(&smooth, out->smooth_window,
                                          out->smooth_order) == LUM_OK;
}

bool values_take_columns(void *cloud, const char *text, lum_error *why)
{
    static const lum_writer_extra sensor = {RIG_COLUMN, LUM_NUMBER_U8};
    struct cloud_options *out = cloud;
    const char *p = text;
    out->columns = text;
    out->has_times = false;
    if (lum_writer_check_extra(LUM_FORMATS, text, &sensor, 1, why) != 0) {
        return false;
    }
    out->wants_sensor = lum_writer_check_columns(text, NULL) != 0;
    while (*p != '\0') {
        const size_t n = strcspn(p, ",");
        out->has_times =
            out->has_times || (n == 4 && strncmp(p, "time", 4) == 0);
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
    return true;
}

/* --- Pictures --- */

bool values_take_size(void *picture, const char *text, lum_error *why)
{
    struct picture_options *out = picture;
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

bool values_take_mcap(void *contents, const char *text, lum_error *why)
{
    static const unsigned points = LUM_MCAP_OF_FRAMES | LUM_MCAP_OF_LINES;
    unsigned *out = contents;
    const char *p = text;
    (void)why;
    *out = 0;
    for (bool ends = false; !ends; p++) {
        const size_t n = strcspn(p, ",");
        const unsigned content = content_of(p, n);
        if (content == 0 || (*out & content) != 0) {
            return false;
        }
        *out |= content;
        p += n;
        ends = *p == '\0';
    }
    return (*out & points) != points;
}

bool values_take_frame_id(void *frame_id, const char *text, lum_error *why)
{
    const size_t n = strlen(text);
    (void)why;
    *(const char **)frame_id = text;
    return n >= 1 && n <= LUM_MCAP_FRAME_ID_MAX;
}

bool values_take_preset(void *preset, const char *text, lum_error *why)
{
    *(const char **)preset = text;
    return lum_preset_find(text, why) != NULL;
}
