/* What to say when packets with our magic came and none of them was data. */
#ifndef LUMDUMP_DIAGNOSIS_H
#define LUMDUMP_DIAGNOSIS_H

#include "lum/packet.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define DIAGNOSIS_SHAPES_MAX 12u
#define DIAGNOSIS_BYTES      96u

/* Packets of one type and kind. */
struct packet_shape {
    uint32_t type; /* bytes 8..11 */
    size_t shortest;
    size_t longest;
    uint64_t count;
    lum_packet_kind kind;
};

struct diagnosis {
    struct packet_shape shapes[DIAGNOSIS_SHAPES_MAX];
    size_t shape_count;
    uint64_t more; /* packets of further shapes */
    uint8_t sample[DIAGNOSIS_BYTES];
    bool sample_may_be_data;
    size_t sample_len; /* of the packet; at most DIAGNOSIS_BYTES are kept */
};

/* Note a packet with our magic that is not data. */
void diagnosis_note(struct diagnosis *diagnosis, const uint8_t *bytes,
                    size_t len, lum_packet_kind kind);

/* capture: what can be read to find the layout; NULL: the source is a sensor,
 * of which none was made. */
void diagnosis_print(const struct diagnosis *diagnosis, const char *source,
                     const char *capture, FILE *out);

#endif
