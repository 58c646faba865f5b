#include "host.h"

#include "number.h"

#include "base/text.h"
#include "lum/net/resolve.h"

#include <stdlib.h>
#include <string.h>

#define HOST_BYTES 256u

bool host_parse(const char *text, uint32_t *out, lum_error *why)
{
    return lum_resolve(text, out, why) == 0;
}

bool host_parse_sensor(const char *text, uint32_t *out,
                       char interface[LUM_INTERFACE_BYTES], lum_error *why)
{
    char host[HOST_BYTES];
    const size_t len = strcspn(text, "%");
    const char *name = text + len + (text[len] == '%');
    if (len >= sizeof host || strlen(name) >= LUM_INTERFACE_BYTES ||
        (text[len] == '%' && *name == '\0')) {
        return false;
    }
    (void)memcpy(host, text, len);
    host[len] = '\0';
    (void)memcpy(interface, name, strlen(name) + 1);
    return host_parse(host, out, why);
}

bool host_is_name(const char *text)
{
    return strspn(text, "0123456789.:") != strlen(text);
}

bool host_parse_endpoint(const char *text, lum_endpoint *out, lum_error *why)
{
    char host[HOST_BYTES];
    int64_t port = out->port;
    const size_t len = strcspn(text, ":");
    const bool is_ipv6 = len != strlen(text) && strchr(text + len + 1, ':');
    lum_endpoint found = {0, 0};
    if (is_ipv6 || len >= sizeof host) {
        return host_parse(text, &found.address, why);
    }
    if (text[len] == ':' &&
        !number_parse_int(text + len + 1, 1, UINT16_MAX, &port)) {
        (void)lum_error_set(
            why, "'%.80s': the port is not a number from 1 to 65535", text);
        return false;
    }
    (void)memcpy(host, text, len);
    host[len] = '\0';
    if (!host_parse(host, &found.address, why)) {
        return false;
    }
    found.port = (uint16_t)port;
    *out = found;
    return true;
}

static void list_names(const struct host_interface *all, size_t count,
                       char *out, size_t room)
{
    out[0] = '\0';
    for (size_t i = 0; i < count; i++) {
        lum_text_add(out, room, "%s%s", i > 0 ? ", " : "", all[i].name);
    }
}

bool host_lists_interface(const struct host_interface *all, size_t count,
                          const char *name, lum_error *why)
{
    char names[160];
    if (interfaces_find(all, count, name) != NULL) {
        return true;
    }
    list_names(all, count, names, sizeof names);
    (void)lum_error_set(why, "there is no interface %.60s; this host has: %s",
                        name, count > 0 ? names : "none");
    return false;
}

bool host_has_interface(const char *name, lum_error *why)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    if (interfaces_list(&all, &count, why) != 0) {
        return true;
    }
    const bool is_there = host_lists_interface(all, count, name, why);
    free(all);
    return is_there;
}
