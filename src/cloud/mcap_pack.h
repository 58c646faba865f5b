/** @file
 * Compression of the chunks of an MCAP file. Internal to cloud. */
#ifndef LUM_CLOUD_MCAP_PACK_H
#define LUM_CLOUD_MCAP_PACK_H

#include "bytes.h"

/** What it needs for the next chunk. */
typedef struct lum_mcap_packer lum_mcap_packer;

/** Its name in the file, or NULL: this build compresses nothing. */
extern const char *const lum_mcap_pack_name;

/** NULL: no memory, or a build without it. */
lum_mcap_packer *lum_mcap_packer_new(void);

/** NULL is allowed. */
void lum_mcap_packer_free(lum_mcap_packer *packer);

/** Compress a chunk; out.failed says that there was no memory. */
void lum_mcap_pack(lum_mcap_packer *packer, const lum_bytes *chunk,
                   lum_bytes *out);

#endif
