/** @file
 * Hosts by their names. */
#ifndef LUM_NET_RESOLVE_H
#define LUM_NET_RESOLVE_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The IPv4 address of a host, by the system's resolver (hosts file, DNS, mDNS
 * where it is set up). Waits for the network where it has to, as long as the
 * resolver's own limits say; an address a.b.c.d is taken as it stands and waits
 * for nothing. Of several addresses the first is taken.
 * @param host    a.b.c.d, four numbers from 0 to 255 without leading zeros, or
 *                a name such as `localhost`; no port. Shorter or other numbers
 *                are no address and no name.
 * @param address host order; written on success.
 * @param error   gets the message: what is neither address nor name, an IPv6
 *                address, a name that is not known, or has no IPv4 address, or
 *                cannot be looked up now.
 * @return 0, or -1. Any thread. */
LUM_MUST_CHECK int lum_resolve(const char *host, uint32_t *address,
                               lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
