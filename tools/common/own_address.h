/* Which of its addresses this host sends from. */
#ifndef LUM_TOOLS_OWN_ADDRESS_H
#define LUM_TOOLS_OWN_ADDRESS_H

#include "lum/net/socket.h"

#include <stdint.h>

/* The IPv4 address, in host order, by which an endpoint knows this host; 0 if
 * it cannot be found. Nothing is sent. interface: the one to send on; NULL: by
 * the routes. */
uint32_t own_address(lum_endpoint to, const char *interface);

#endif
