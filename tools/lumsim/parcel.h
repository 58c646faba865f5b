/* What data is due, and when. */
#ifndef LUMSIM_PARCEL_H
#define LUMSIM_PARCEL_H

#include <stddef.h>
#include <stdint.h>

/* A feed that is later than this skips lines. */
#define FEED_LAG_MAX_NS INT64_C(200000000)

/* One datagram. */
struct parcel {
    const uint8_t *bytes; /* live until the next call that gives some */
    size_t len;
};

#endif
