#define _POSIX_C_SOURCE 200809L
#include "source_url.h"

#include "host.h"
#include "number.h"

#include "lum/wire.h"

#include <string.h>
#include <unistd.h>

#define SENSOR "udp://"

static bool refuse(const char *text, const char *what, lum_error *why)
{
    (void)lum_error_set(
        why,
        "%s: %s; use udp://HOST or udp://HOST:PORT, such as udp://10.42.0.37",
        text, what);
    return false;
}

static bool is_sensors(uint32_t address)
{
    return address >> 24 != 0 && address >> 28 < 14;
}

bool source_url_is_sensor(const char *text)
{
    return strncmp(text, SENSOR, strlen(SENSOR)) == 0;
}

bool source_url_parse(const char *text, lum_endpoint *out, lum_error *why)
{
    lum_error reason = {""};
    const char *host = text + strlen(SENSOR);
    out->port = LUM_PORT;
    if (*host == '\0' || (*host == ':' && host[1] != ':')) {
        return refuse(text, "the host is missing", why);
    }
    if (strchr(host, '/') != NULL) {
        return refuse(text, "nothing may follow the host and its port", why);
    }
    if (!host_parse_endpoint(host, out, &reason)) {
        return refuse(text, reason.text, why);
    }
    return is_sensors(out->address) ||
           refuse(text, "no sensor can have this address", why);
}

bool source_url_is_none(const char *text, lum_error *why)
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
    (void)lum_error_set(why,
                        "%s: there is no such file; a sensor is named as "
                        "udp://%s",
                        text, host[0] != '\0' ? host : "10.42.0.37");
    return false;
}
