/* Receive buffers between a driver and the main loop: one of each, no lock.
 *
 * The driver claims a slot, has its DMA or its interrupt fill it, and commits
 * it. The main loop reads the oldest, and releases it when it is done: the
 * datagram is decoded in place. When all slots are full the driver gets none,
 * and the datagram is dropped and counted.
 *
 * If DMA fills slots on a core with a data cache (M7), the driver invalidates a
 * slot's bytes before it starts the DMA, and again before ring_commit(). The
 * bytes begin and end at cache lines, so nothing else is lost by that. */
#ifndef RING_H
#define RING_H

#include <stddef.h>
#include <stdint.h>

/* Of a data cache: 32 on an M7. Set it where the core's lines are longer, or
 * the DMA needs its buffers aligned to more; without a cache 8 saves memory. It
 * is at least what any word of the gateway is aligned to. */
#ifndef RING_LINE_BYTES
#define RING_LINE_BYTES 32u
#endif
#if RING_LINE_BYTES < 8 || (RING_LINE_BYTES & (RING_LINE_BYTES - 1)) != 0
#error "RING_LINE_BYTES has to be a power of two, 8 or more"
#endif

/* A payload of Ethernet: 1500 minus 28 of IP and UDP. A whole frame, of a MAC
 * without an IP stack, has 46 more with a VLAN tag: 1536. */
#ifndef RING_SLOT_BYTES
#define RING_SLOT_BYTES 1472u
#endif
#if RING_SLOT_BYTES < 1472 || RING_SLOT_BYTES % RING_LINE_BYTES != 0
#error "RING_SLOT_BYTES has to be a multiple of RING_LINE_BYTES, 1472 or more"
#endif

#ifndef RING_SLOTS
#define RING_SLOTS 8u
#endif
#if RING_SLOTS < 2 || (RING_SLOTS & (RING_SLOTS - 1)) != 0
#error "RING_SLOTS has to be a power of two, 2 or more"
#endif

/* Elsewhere: how the compiler aligns a struct to RING_LINE_BYTES. */
#ifndef RING_ALIGNED
#define RING_ALIGNED __attribute__((aligned(RING_LINE_BYTES)))
#endif

/* begin + len: RING_SLOT_BYTES at most. */
typedef struct RING_ALIGNED ring_slot {
    uint8_t bytes[RING_SLOT_BYTES];
    uint32_t begin; /* byte at which the datagram begins: 0 as claimed, 42 after
                       the headers of a frame, 46 with a VLAN tag */
    uint32_t len;   /* bytes of the datagram */
} ring_slot;

/* Aligned to RING_LINE_BYTES, so place it statically. Each index has one
 * writer: committed and dropped the driver, released the main loop. They count
 * without end, modulo 2^32. */
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
