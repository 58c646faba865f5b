/* The route of a Linux host's kernel to an address. */
#ifndef LUMCTL_DOCTOR_WAY_H
#define LUMCTL_DOCTOR_WAY_H

#include <stdbool.h>
#include <stdint.h>

#define WAY_NAME_BYTES 16u

struct way {
    bool exists;
    int error; /* an errno, when it does not */
    bool is_local;
    bool is_default; /* the default route */
    char interface[WAY_NAME_BYTES];
    bool has_gateway;
    uint32_t gateway;
    uint32_t source; /* this host's address on it; 0: not known */
};

/* Asks the kernel. interface: only there; NULL: anywhere. False: it cannot be
 * asked. */
bool way_find(uint32_t address, const char *interface, struct way *out);

/* 0: not known. */
unsigned way_mtu(const char *interface);
#endif
