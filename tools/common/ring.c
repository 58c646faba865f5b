#define _POSIX_C_SOURCE 200809L
#include "ring.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* The header before an item's bytes. */
struct header {
    int64_t time_ns;
    size_t len;
    bool is_cut_short;
    bool is_skip; /* no item: go on at the ring's begin */
};

#define ALIGNMENT sizeof(int64_t)

/* Positions count bytes from the beginning of time; modulo the size they are
 * places in the ring. An item never runs past its end. */
struct ring {
    uint8_t *bytes;
    size_t size; /* a multiple of ALIGNMENT */

    /* the giving side's */
    uint64_t put;   /* where the next item goes */
    uint64_t limit; /* as far as there is room */
    bool is_putting;

    /* the taking side's */
    uint64_t next;  /* the next item */
    uint64_t until; /* the end of what was taken */

    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    uint64_t head; /* the end of what was published */
    uint64_t tail; /* the end of what was given back */
    bool is_woken;
    bool is_closed;
};

struct ring *ring_new(size_t size)
{
    struct ring *ring = calloc(1, sizeof *ring);
    if (ring == NULL) {
        return NULL;
    }
    ring->size = size - size % ALIGNMENT;
    ring->bytes = malloc(ring->size);
    if (ring->bytes == NULL) {
        free(ring);
        return NULL;
    }
    (void)pthread_mutex_init(&ring->lock, NULL);
    (void)pthread_cond_init(&ring->changed, NULL);
    return ring;
}

void ring_free(struct ring *ring)
{
    if (ring == NULL) {
        return;
    }
    (void)pthread_cond_destroy(&ring->changed);
    (void)pthread_mutex_destroy(&ring->lock);
    free(ring->bytes);
    free(ring);
}

static size_t place(const struct ring *ring, uint64_t position)
{
    return (size_t)(position % ring->size);
}

/* An empty ring starts again at its first byte, so that while the taking side
 * keeps up, the same few bytes are reused and stay in the caches. */
static void begin_batch(struct ring *ring)
{
    (void)pthread_mutex_lock(&ring->lock);
    if (ring->tail == ring->head && place(ring, ring->head) != 0) {
        ring->head += ring->size - place(ring, ring->head);
        ring->tail = ring->head;
    }
    ring->put = ring->head;
    ring->limit = ring->tail + ring->size;
    (void)pthread_mutex_unlock(&ring->lock);
    ring->is_putting = true;
}

/* Leave out the rest up to the ring's end; a header fits there if a mark is
 * needed at all. */
static void skip_rest(struct ring *ring, size_t rest)
{
    const struct header mark = {.is_skip = true};
    if (rest >= sizeof mark) {
        memcpy(ring->bytes + place(ring, ring->put), &mark, sizeof mark);
    }
    ring->put += rest;
}

bool ring_put(struct ring *ring, const struct ring_item *item)
{
    const struct header header = {.time_ns = item->time_ns,
                                  .len = item->len,
                                  .is_cut_short = item->is_cut_short};
    if (!ring->is_putting) {
        begin_batch(ring);
    }
    const size_t used = sizeof header + item->len;
    const size_t room = used + (ALIGNMENT - used % ALIGNMENT) % ALIGNMENT;
    const size_t rest = ring->size - place(ring, ring->put);
    const size_t skipped = rest < room ? rest : 0;
    if (ring->limit - ring->put < skipped + room) {
        return false;
    }
    if (skipped > 0) {
        skip_rest(ring, skipped);
    }
    uint8_t *to = ring->bytes + place(ring, ring->put);
    memcpy(to, &header, sizeof header);
    if (item->len > 0) {
        memcpy(to + sizeof header, item->bytes, item->len);
    }
    ring->put += room;
    return true;
}

void ring_publish(struct ring *ring)
{
    if (!ring->is_putting) {
        return;
    }
    (void)pthread_mutex_lock(&ring->lock);
    ring->head = ring->put;
    (void)pthread_cond_signal(&ring->changed);
    (void)pthread_mutex_unlock(&ring->lock);
    ring->is_putting = false;
}

void ring_wake(struct ring *ring)
{
    (void)pthread_mutex_lock(&ring->lock);
    ring->is_woken = true;
    (void)pthread_cond_signal(&ring->changed);
    (void)pthread_mutex_unlock(&ring->lock);
}

void ring_close(struct ring *ring)
{
    (void)pthread_mutex_lock(&ring->lock);
    ring->is_closed = true;
    (void)pthread_cond_signal(&ring->changed);
    (void)pthread_mutex_unlock(&ring->lock);
}

bool ring_take(struct ring *ring)
{
    (void)pthread_mutex_lock(&ring->lock);
    if (ring->until > ring->tail) {
        ring->tail = ring->until;
    }
    while (ring->head == ring->tail && !ring->is_woken && !ring->is_closed) {
        (void)pthread_cond_wait(&ring->changed, &ring->lock);
    }
    ring->is_woken = false;
    ring->next = ring->tail;
    ring->until = ring->head;
    const bool goes_on = ring->head != ring->tail || !ring->is_closed;
    (void)pthread_mutex_unlock(&ring->lock);
    return goes_on;
}

/* A rest too short for a mark is left out without one. */
static uint64_t skip_position(const struct ring *ring, uint64_t position)
{
    return position + ring->size - place(ring, position);
}

bool ring_next(struct ring *ring, struct ring_item *out)
{
    struct header header = {.is_skip = true};
    while (ring->next < ring->until && header.is_skip) {
        const size_t at = place(ring, ring->next);
        if (ring->size - at >= sizeof header) {
            memcpy(&header, ring->bytes + at, sizeof header);
        }
        if (header.is_skip) {
            ring->next = skip_position(ring, ring->next);
        }
    }
    if (header.is_skip) {
        return false;
    }
    const size_t used = sizeof header + header.len;
    *out = (struct ring_item){.bytes = ring->bytes + place(ring, ring->next) +
                                       sizeof header,
                              .len = header.len,
                              .time_ns = header.time_ns,
                              .is_cut_short = header.is_cut_short};
    ring->next += used + (ALIGNMENT - used % ALIGNMENT) % ALIGNMENT;
    return true;
}

size_t ring_level(struct ring *ring)
{
    (void)pthread_mutex_lock(&ring->lock);
    const size_t level = (size_t)(ring->head - ring->tail);
    (void)pthread_mutex_unlock(&ring->lock);
    return level;
}

size_t ring_size(const struct ring *ring)
{
    return ring->size;
}
