/** @file
 * Compression of the chunks of an MCAP file, by threads if it is asked for.
 * Internal to cloud. */
#ifndef LUM_CLOUD_MCAP_PACK_H
#define LUM_CLOUD_MCAP_PACK_H

#include "base/crc32.h"
#include "buffer.h"

/** Most threads of a packer. */
#define LUM_MCAP_THREADS_MAX 4u

/** A chunk to be compressed. */
typedef struct lum_mcap_packing {
    const lum_bytes *chunk; /**< the caller's, who leaves it as it is */
    lum_bytes packed; /**< the same, compressed; failed: there was no memory */
    uint32_t crc;     /**< of the chunk */
    size_t place;     /**< private: in the packer's ring */
} lum_mcap_packing;

/** What compresses. */
typedef struct lum_mcap_packer lum_mcap_packer;

/** Its name in the file, or NULL: this build compresses nothing. */
extern const char *const lum_mcap_pack_name;

/** @param crc kept.
 * @return NULL: no memory, or a build without it. */
lum_mcap_packer *lum_mcap_packer_new(const lum_crc32 *crc);

/** Have this number of threads compress, which start when there is work for
 * them; before, and with 0, the caller's does. */
void lum_mcap_packer_set_threads(lum_mcap_packer *packer, unsigned threads);

/** Ends its threads. NULL is allowed. */
void lum_mcap_packer_free(lum_mcap_packer *packer);

/** Compress a chunk; at most LUM_MCAP_THREADS_MAX are under way. */
void lum_mcap_packer_give(lum_mcap_packer *packer, lum_mcap_packing *job);

/** Whether that is done, after waiting for it if `waits`. */
bool lum_mcap_packer_is_done(lum_mcap_packer *packer,
                             const lum_mcap_packing *job, bool waits);

#endif
