/* Interfaces of this Linux host, and the way that its kernel takes to an
 * address. */
#ifndef LUMCTL_DOCTOR_WAY_H
#define LUMCTL_DOCTOR_WAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WAY_NAME_BYTES     16u
#define WAY_INTERFACES_MAX 64u

/* An address of an interface; those without one stand once, with has_address
 * false. */
struct way_interface {
    char name[WAY_NAME_BYTES];
    bool is_up;
    bool has_link; /* a cable, and something at its other end */
    bool is_loopback;
    bool is_ethernet; /* and not wireless */
    bool has_address;
    uint32_t address; /* host order */
    uint32_t mask;
};

/* Returns how many; 0 also when the kernel does not tell. */
size_t way_interfaces(struct way_interface *out, size_t room);

struct way {
    bool exists;
    int error; /* an errno, when it does not */
    bool is_local;
    bool is_default; /* the way of everything that has none of its own */
    char interface[WAY_NAME_BYTES];
    bool has_gateway;
    uint32_t gateway;
    uint32_t source; /* this host's address on it; 0: not told */
};

/* Asks the kernel. interface: there alone; NULL: anywhere. False: it cannot be
 * asked. */
bool way_find(uint32_t address, const char *interface, struct way *out);

/* 0: not known. */
unsigned way_mtu(const char *interface);

/* Bits of a mask, from the top. */
unsigned way_mask_bits(uint32_t mask);

#endif
