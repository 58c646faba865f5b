#define _POSIX_C_SOURCE 200809L
#include "values.h"

#include "../common/host.h"
#include "../common/number.h"
#include "../common/ring.h"
#include "lum/smooth.h"
#include "lum/wire.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const struct word returns[] = {{"all", LUM_RETURNS_ALL},
                                      {"first", LUM_RETURNS_FIRST},
                                      {"last", LUM_RETURNS_LAST},
                                      {"strongest", LUM_RETURNS_STRONGEST},
                                      {NULL, 0}};

static bool look_up(const struct word *words, const char *text, unsigned *out)
{
    for (; words->text != NULL; words++) {
        if (strcmp(words->text, text) == 0) {
            *out = words->value;
            return true;
        }
    }
    return false;
}

static bool complain(const char *option, const char *text, const char *allowed)
{
    (void)fprintf(stderr, "lumdump: %s: '%s' is not %s\n", option, text,
                  allowed);
    return false;
}

bool values_choose(const char *option, const struct word *words,
                   const char *text, unsigned *out)
{
    char allowed[128] = "one of";
    if (look_up(words, text, out)) {
        return true;
    }
    for (; words->text != NULL; words++) {
        const size_t len = strlen(allowed);
        (void)snprintf(allowed + len, sizeof allowed - len, " %s", words->text);
    }
    return complain(option, text, allowed);
}

bool values_parse_return(const char *text, lum_selection *out)
{
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
    return complain("--return", text,
                    "all, first, last, strongest or a number from 1");
}

/* Splits MIN:MAX in place; either may be empty. */
static bool split(char *text, char **min, char **max)
{
    char *colon = strchr(text, ':');
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
    char copy[128];
    char *low = NULL;
    char *high = NULL;
    double a = -INFINITY;
    double b = INFINITY;
    if (strlen(text) >= sizeof copy) {
        return false;
    }
    (void)memcpy(copy, text, strlen(text) + 1);
    if (!split(copy, &low, &high) ||
        (*low != '\0' && !number_parse_real(low, -1e6, 1e6, &a)) ||
        (*high != '\0' && !number_parse_real(high, -1e6, 1e6, &b)) || a > b) {
        return false;
    }
    *min = (float)a;
    *max = (float)b;
    return true;
}

bool values_parse_range(const char *text, lum_selection *out)
{
    out->has_range = parse_limits(text, &out->range_min, &out->range_max);
    return out->has_range ||
           complain("--range", text, "MIN:MAX in metres, such as 2:80");
}

static bool parse_box(const char *text, lum_selection *out)
{
    const char *p = text;
    for (unsigned axis = 0; axis < 3; axis++) {
        const size_t len = strcspn(p, ",");
        char limits[64];
        const bool is_last = p[len] == '\0';
        if (len >= sizeof limits || is_last != (axis == 2)) {
            return false;
        }
        (void)memcpy(limits, p, len);
        limits[len] = '\0';
        if (!parse_limits(limits, &out->box_min[axis], &out->box_max[axis])) {
            return false;
        }
        p += len + 1;
    }
    out->has_box = true;
    return true;
}

bool values_parse_box(const char *text, lum_selection *out)
{
    return parse_box(text, out) ||
           complain("--box", text,
                    "XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX in metres, such as "
                    "0:50,-10:10,:4");
}

static bool parse_frames(const char *text, struct options *out)
{
    char copy[64];
    char *first = NULL;
    char *last = NULL;
    if (strlen(text) >= sizeof copy) {
        return false;
    }
    (void)memcpy(copy, text, strlen(text) + 1);
    return split(copy, &first, &last) &&
           (*first == '\0' ||
            number_parse_int(first, INT64_MIN, INT64_MAX, &out->frame_first)) &&
           (*last == '\0' ||
            number_parse_int(last, INT64_MIN, INT64_MAX, &out->frame_last)) &&
           out->frame_first <= out->frame_last;
}

bool values_parse_frames(const char *text, struct options *out)
{
    return parse_frames(text, out) ||
           complain("--frames", text, "FIRST:LAST, such as 10:20 or 10:");
}

bool values_parse_sensor(const char *text, struct options *out)
{
    lum_error why = {""};
    out->has_sensor = host_parse(text, &out->sensor, &why);
    if (!out->has_sensor) {
        (void)fprintf(stderr, "lumdump: --sensor: %s\n", why.text);
    }
    return out->has_sensor;
}

