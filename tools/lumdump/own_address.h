/* Which of its addresses this host sends from. */
#ifndef LUMDUMP_OWN_ADDRESS_H
#define LUMDUMP_OWN_ADDRESS_H

#include "lum/net/socket.h"

#include <stdint.h>

/* The IPv4 address, in host order, by which an endpoint knows this host; 0
 * where that is not to be found out. Nothing is sent.
 * interface: what is sent on; NULL: as the routes say. */
uint32_t own_address(lum_endpoint to, const char *interface);

#endif
