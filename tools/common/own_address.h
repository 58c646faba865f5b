/* Which of its addresses this host sends from. */
#ifndef LUM_TOOLS_OWN_ADDRESS_H
#define LUM_TOOLS_OWN_ADDRESS_H

#include <stdint.h>

/* The IPv4 address, in host order as `to`, by which that host knows this one; 0
 * if it cannot be found. Nothing is sent. interface: the one to send on; NULL:
 * by the routes. */
uint32_t own_address(uint32_t to, const char *interface);

#endif
