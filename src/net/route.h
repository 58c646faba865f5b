/* Where datagrams for an address leave this host. */
#ifndef LUM_NET_ROUTE_H
#define LUM_NET_ROUTE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The name of the interface, if the routes name one without doubt. */
bool lum_route_interface(uint32_t address, char *out, size_t room);

/* The address that this host sends from, in host order; 0: not known. Nothing
 * is sent. */
uint32_t lum_route_source(uint32_t address);

#endif
