/* What is lost of a stream of data, as lumdump counts it of the same packets.
 */
#ifndef LUMCTL_LOSSES_H
#define LUMCTL_LOSSES_H

#include "lum/base/error.h"
#include "lum/net/sensor.h"
#include "lum/profile.h"

#include <stdint.h>

struct losses;

/* Counts since losses_new(). What is under way counts only after losses_end().
 */
struct loss_counts {
    uint64_t packets;          /* of data */
    uint64_t lines;            /* that came */
    uint64_t lines_incomplete; /* of them: some of their angles are lost */
    uint64_t lines_missing;    /* not one packet of them came; this can become
                                  less again, as late lines come */
    uint64_t words_lost;       /* range words, at least */
    uint64_t refused;          /* datagrams that make no sense, or came late */
};

/* NULL with the reason in error. Takes 1 MB. */
struct losses *losses_new(const lum_layout *layout, lum_error *error);
void losses_free(struct losses *losses);

/* Takes a datagram of the sensor, of any kind. */
void losses_take(struct losses *losses, lum_endpoint sensor,
                 const lum_received *datagram);

/* The stream ends: what is under way counts too. */
void losses_end(struct losses *losses);

void losses_count(const struct losses *losses, struct loss_counts *out);

#endif