bool values_parse_duration(const char *text, struct options *out)
{
    double seconds = 0;
    if (!number_parse_real(text, 1e-6, 1e9, &seconds)) {
        return complain("--duration", text, "a number of seconds above 0");
    }
    out->duration_ns = (int64_t)(seconds * 1e9);
    return true;
}

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
    {"s", 1e9}, {"min", 60e9}, {"h", 3600e9}, {NULL, 0}};

/* A number and its unit, without a space between. */
static bool parse_quantity(const char *text, const struct unit *units,
                           double min, double max, double *out)
{
    char number[32];
    const size_t len = strspn(text, "0123456789.");
    if (len >= sizeof number) {
        return false;
    }
    (void)memcpy(number, text, len);
    number[len] = '\0';
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

bool values_parse_rotation(const char *text, struct rotation *out)
{
    double value = 0;
    *out = (struct rotation){0};
    if (parse_quantity(text, sizes, 10e3, 1e15, &value)) {
        out->bytes = (uint64_t)value;
        return true;
    }
    if (parse_quantity(text, times, 1e9, 1e16, &value)) {
        out->ns = (int64_t)value;
        return true;
    }
    return complain("--rotate", text,
                    "a size of 10kB or more, such as 100MB or 1GB, or a time "
                    "of 1s or more, such as 60s or 10min");
}

bool values_parse_buffer(const char *text, uint64_t *out)
{
    double value = 0;
    if (!parse_quantity(text, sizes, RING_BYTES_MIN, 64e9, &value)) {
        return complain("--buffer", text,
                        "a size from 128KiB to 64GB, such as 256MB");
    }
    *out = (uint64_t)value;
    return true;
}

/* WINDOW or WINDOW:ORDER; 0 is off. */
static bool parse_smooth(const char *text, struct options *out)
{
    char window_text[8];
    int64_t window = 0;
    int64_t order = 0;
    const size_t len = strcspn(text, ":");
    if (len >= sizeof window_text) {
        return false;
    }
    (void)memcpy(window_text, text, len);
    window_text[len] = '\0';
    if (!number_parse_int(window_text, 0, LUM_SMOOTH_WINDOW_MAX, &window)) {
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

bool values_parse_smooth(const char *text, struct options *out)
{
    return parse_smooth(text, out) ||
           complain(
               "--smooth", text,
               "0 for off, an odd number of pixels up to 63, such as 31, or "
               "WINDOW:ORDER, the order from 0 to 5 and below the "
               "window, such as 31:2");
}

static bool refuse_url(const char *text, const char *what)
{
    (void)fprintf(stderr,
                  "lumdump: %s: %s; right is udp://HOST or "
                  "udp://HOST:PORT, such as udp://10.42.0.37\n",
                  text, what);
    return false;
}

static bool is_sensors(uint32_t address)
{
    return address >> 24 != 0 && address >> 28 < 14;
}

bool values_parse_url(const char *text, lum_endpoint *out)
{
    lum_error why = {""};
    const char *host = text + strlen("udp://");
    out->port = LUM_PORT;
    if (*host == '\0' || (*host == ':' && host[1] != ':')) {
        return refuse_url(text, "there is no host in it");
    }
    if (strchr(host, '/') != NULL) {
        return refuse_url(text, "nothing stands behind the host and its port");
    }
    if (!host_parse_endpoint(host, out, &why)) {
        return refuse_url(text, why.text);
    }
    return is_sensors(out->address) ||
           refuse_url(text, "no sensor can have this address");
}

bool values_is_no_url(const char *text)
{
    const bool is_udp = strncmp(text, "udp:", 4) == 0;
    const char *host = is_udp ? text + 4 + strspn(text + 4, "/") : text;
    const size_t len = strcspn(host, ":");
    char address[16] = "";
    uint32_t number = 0;
    if (len < sizeof address) {
        (void)memcpy(address, host, len);
        address[len] = '\0';
    }
    if ((!is_udp && !number_parse_address(address, &number)) ||
        access(text, F_OK) == 0) {
        return true;
    }
    (void)fprintf(stderr,
                  "lumdump: %s: there is no such file; a sensor is named as "
                  "udp://%s\n",
                  text, host[0] != '\0' ? host : "10.42.0.37");
    return false;
}
