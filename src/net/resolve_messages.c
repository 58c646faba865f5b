#include "net/resolve_messages.h"

int lum_resolve_say_unknown(const char *name, lum_error *error)
{
    return lum_error_set(error,
                         "'%.80s': no host of this name is known; give its "
                         "address, such as 10.42.0.37",
                         name);
}

int lum_resolve_say_no_address(const char *name, lum_error *error)
{
    return lum_error_set(
        error, "'%.80s': this host has no IPv4 address; sensors use only IPv4",
        name);
}

int lum_resolve_say_failed(const char *name, const char *why, lum_error *error)
{
    return lum_error_set(error,
                         "'%.80s': the name cannot be looked up: %s; give its "
                         "address, such as 10.42.0.37",
                         name, why);
}
