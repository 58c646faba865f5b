/** @file
 * Bytes into an output that is open (base/outfile.h). Internal. */
#ifndef LUM_BASE_OUTFILE_IO_H
#define LUM_BASE_OUTFILE_IO_H

#include "base/outfile.h"

#include <stdio.h>

/** Wait until it takes bytes: its reader may be slow. Windows cannot ask this,
 * so there the next write waits.
 * @return 1: it does; 0: not yet; -1 with the reason in errno. */
int lum_outfile_wait(const lum_outfile *file, int patience_ms);

/** Have lum_outfile_put() to a pipe take as many bytes as there is room for, if
 * the system can do that. Before the first byte; not for an output that
 * lum_outfile_stream() is asked for. */
void lum_outfile_never_wait(lum_outfile *file);

/** Write some bytes at its end. After lum_outfile_wait() returned 1, only as
 * many as are taken at once, if the system says how many these are.
 * @param written number of bytes written, 0 to n; n is not 0.
 * @return 0, also if nothing could be written yet, or an errno. */
LUM_MUST_CHECK int lum_outfile_put(lum_outfile *file, const void *bytes,
                                   size_t n, size_t *written);

/** Write all bytes at its end, waiting for a slow reader.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_outfile_put_all(lum_outfile *file, const void *bytes,
                                       size_t n, lum_error *error);

/** Replace bytes that were written, all of them; the file is seekable.
 * @param offset from our first byte.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_outfile_put_at(lum_outfile *file, uint64_t offset,
                                      const void *bytes, size_t n);

/** Whether the reader has left. A pipe shows this without a write, except on
 * Windows, where the next write shows it. */
bool lum_outfile_is_unread(const lum_outfile *file);

/** A stream that appends, with its own descriptor; close it by fclose().
 * @return NULL with the reason in errno. */
FILE *lum_outfile_stream(const lum_outfile *file);

/** A second descriptor of a regular file, for lum_outfile_sync_copy().
 * @return -1: it is none, or there is no descriptor left. */
int lum_outfile_copy(const lum_outfile *file);

/** Wait until what was written so far is on the disk; the copy is closed. For
 * any thread. The system may say only once that the disk failed.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_outfile_sync_copy(int copy);

/** Discard the buffered bytes of a stream. */
void lum_outfile_turn_away(FILE *stream);

#endif
