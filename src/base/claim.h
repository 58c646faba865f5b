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

#endif
