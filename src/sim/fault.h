/** @file
 * What a bad network does to datagrams, seeded: loss, repeats, reordering,
 * corruption.
 *
 * Each kind has its own random numbers, so changing one probability does not
 * change the effect of the others on a packet. Put a packet in, take packets
 * out until there are none:
 *
 * @code
 * lum_fault_push(&fault, packet);
 * while ((out = lum_fault_pull(&fault)) != NULL) {
 *     send(out);
 * }
 * @endcode */
#ifndef LUM_SIM_FAULT_H
#define LUM_SIM_FAULT_H

#include "packets.h"
#include "random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A reordered packet leaves after 1 to this many later ones. */
#define LUM_FAULT_REACH 4u

/** Kinds of faults. */
enum lum_fault_kind {
    LUM_FAULT_LOSS,      /**< the packet never comes */
    LUM_FAULT_DUPLICATE, /**< it comes twice; each copy has its own fate */
    LUM_FAULT_REORDER,   /**< it comes later than packets behind it */
    LUM_FAULT_CORRUPT,   /**< 1 to 3 bits of it are flipped */
    LUM_FAULT_KINDS      /**< how many there are */
};

/** A packet that waits. Private. */
typedef struct lum_fault_held {
    lum_sim_packet packet; /**< private */
    unsigned behind;       /**< private: pushes it still waits for */
    bool on_time;          /**< private: leaves before those that waited */
} lum_fault_held;

/** Most packets that wait at a time. */
#define LUM_FAULT_HELD_MAX (2u * (LUM_FAULT_REACH + 2u))

/** State of the faults. Private except size and counts. */
typedef struct lum_fault {
    double probability[LUM_FAULT_KINDS];     /**< private */
    lum_random random[LUM_FAULT_KINDS];      /**< private */
    lum_fault_held held[LUM_FAULT_HELD_MAX]; /**< private: in order of push */
    size_t held_count;                       /**< private */
    lum_sim_packet out;                      /**< private */
    int64_t last_ns;                         /**< private: of what left */
    uint64_t count[LUM_FAULT_KINDS];         /**< faults done so far */
} lum_fault;

/** Begin.
 * @param probability 0..1, by ::lum_fault_kind: the probability of a fault for
 *                    a packet. */
void lum_fault_init(lum_fault *out, const double probability[LUM_FAULT_KINDS],
                    uint64_t seed);

/** Put a packet in. All that lum_fault_pull() gives must have been taken. */
void lum_fault_push(lum_fault *fault, const lum_sim_packet *packet);

/** The end of the stream: nothing waits any longer. */
void lum_fault_flush(lum_fault *fault);

/** The next packet that leaves. Times never go back.
 * @return lives until the next call; NULL when a push is needed. */
const lum_sim_packet *lum_fault_pull(lum_fault *fault);

#endif
