/* A datagram read by layout_any.c and by layout_fixed.c. */
#ifndef LUM_TESTS_LAYOUT_BOTH_H
#define LUM_TESTS_LAYOUT_BOTH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whether both give the same of a packet of the built-in layout: the result,
 * each member of the group, each word and angle, and the clock, whatever it was
 * before. */
bool layouts_agree(const uint8_t *data, size_t len);

#endif
