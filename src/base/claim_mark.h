/** @file
 * The content of a mark, the names of files beside a file, and the messages
 * when a right is refused (base/claim.h). Internal. */
#ifndef LUM_BASE_CLAIM_MARK_H
#define LUM_BASE_CLAIM_MARK_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>

#define LUM_CLAIM_STEM_BYTES                                                   \
    200u /* of a longer name its beginning and a hash */
#define LUM_CLAIM_MARK_BYTES 512u

/** A path's directory, with its separator, and what its last part is called in
 * names beside it. */
typedef struct lum_claim_place {
    size_t directory_len;
    char stem[LUM_CLAIM_STEM_BYTES + 1u];
} lum_claim_place;

/** What a mark says. */
typedef struct lum_claim_mark {
    char text[LUM_CLAIM_MARK_BYTES];
} lum_claim_mark;

lum_claim_place lum_claim_place_of(const char *path);

/** Directory, before, stem, after.
 * @return to be freed; NULL: there is no memory. */
char *lum_claim_compose(const char *path, const lum_claim_place *place,
                        const char *before, const char *after);

/** Whether a text is a mark's: a run that was killed early has left it empty.
 */
bool lum_claim_is_mark(const lum_claim_mark *mark);

/** The mark of this process.
 * @param unfinished the path of its unfinished file; NULL: none yet.
 * @return the text's length; 0: it has no room. */
size_t lum_claim_write_mark(lum_claim_mark *out, const char *unfinished);

/** The unfinished file that a mark names. A mark may say anything, so only a
 * name that such a file has counts.
 * @param mark is changed.
 * @return its path, to be freed; NULL: it names none. */
char *lum_claim_unfinished(lum_claim_mark *mark, const char *path);

/** Say that another writes the file; EBUSY in errno.
 * @param mark the other's; is changed.
 * @return -1. */
int lum_claim_refuse_busy(lum_claim_mark *mark, const char *shown,
                          lum_error *error);

/** Say that a file of another kind is where the mark would be; EEXIST in errno.
 * @return -1. */
int lum_claim_refuse_foreign(const char *path, const char *shown,
                             lum_error *error);

#endif
