/** @file
 * The right to write the file of a name, so that no two runs write one at the
 * same time. Internal.
 *
 * A mark, `.NAME.lumsdk`, lies beside the file as long as the right is held. It
 * is locked by flock(), on Windows by its share mode, so the mark of a killed
 * run differs from that of a running one. It also names the unfinished file of
 * its run, which the next run removes. On a file system without locks everybody
 * who asks gets the right. */
#ifndef LUM_BASE_CLAIM_H
#define LUM_BASE_CLAIM_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>

/** A right that is held, or none. */
typedef struct lum_claim {
    char *mark; /**< its path; NULL: none */
    int fd;     /**< of the mark; -1: none */
} lum_claim;

/** No right. */
#define LUM_CLAIM_NONE ((lum_claim){NULL, -1})

/** Take the right to write a file, which need not exist. In a directory that
 * this process may not write to, nothing is taken.
 * @param path  of the file; links are not followed.
 * @param shown its name for messages.
 * @param out   to be given back by lum_claim_drop(), whatever is returned.
 * @return 0, or -1 with the reason in error and in errno: EBUSY if another
 *         holds it, EEXIST if a file in the mark's place is not a mark, or why
 *         no mark can be made, for example ENOENT. */
LUM_MUST_CHECK int lum_claim_take(const char *path, const char *shown,
                                  lum_claim *out, lum_error *error);

/** Note in the mark which file is unfinished.
 * @param unfinished a path that lum_claim_beside() has given. */
void lum_claim_note(const lum_claim *claim, const char *unfinished);

/** Give it back; the mark is removed. */
void lum_claim_drop(lum_claim *claim);

/** A new name for an unfinished file beside the file of a name.
 * @return to be freed; NULL: there is no memory. */
char *lum_claim_beside(const char *path);

/** Whether another process has locked a file; a process that writes a file in
 * place locks it. */
bool lum_claim_is_locked(const char *path);

/** Lock a file that is open, as long as it is.
 * @return 0, also where there are no locks; -1 if another has locked it. */
LUM_MUST_CHECK int lum_claim_lock(int fd);

/* --- The content of a mark, names beside a file, refusals: claim_mark.c --- */

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
