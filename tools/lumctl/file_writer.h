/* Writes lines and a page to files in a thread of its own: whoever keeps a
 * laser on by heartbeats must not wait for a disk. */
#ifndef LUMCTL_FILE_WRITER_H
#define LUMCTL_FILE_WRITER_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct file_writer;

/* Most bytes of a line, with its newline. */
#define FILE_WRITER_ROW_BYTES 1024u

/* Begins. rows: a file to which lines are added, after header where it is
 * empty; one that begins with something else is refused. Lines of several runs
 * may go into one, each stays whole. page: a file that is replaced as a whole.
 * Either may be NULL, header not. NULL with the reason in error. */
struct file_writer *file_writer_new(const char *rows, const char *header,
                                    const char *page, lum_error *error);

/* Has a line added, which ends with a newline. Does not wait: one for which
 * there is no room is counted as lost. */
void file_writer_add(struct file_writer *writer, const char *row);

/* Has the page replaced. Does not wait: of several that wait, the last counts.
 */
void file_writer_turn(struct file_writer *writer, const char *page);

/* A failure, once for each that begins. False: there is none. */
bool file_writer_tell(struct file_writer *writer, lum_error *out);

/* What was not written at the end. */
struct file_writer_rest {
    uint64_t lost;    /* lines */
    bool page_failed; /* the last page */
    bool has_news;    /* a failure that was not told */
    lum_error news;
    bool hangs; /* the thread still waits for a disk, and may write yet */
};

/* Writes what waits, for 3 s at most, and ends. NULL is allowed. */
struct file_writer_rest file_writer_end(struct file_writer *writer);

#endif
