/* Bytes of a datagram, for whoever reads them to be seen if he reads too far or
 * too late. */
#ifndef LUM_TEST_EXACT_H
#define LUM_TEST_EXACT_H

#include <stddef.h>
#include <stdint.h>

#define EXACT_BYTES 1500u

/* A copy of up to EXACT_BYTES that ends where it ends. Never NULL; to be given
 * to exact_free() before another 256 are made. */
uint8_t *exact_copy(const uint8_t *bytes, size_t len);

/* NULL: nothing. */
void exact_free(uint8_t *copy);

#endif
