/* An address for this host beside another device's. */
#ifndef LUMCTL_BESIDE_H
#define LUMCTL_BESIDE_H

#include <stdbool.h>
#include <stdint.h>

#define BESIDE_MASK 0xffffff00u /* of the subnet that both are in */
#define BESIDE_LAST 16u         /* 1 to this are looked at, of its end */

/* Whether somebody has an address. */
typedef bool (*beside_is_taken)(void *context, uint32_t address);

/* The lowest that neither the device nor anybody else has; 0: none of them. */
uint32_t beside_find(uint32_t device, beside_is_taken is_taken, void *context);

#endif
