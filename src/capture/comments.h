/** @file
 * The comments of a capture file: those of pcapng sections, and the documents
 * in the metadata of an MCAP file. Internal to the capture room. */
#ifndef LUM_CAPTURE_COMMENTS_H
#define LUM_CAPTURE_COMMENTS_H

#include "lum/capture/capture.h"

#include <stddef.h>
#include <stdint.h>

/** A comment; a NUL follows it. */
typedef struct lum_comment {
    char *text;
    size_t len;
} lum_comment;

/** Comments of one file. All bytes 0: there are none. */
typedef struct lum_comments {
    lum_comment list[LUM_CAPTURE_COMMENTS_MAX];
    size_t count;
    uint64_t left_out; /**< those without room */
} lum_comments;

/** Free their texts; then there are none. */
void lum_comments_clear(lum_comments *comments);

/** The file is read from its begin again: what it says again counts once. */
void lum_comments_rewind(lum_comments *comments);

/** Add a copy of one that is not there yet. Counted where there is no room. */
void lum_comments_add(lum_comments *comments, const void *text, size_t len);

/** Hand out the documents of a record of metadata, each as a text. Of others'
 * records, and of damaged ones, there are none.
 * @param content of the record.
 * @param take    gets each; live until it returns. */
void lum_mcap_comments_read(const uint8_t *content, size_t len,
                            void (*take)(void *context, const uint8_t *text,
                                         size_t len),
                            void *context);

#endif
