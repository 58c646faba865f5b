/** @file
 * A file by several threads, which is byte for byte what one thread writes.
 *
 * A part is a writer that keeps the rows of its lines in memory, and the file's
 * own writer takes them. One thread at a time may use a part; parts and the
 * file share nothing. Internal. */
#ifndef LUM_CLOUD_PART_H
#define LUM_CLOUD_PART_H

#include "lum/cloud/writer.h"

/** Whether files of a format can be made of parts. Not if they are
 * organised. */
bool lum_format_has_parts(lum_format format);

/** Which numbers of samples no file of a format reads: LUM_LEAVE_DEGREES and
 * LUM_LEAVE_RETURNS of points/columns.h.
 * @param columns as lum_writer_options.columns. */
unsigned lum_format_leaves(lum_format format, const char *columns);

/** Begin a part. Lines are added by lum_writer_add(), and lum_writer_abort()
 * frees it.
 * @param path    the file's name, for messages.
 * @param options those of the file; a rehearsal is not read.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_writer_open_part(const char *path,
                                        const lum_writer_options *options,
                                        lum_writer **out, lum_error *error);

/** Points of a part. */
uint64_t lum_writer_part_points(const lum_writer *part);

/** Append a part to its file; then it is empty, also after a failure.
 * @return as lum_writer_add(). */
LUM_MUST_CHECK int lum_writer_add_part(lum_writer *writer, lum_writer *part,
                                       lum_error *error);

/** Empty a part. */
void lum_writer_clear_part(lum_writer *part);

/** Have an MCAP file compress chunks by threads, before its first message;
 * other files have no use for them. Each takes the memory of a chunk twice.
 * lum_writer_bytes() lags by the chunks that they are at.
 * @param threads up to LUM_MCAP_THREADS_MAX; more are these. */
void lum_writer_pack_by(lum_writer *writer, unsigned threads);

/** Say that a line will come, of which the samples are not read yet: all lines
 * of a frame between lum_writer_begin_frame() and the first lum_writer_add().
 * Then come lum_writer_add() of the same lines in the same order and
 * lum_writer_end_frame(), and nothing else before these; with other points
 * these fail (EINVAL). An MCAP file writes its points as they come instead of
 * keeping them; other files have no use for it.
 * @param line its count, line, eye and times are read; not kept. */
void lum_writer_foresee(lum_writer *writer, const lum_line_samples *line);

#endif
