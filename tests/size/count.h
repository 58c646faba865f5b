/* What measure.c and worst.c share: datagrams, and instructions counted by the
 * clock of an emulator that advances with each instruction. */
#ifndef LUM_TESTS_SIZE_COUNT_H
#define LUM_TESTS_SIZE_COUNT_H

#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DATAGRAM_BYTES 1472u /* what Ethernet holds */

struct datagram {
    uint8_t bytes[DATAGRAM_BYTES];
    size_t len;
};

/* Ticks of units, and how often the clock was read for them. */
struct count {
    uint32_t ticks;
    uint32_t readings;
    uint32_t units;
};

/* All but the samples; false: this layout cannot have them. */
bool datagram_begin(struct datagram *d, const lum_layout *layout,
                    const lum_group *group);

/* Where sample i of so many belongs. */
uint8_t *datagram_sample(struct datagram *d, uint32_t samples, uint32_t i);

/* After one reading of the clock more. */
void count_add(struct count *c, uint32_t ticks, uint32_t units);

/* A line of output that size.py reads; it divides. */
void count_print(const char *name, const struct count *c);

/* Prints "loop" and "nothing": how many instructions a tick is, and what
 * reading the clock costs. */
void count_print_scale(void);

#endif
