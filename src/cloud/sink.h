/** @file
 * Where a file's bytes go: large blocks that a thread writes while the caller
 * fills the next one.
 *
 * A regular file gets its name when it is whole (base/outfile.h); what is no
 * regular file (standard output, a pipe, a device) is written in place.
 * An error of the thread comes out of the next call and of lum_sink_close().
 * The thread blocks all signals, so that SIGPIPE never kills the process. One
 * sink serves one caller; nothing is shared between sinks. */
#ifndef LUM_CLOUD_SINK_H
#define LUM_CLOUD_SINK_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Size of a block, and the most that can be reserved at once. A block of a
 * sink in memory grows. */
#define LUM_SINK_BLOCK_BYTES ((size_t)1 << 20)

/** An output being written. */
typedef struct lum_sink lum_sink;

/** Begin an output.
 * @param path its name, or "-" for standard output, which stays open.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_sink_open(const char *path, lum_sink **out,
                                 lum_error *error);

/** The same; a regular file gets its name when its first block is written, and
 * stays from then on, whatever happens. */
LUM_MUST_CHECK int lum_sink_open_growing(const char *path, lum_sink **out,
                                         lum_error *error);

/** Keep bytes in memory, for lum_sink_move(). Only that and what appends serve
 * such a sink; lum_sink_abort() frees it.
 * @param path as for lum_sink_open(), for messages.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_sink_open_memory(const char *path, lum_sink **out,
                                        lum_error *error);

/** Append all that a sink in memory has, which is empty then. Much is written
 * to a file at once, by the calling thread and without a copy: who has just
 * made it has it in its cache.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_sink_move(lum_sink *sink, lum_sink *from,
                                 lum_error *error);

/** Forget what a sink in memory has. */
void lum_sink_clear(lum_sink *sink);

/** Whether lum_sink_patch() can work: a regular file, not opened to append. */
bool lum_sink_seekable(const lum_sink *sink);

/** The name for messages. */
const char *lum_sink_name(const lum_sink *sink);

/** Get room for n bytes, at most LUM_SINK_BLOCK_BYTES, to be filled in place.
 * @return where to put them, valid until the next call; or NULL with the reason
 *         in error and in errno. */
LUM_MUST_CHECK char *lum_sink_reserve(lum_sink *sink, size_t n,
                                      lum_error *error);

/** Take the first n bytes of the room reserved last. */
void lum_sink_commit(lum_sink *sink, size_t n);

/** Append n bytes, any number.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_sink_write(lum_sink *sink, const void *bytes, size_t n,
                                  lum_error *error);

/** The same without a copy of what is large: the caller leaves the bytes as
 * they are until lum_sink_settle(), or until the sink is closed or aborted. */
LUM_MUST_CHECK int lum_sink_lend(lum_sink *sink, void *bytes, size_t n,
                                 lum_error *error);

/** Wait until what was lent is written.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_sink_settle(lum_sink *sink, lum_error *error);

/** Bytes appended so far. */
uint64_t lum_sink_bytes(const lum_sink *sink);

/** Begin to write what was appended, so that a reader sees it; does not wait.
 * While the thread is still at what came before, nothing happens: call again
 * later. Tells, too, that the reader has left when there is nothing to write.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_sink_flush(lum_sink *sink, lum_error *error);

/** As lum_outfile_check(). From the first call on the thread looks after each
 * block that it writes; while it writes, the answer is that of its last look.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_sink_check(lum_sink *sink, lum_error *error);

/** Overwrite n bytes at an offset from this output's first byte, after all that
 * was appended has been written. Only if lum_sink_seekable().
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_sink_patch(lum_sink *sink, uint64_t offset,
                                  const void *bytes, size_t n,
                                  lum_error *error);

/** Write what is left, wait until it is on the disk, give the file its name,
 * free the sink.
 * @return 0, or -1 with the reason in error and in errno; then nothing is left
 *         behind, except of a file that others removed or renamed: see
 *         lum_outfile_finish(). */
LUM_MUST_CHECK int lum_sink_close(lum_sink *sink, lum_error *error);

/** Stop writing, remove the file, free the sink. NULL is allowed. Does not wait
 * for a reader that has stopped reading. errno stays. */
void lum_sink_abort(lum_sink *sink);

/** Say that there is no memory to open a file.
 * @return -1 with the reason in error and in errno. */
int lum_sink_no_memory(const char *path, lum_error *error);

#endif
