#include "net/endpoint.h"

#include <stdio.h>

static unsigned byte_of(uint32_t address, unsigned shift)
{
    return (unsigned)(address >> shift) & 0xffu;
}

lum_endpoint_text lum_endpoint_show(lum_endpoint endpoint)
{
    lum_endpoint_text out;
    (void)snprintf(out.text, sizeof out.text, "%u.%u.%u.%u:%u",
                   byte_of(endpoint.address, 24), byte_of(endpoint.address, 16),
                   byte_of(endpoint.address, 8), byte_of(endpoint.address, 0),
                   (unsigned)endpoint.port);
    return out;
}

lum_endpoint_text lum_endpoint_show_address(uint32_t address)
{
    lum_endpoint_text out;
    (void)snprintf(out.text, sizeof out.text, "%u.%u.%u.%u",
                   byte_of(address, 24), byte_of(address, 16),
                   byte_of(address, 8), byte_of(address, 0));
    return out;
}
