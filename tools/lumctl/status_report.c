#define _POSIX_C_SOURCE 200809L
#include "status_report.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/live/news.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define RED    "\033[1;31m"
#define NORMAL "\033[0m"

#define MIRROR                                                                 \
    "switch the sensor off and on; if the bit comes back, its mirror drive "   \
    "is broken"

struct report_bit report_bit(unsigned bit)
{
    switch ((enum lum_laser_bit)(1u << bit)) {
    case LUM_LASER_GALVO_AMP_BX_BAD:
        return (struct report_bit){"blue azimuth mirror: its drive is faulty",
                                   5, MIRROR};
    case LUM_LASER_GALVO_AMP_BY_BAD:
        return (struct report_bit){"blue elevation mirror: its drive is faulty",
                                   5, MIRROR};
    case LUM_LASER_GALVO_AMP_GX_BAD:
        return (struct report_bit){"green azimuth mirror: its drive is faulty",
                                   5, MIRROR};
    case LUM_LASER_GALVO_AMP_GY_BAD:
        return (struct report_bit){
            "green elevation mirror: its drive is faulty", 5, MIRROR};
    case LUM_LASER_HEARTBEAT_TIMEOUT:
        return (struct report_bit){
            "no heartbeat for 3 s", 0,
            "lumdump udp://... or lumctl heartbeat sends them"};
    case LUM_LASER_BOARD_OVER_105:
        return (struct report_bit){"a board is above 105 degrees", 3,
                                   "switch the sensor off and let it cool"};
    case LUM_LASER_FAN_PWM_BAD:
        return (struct report_bit){"the fan does not turn as it should", 4,
                                   "free the fan, switch the sensor off and "
                                   "on"};
    case LUM_LASER_HW_SAFETY_BAD:
        return (struct report_bit){"the hardware interlock is open", 2,
                                   "close the hardware interlock"};
    case LUM_LASER_SYS_ON_SW_OFF:
        return (struct report_bit){"the SYS_ON switch is off", 1,
                                   "turn the SYS_ON switch on"};
    case LUM_LASER_TLV_CMD_OFF:
        return (struct report_bit){"switched off by a command", 0, ""};
    case LUM_LASER_TLV_CMD_ON:
        return (struct report_bit){"switched on by a command", 0, ""};
    }
    return (struct report_bit){"", 0, ""};
}

bool report_lacks_heartbeats(uint16_t status)
{
    return (status & LUM_LASER_HAZARDS) == LUM_LASER_HEARTBEAT_TIMEOUT;
}

bool report_is_idle(uint16_t status, bool is_owned)
{
    return report_lacks_heartbeats(status) && !is_owned;
}

bool report_has_hazard(uint16_t status, bool is_owned)
{
    return lum_laser_has_hazard(status) && !report_is_idle(status, is_owned);
}

const char *report_cause(uint16_t status, bool was_up)
{
    if (lum_laser_has_hazard(status) && (status & LUM_LASER_TLV_CMD_ON) != 0) {
        return ": it COMES UP by itself when that ends, unless laser off is "
               "sent";
    }
    return was_up ? lum_laser_cause(status, false) : "";
}

const char *report_aside(uint16_t status, bool is_owned)
{
    if (!report_lacks_heartbeats(status)) {
        return "";
    }
    return is_owned ? ", its owner's heartbeats are missing" : ", idle";
}

static bool has_bit(uint16_t status, unsigned bit)
{
    return ((unsigned)status >> bit & 1u) != 0;
}

static bool is_hazard(unsigned bit)
{
    return (LUM_LASER_HAZARDS >> bit & 1u) != 0;
}

struct report_line report_line(uint16_t status, bool is_owned)
{
    struct report_line line;
    char bits[LUM_LASER_BITS_TEXT];
    (void)snprintf(
        line.text, sizeof line.text, "laser %s%s: %s",
        lum_laser_status_name(status), report_aside(status, is_owned),
        status == 0 ? "no bit set"
                    : lum_laser_bits_name(status, ", ", bits, sizeof bits));
    return line;
}

