#include "net/owner.h"

#include "net/endpoint.h"
#include "net/owner_system.h"
#include "net/program.h"
#include "net/route.h"

#include <stdio.h>
#include <stdlib.h>

struct lum_owner {
    intptr_t held;
};

typedef struct owner_name {
    char text[LUM_OWNER_NAME_BYTES];
} owner_name;

/* Named with the interface also where only the routes tell it, so that both
 * ways to reach a sensor exclude each other. */
static owner_name name_of(lum_endpoint sensor, const char *interface)
{
    owner_name out;
    char routed[64] = "";
    if (interface == NULL &&
        !lum_route_interface(sensor.address, routed, sizeof routed)) {
        routed[0] = '\0';
    }
    const char *on = interface != NULL ? interface : routed;
    (void)snprintf(out.text, sizeof out.text, "%s%s%s",
                   lum_endpoint_show(sensor).text, on[0] != '\0' ? "%" : "",
                   on);
    return out;
}

static void say_busy(lum_endpoint sensor, long process, lum_error *error)
{
    const bool own = process == lum_owner_system_self();
    (void)lum_error_set(
        error,
        "%s already owns the session with %s and gets its data: end that "
        "first, or open a session that does not own the sensor",
        own ? "this program" : lum_program_show(process).text,
        lum_endpoint_show(sensor).text);
}

lum_net_result lum_owner_take(lum_endpoint sensor, const char *interface,
                              lum_owner **out, lum_error *error)
{
    const owner_name name = name_of(sensor, interface);
    long process = 0;
    lum_owner *owner = malloc(sizeof *owner);
    if (owner == NULL) {
        (void)lum_error_set(error, "no memory left for a session");
        return LUM_NET_FAILED;
    }
    const lum_net_result result =
        lum_owner_system_hold(name.text, &owner->held, &process, error);
    if (result != LUM_NET_OK) {
        if (result == LUM_NET_BUSY) {
            say_busy(sensor, process, error);
        }
        free(owner);
        return result;
    }
    *out = owner;
    return LUM_NET_OK;
}

void lum_owner_release(lum_owner *owner)
{
    if (owner != NULL) {
        lum_owner_system_drop(owner->held);
        free(owner);
    }
}
