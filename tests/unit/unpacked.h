/* The messages of a packed frame as arrays: what lum_packed_make() wrote, read
 * by its header alone. */
#ifndef LUM_TEST_UNPACKED_H
#define LUM_TEST_UNPACKED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct unpacked {
    size_t count;
    size_t pieces;
    double (*xyz)[3];
    double *step; /* of the coordinates */
    uint16_t *width;
    uint32_t *line;
    uint16_t *pixel;
    uint8_t *turn; /* return number, strongest */
    uint8_t *bits; /* eye, edge, returns */
    bool *has_come;
};

/* False: they are cut short, or say what cannot be. Either way, to be freed. */
bool unpack(const uint8_t *bytes, size_t len, struct unpacked *out);
void unpacked_free(struct unpacked *unpacked);

/* Of what a head says. */
uint32_t unpacked_u32(const uint8_t *bytes, size_t at);
double unpacked_double(const uint8_t *bytes, size_t at);

#endif