static const char *kind_of(uint16_t status, bool is_owned, unsigned bit)
{
    if (!is_hazard(bit)) {
        return "info";
    }
    return report_is_idle(status, is_owned) ? "idle" : "HAZARD";
}

void report_status(FILE *out, uint16_t status, bool is_owned, bool in_colour)
{
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if (!has_bit(status, bit)) {
            continue;
        }
        const struct report_bit r = report_bit(bit);
        const bool is_red =
            in_colour && is_hazard(bit) && !report_is_idle(status, is_owned);
        (void)fprintf(out, "  %s%-6s  %-17s%s%s%s%s%s\n", is_red ? RED : "",
                      kind_of(status, is_owned, bit), lum_laser_bit_name(bit),
                      is_red ? NORMAL : "", *r.meaning != '\0' ? "  " : "",
                      r.meaning, *r.fix != '\0' ? "; " : "", r.fix);
    }
}

void report_json(struct json *json, uint16_t status, bool is_owned)
{
    char hex[8];
    (void)snprintf(hex, sizeof hex, "0x%04x", (unsigned)status);
    json_uint(json, "status", status);
    json_text(json, "status_hex", hex);
    json_laser_bits(json, "bits", status);
    json_laser_bits(json, "hazards",
                    report_is_idle(status, is_owned)
                        ? 0
                        : (uint16_t)(status & LUM_LASER_HAZARDS));
    json_text(json, "laser", lum_laser_status_name(status));
    json_bool(json, "idle", report_is_idle(status, is_owned));
}

void report_json_trip(struct json *json, int64_t round_trip_ns)
{
    if (round_trip_ns > 0) {
        json_real(json, "round_trip_ms", (double)round_trip_ns / 1e6, 3);
    } else {
        json_null(json, "round_trip_ms");
    }
}

void report_debug(FILE *out, const char *text)
{
    while (*text != '\0') {
        const size_t len = strcspn(text, "\n");
        (void)fprintf(out, "  it says: %.*s\n", (int)len, text);
        text += len + (text[len] == '\n' ? 1u : 0u);
    }
}

void report_json_lines(struct json *json, const char *key, const char *text)
{
    json_open_array(json, key);
    while (*text != '\0') {
        char line[2048];
        const size_t len = strcspn(text, "\n");
        (void)snprintf(line, sizeof line, "%.*s", (int)len, text);
        json_text(json, NULL, line);
        text += len + (text[len] == '\n' ? 1u : 0u);
    }
    json_close_array(json);
}

struct report_utc report_utc(int64_t utc_ns)
{
    struct report_utc utc;
    const int64_t ms = utc_ns / 1000000;
    const time_t second = (time_t)(ms / 1000);
    struct tm when;
    memset(&when, 0, sizeof when);
    (void)gmtime_r(&second, &when);
    const size_t n =
        strftime(utc.text, sizeof utc.text, "%Y-%m-%dT%H:%M:%S", &when);
    (void)snprintf(utc.text + n, sizeof utc.text - n, ".%03dZ",
                   (int)(ms % 1000));
    return utc;
}

bool report_flush(void)
{
    if (fflush(stdout) == 0) {
        return true;
    }
    if (errno == EPIPE) {
        clearerr(stdout);
    }
    return false;
}

bool report_is_terminal(FILE *stream)
{
    return isatty(stream == stdin    ? STDIN_FILENO
                  : stream == stdout ? STDOUT_FILENO
                                     : STDERR_FILENO) != 0;
}

bool report_may_colour(FILE *stream)
{
    const char *no_colour = getenv("NO_COLOR");
    const char *terminal = getenv("TERM");
    return report_is_terminal(stream) &&
           (no_colour == NULL || *no_colour == '\0') &&
           (terminal == NULL || strcmp(terminal, "dumb") != 0);
}
