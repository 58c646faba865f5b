/* A bounded queue of datagrams between one thread that may not wait and one
 * that may: a datagram that does not fit is refused.
 *
 * The lock is held for a few assignments for each batch: the one copies bytes
 * and the other reads them in place without the lock. */
#ifndef LUM_TOOLS_RING_H
#define LUM_TOOLS_RING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Least size: room for the longest datagram. */
#define RING_BYTES_MIN 131072u

struct ring;

struct ring_item {
    const uint8_t *bytes;
    size_t len;
    int64_t time_ns;
    bool is_cut_short;
};

/* size: bytes, at least RING_BYTES_MIN. NULL without memory. */
struct ring *ring_new(size_t size);

/* Nobody may use it any more. NULL is allowed. */
void ring_free(struct ring *ring);

/* The giving side. */

/* Copy an item in; the other side sees it after ring_publish(). False: it does
 * not fit now. */
bool ring_put(struct ring *ring, const struct ring_item *item);

/* Make the items that were put visible to the other side. */
void ring_publish(struct ring *ring);

/* End the other side's wait, though there be nothing. */
void ring_wake(struct ring *ring);

/* No more will come. */
void ring_close(struct ring *ring);

/* The taking side. */

/* Give back the items taken before, wait until there is something or the wait
 * is ended, and take all items. False: nothing is left, and no more will
 * come. */
bool ring_take(struct ring *ring);

/* The next of the items taken; its bytes are valid until ring_take(). False:
 * none is left. */
bool ring_next(struct ring *ring, struct ring_item *out);

/* Any thread: bytes in use, and of how many. */
size_t ring_level(struct ring *ring);
size_t ring_size(const struct ring *ring);

#endif
