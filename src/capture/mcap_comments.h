/** @file
 * What an MCAP file of this project says of itself: the documents in its
 * metadata (docs/formats.md, "Provenance"). Internal to the capture room. */
#ifndef LUM_CAPTURE_MCAP_COMMENTS_H
#define LUM_CAPTURE_MCAP_COMMENTS_H

#include <stddef.h>
#include <stdint.h>

/** Hand out the documents of a record of metadata, each as a text. Of others'
 * records, and of damaged ones, there are none.
 * @param content of the record.
 * @param take    gets each; live until it returns. */
void lum_mcap_comments_read(const uint8_t *content, size_t len,
                            void (*take)(void *context, const uint8_t *text,
                                         size_t len),
                            void *context);

#endif
