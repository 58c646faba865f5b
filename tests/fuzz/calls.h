/* What an input of fuzz_assembler.c and of fuzz_receiver.c is made of: a
 * configuration, then calls. */
#ifndef LUM_TESTS_FUZZ_CALLS_H
#define LUM_TESTS_FUZZ_CALLS_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define CONFIG_BYTES 7u   /* that an input begins with */
#define CALL_BYTES   9u   /* of each call */
#define CALLS_MAX    300u /* beyond which calls are not looked at */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Writes what inputs have to meet and none of this process has; returns how
 * much that is. */
unsigned fuzz_missed(FILE *out);

#endif
