/* Receive buffers between a driver and the main loop: one of each, no lock.
 *
 * The driver claims a slot, has its DMA or its interrupt fill it, and commits
 * it. The main loop looks at the oldest, and releases it when it is done: the
 * datagram is decoded where it lies. When all slots are full the driver gets
 * none, and the datagram is dropped and counted.
 *
 * A core with a data cache (M7) cleans or invalidates the slot's bytes in its
 * driver, or keeps the ring in memory that is not cached. */
#ifndef RING_H
#define RING_H

#include <stddef.h>
#include <stdint.h>

#define RING_SLOT_BYTES 1472u /* of Ethernet's 1500, less IP and UDP */

#ifndef RING_SLOTS
#define RING_SLOTS 8u
#endif
#if RING_SLOTS < 2 || (RING_SLOTS & (RING_SLOTS - 1)) != 0
#error "RING_SLOTS has to be a power of two, 2 or more"
#endif

typedef struct ring_slot {
    int64_t time; /* of reception, in any unit */
    uint32_t len; /* bytes of the datagram */
    uint8_t bytes[RING_SLOT_BYTES];
} ring_slot;

/* Each index has one writer: committed and dropped the driver, released the
 * main loop. They count on and on, modulo 2^32. */
typedef struct ring {
    uint32_t committed;
    uint32_t dropped;
    uint32_t released;
    ring_slot slots[RING_SLOTS];
} ring;

/* Neither side may be at work. */
void ring_init(ring *r);

/* The driver's side, such as an interrupt: a slot to fill, or NULL when none is
 * free, which counts the datagram as dropped. */
ring_slot *ring_claim(ring *r);

/* The slot that was claimed is full. */
void ring_commit(ring *r);

/* The main loop's side: the oldest datagram, or NULL. */
const ring_slot *ring_front(const ring *r);

/* Done with it. */
void ring_release(ring *r);

/* Datagrams for which there was no slot. */
uint32_t ring_dropped(const ring *r);

#endif
