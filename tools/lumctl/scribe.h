/* Writes lines and a page to files in a thread of its own: whoever keeps a
 * laser on by heartbeats must not wait for a disk. */
#ifndef LUMCTL_SCRIBE_H
#define LUMCTL_SCRIBE_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct scribe;

/* Most bytes of a line, with its newline. */
#define SCRIBE_ROW_BYTES 1024u

/* Begins. rows: a file to which lines are added, after header where it is
 * empty; one that begins with something else is refused. Lines of several runs
 * may go into one, each stays whole. page: a file
 * that is replaced as a whole. Either may be NULL. NULL with the reason in
 * error. */
struct scribe *scribe_new(const char *rows, const char *header,
                          const char *page, lum_error *error);

/* Has a line added, which ends with a newline. Does not wait: one for which
 * there is no room is counted as lost. */
void scribe_add(struct scribe *scribe, const char *row);

/* Has the page replaced. Does not wait: of several that wait, the last counts.
 */
void scribe_turn(struct scribe *scribe, const char *page);

/* A failure, once for each that begins. False: there is none. */
bool scribe_tell(struct scribe *scribe, lum_error *out);

/* What was not written at the end. */
struct scribe_rest {
    uint64_t lost;    /* lines */
    bool page_failed; /* the last page */
    bool hangs;       /* the thread still waits for a disk, and may write yet */
};

/* Writes what waits, for 3 s at most, and ends. NULL is allowed. */
struct scribe_rest scribe_end(struct scribe *scribe);

#endif
