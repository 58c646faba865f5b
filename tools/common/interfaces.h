/* Network interfaces of this host, with their IPv4 addresses. */
#ifndef LUM_TOOLS_INTERFACES_H
#define LUM_TOOLS_INTERFACES_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Longest name, its NUL included; on Windows "Ethernet 2" and longer. */
#define INTERFACE_NAME_BYTES 256u
#define INTERFACE_MAC_BYTES  6u
/* "9a:62:cd:08:a4:01" and its NUL. */
#define INTERFACE_MAC_TEXT_BYTES 18u

struct interface_address {
    uint32_t address; /* host order, as all here */
    uint32_t mask;
    unsigned prefix; /* bits of the mask, 0 to 32 */
};

struct host_interface {
    char name[INTERFACE_NAME_BYTES]; /* as --interface takes it */
    unsigned index;                  /* the system's number of it */
    bool is_up;
    bool has_link; /* a cable, and something at its other end */
    bool is_loopback;
    bool is_ethernet; /* and not wireless; false too where it is not known */
    bool has_mac;     /* false too where it is not known */
    uint8_t mac[INTERFACE_MAC_BYTES];
    const struct interface_address *addresses;
    size_t address_count; /* 0: it has none */
};

/* Lists every interface, those without an address too, in the system's order.
 * out   one block with all that it points to: free() it. NULL, with *count 0,
 *       where there are none.
 * Returns 0; -1 with error set, and nothing to free, when the system does not
 * tell them or memory is short. Any thread. */
int interfaces_list(struct host_interface **out, size_t *count,
                    lum_error *error);

/* The one of this name, or NULL. */
const struct host_interface *interfaces_find(const struct host_interface *all,
                                             size_t count, const char *name);

/* The one that has an address, or NULL. at: that address of it; may be NULL,
 * and is written on success. */
const struct host_interface *interfaces_owner(
    const struct host_interface *all, size_t count, uint32_t address,
    const struct interface_address **at);

/* The address of an interface whose subnet holds another, the narrowest subnet
 * first; NULL: none does. A subnet of all addresses (/0) holds none. */
const struct interface_address *interfaces_subnet(
    const struct host_interface *interface, uint32_t address);

/* Bits of a mask, from the top. */
unsigned interfaces_mask_bits(uint32_t mask);

/* Returns out. */
const char *interfaces_format_mac(const uint8_t mac[INTERFACE_MAC_BYTES],
                                  char out[INTERFACE_MAC_TEXT_BYTES]);

#endif
