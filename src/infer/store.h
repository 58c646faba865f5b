/** @file
 * The packets that an inference looks at. Internal. */
#ifndef LUM_INFER_STORE_H
#define LUM_INFER_STORE_H

#include "infer/state.h"

/** Packets by sensor, and what else was seen. */
typedef struct lum_infer_store {
    lum_infer_packet *packets; /**< in the order of their arrival */
    uint32_t count;            /**< of them */
    uint32_t room;             /**< of them */
    uint8_t **blocks;          /**< where their bytes are */
    size_t block_count;        /**< of them */
    size_t used;               /**< bytes of the last block */
    uint32_t sensors[LUM_INFER_SENSORS_MAX]; /**< their addresses */
    uint32_t max;                            /**< packets that are wanted */
    lum_infer_counts counts; /**< what was pushed, but for packets and
                                  other_type */
} lum_infer_store;

/** Make room for the packets.
 * @return 0, or -1 without memory. */
int lum_infer_store_init(lum_infer_store *store, uint32_t max);

/** Free what it holds. */
void lum_infer_store_free(lum_infer_store *store);

/** Whether there is room for no more. */
bool lum_infer_store_is_full(const lum_infer_store *store);

/** Keep a datagram if it may be data.
 * @param sensor the address of the sensor's side.
 * @return 1: there is room for more; 0: there is none; -1: no memory. */
int lum_infer_store_add(lum_infer_store *store, const lum_record *record,
                        uint32_t sensor);

#endif
