/* What an input of fuzz_assembler.c and of fuzz_receiver.c is made of: a
 * configuration, then calls. */
#ifndef LUM_TESTS_FUZZ_CALLS_H
#define LUM_TESTS_FUZZ_CALLS_H

#include "lum/group.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define CONFIG_BYTES 7u   /* that an input begins with */
#define CALL_BYTES   9u   /* of each call */
#define CALLS_MAX    300u /* beyond which calls are not looked at */
#define SAMPLES_MAX  369u /* of a datagram of 1,500 bytes */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Writes what inputs have to meet and none of this process has; returns how
 * much that is. */
unsigned fuzz_missed(FILE *out);

/* A sample as it is on the wire; by hand, so that a fault of the core's encoder
 * is not ours. */
void call_word(uint32_t word, uint8_t *out);

/* Samples of which neighbours are alike, as in a line; some are not. b: the
 * call's bytes. */
void call_samples(const uint8_t *b, uint32_t n, uint8_t *samples);

/* A layout with a sensor clock of any width, and often of another unit. */
void call_layout(uint8_t b, uint8_t angle_order, lum_layout *out);

/* Replaces it by the built-in one but for its span of lines: a core with
 * layout_fixed.c reads no other. */
void call_built_in(lum_layout *layout);

/* By how much a call moves the clock, from its byte 2. */
uint32_t call_step(uint8_t b);

/* The packet of a call, but for its clock. is_large: it may fill a datagram;
 * samples: room for SAMPLES_MAX. */
void call_packet(const uint8_t *b, bool is_large, uint8_t *samples,
                 lum_group *g);

/* Makes of it a packet that no decoder gives. */
void call_spoil(lum_group *g, unsigned which);

#endif
