#include "net/owner.h"

#include "base/system.h"
#include "net/endpoint.h"
#include "net/program.h"
#include "net/route.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MARKS 2u

struct lum_owner {
    intptr_t held[MARKS];
    size_t count;
};

typedef struct owner_names {
    char text[MARKS][LUM_OWNER_NAME_BYTES];
    size_t count;
} owner_names;

static void add_name(owner_names *out, lum_endpoint sensor,
                     const char *interface)
{
    (void)snprintf(out->text[out->count++], LUM_OWNER_NAME_BYTES, "%s%s%s",
                   lum_endpoint_show(sensor).text,
                   interface[0] != '\0' ? "%" : "", interface);
}

static owner_names names_of(lum_endpoint sensor, const char *interface)
{
    owner_names out = {.count = 0};
    char routed[64] = "";
    if (!lum_route_interface(sensor.address, routed, sizeof routed)) {
        routed[0] = '\0';
    }
    const char *on = interface != NULL ? interface : routed;
    if (strcmp(on, routed) == 0) {
        add_name(&out, sensor, "");
    }
    if (on[0] != '\0') {
        add_name(&out, sensor, on);
    }
    return out;
}

static void say_busy(lum_endpoint sensor, long process, lum_error *error)
{
    const bool own = process == lum_system_process();
    (void)lum_error_set(
        error,
        "%s has the session with %s and gets its data: it must end before "
        "another can begin",
        own ? "this program" : lum_program_show(process).text,
        lum_endpoint_show(sensor).text);
}

/* All of the names or none. */
static lum_net_result hold(lum_owner *owner, const owner_names *names,
                           long *process, lum_error *error)
{
    for (; owner->count < names->count; owner->count++) {
        const lum_net_result result =
            lum_owner_system_hold(names->text[owner->count],
                                  &owner->held[owner->count], process, error);
        if (result != LUM_NET_OK) {
            return result;
        }
    }
    return LUM_NET_OK;
}

lum_net_result lum_owner_take(lum_endpoint sensor, const char *interface,
                              lum_owner **out, lum_error *error)
{
    const owner_names names = names_of(sensor, interface);
    long process = 0;
    lum_owner *owner = calloc(1, sizeof *owner);
    if (owner == NULL) {
        (void)lum_error_set(error, "no memory left for a session");
        return LUM_NET_FAILED;
    }
    const lum_net_result result = hold(owner, &names, &process, error);
    if (result != LUM_NET_OK) {
        if (result == LUM_NET_BUSY) {
            say_busy(sensor, process, error);
        }
        lum_owner_release(owner);
        return result;
    }
    *out = owner;
    return LUM_NET_OK;
}

bool lum_owner_look(lum_endpoint sensor, const char *interface, lum_error *who)
{
    const owner_names names = names_of(sensor, interface);
    for (size_t i = 0; i < names.count; i++) {
        long process = 0;
        if (lum_owner_system_look(names.text[i], &process)) {
            say_busy(sensor, process, who);
            return true;
        }
    }
    return false;
}

void lum_owner_release(lum_owner *owner)
{
    if (owner == NULL) {
        return;
    }
    while (owner->count > 0) {
        lum_owner_system_drop(owner->held[--owner->count]);
    }
    free(owner);
}
