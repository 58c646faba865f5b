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
 * where it is set up). It may wait for the network, up to the resolver's own
 * limits; an address a.b.c.d is taken as it is, without waiting. Of several
 * addresses the first is taken.
 * @param host    a.b.c.d, four numbers from 0 to 255 without leading zeros, or
 *                a name such as `localhost`; no port. Other forms of numbers
 *                are errors.
 * @param address host order; written on success.
 * @param error   gets the message on failure: not an address or a name, an IPv6
 *                address, a name that is unknown, has no IPv4 address or cannot
 *                be looked up now.
 * @return 0, or -1. Any thread. */
LUM_MUST_CHECK int lum_resolve(const char *host, uint32_t *address,
                               lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
