/** @file
 * Sources in, frames or lines out (docs/reader.md).
 *
 * @code
 * lum_reader_options options = {.struct_size = sizeof options,
 *                               .path = "drive.pcap"};
 * const lum_frame *frame = NULL;
 * int status = lum_reader_open(&options, &reader, &error);
 * while (status >= 0 &&
 *        (status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
 *     const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
 *     use(x, lum_frame_count(frame));
 * }
 * lum_reader_close(reader);
 * @endcode
 *
 * The last frame comes too, even if the source breaks off: first what was read,
 * then the error. Only one thread at a time may use a reader. Its memory does
 * not grow with the stream. */
#ifndef LUM_FRAME_READER_H
#define LUM_FRAME_READER_H

#include "lum/base/error.h"
#include "lum/capture/capture.h"
#include "lum/capture/record.h"
#include "lum/capture/source.h"
#include "lum/frame/framer.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Options of a reader. All bytes except struct_size and a source may be 0:
 * these are the defaults. */
typedef struct lum_reader_options {
    size_t struct_size; /**< sizeof(lum_reader_options) */
    const char *path;   /**< a capture, "-": standard input; set exactly one of
                             path, source, records and paths */
    lum_source *source; /**< bytes of a capture, from memory or a function of
                           the caller; taken over, also on failure */
    const lum_record_source *records; /**< copied; closed also on failure */
    const lum_framer_options *framer; /**< what is wanted; NULL: the default */
    const char *const *paths; /**< instead of path: path_count captures, read
                                 as one by lum_capture_open_several() */
    size_t path_count;        /**< 0: none */
    /** Asked every few milliseconds while the reader opens, reads, waits or
     * seeks, in the thread of that call: to stop it, or to show its progress.
     * It must not call functions of this reader, except lum_reader_progress()
     * once the reader is open. NULL: no function is called.
     * @return whether to go on; false ends the reading: the call that is under
     *         way and all later ones return -1, with the error "stopped by the
     *         caller". Frames under way are dropped. */
    bool (*go_on)(void *context);
    void *go_on_context; /**< handed to go_on */
    bool keeps_index; /**< note while reading where frames are, so that seeking
                           is fast; takes at most 4 MiB, and about 1 % more
                           time */
} lum_reader_options;

/** A reader. */
typedef struct lum_reader lum_reader;

/** Open a source.
 * @param options read, with all that it points to, and not kept.
 * @param out     to be closed with lum_reader_close(); NULL on failure.
 * @param error   may be NULL; gets the message on failure: as for
 *                lum_capture_open() and lum_framer_new(), or that there is not
 *                exactly one source.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_reader_open(const lum_reader_options *options,
                                   lum_reader **out, lum_error *error);

/** Close. Frames that were kept stay valid. NULL is allowed. */
void lum_reader_close(lum_reader *reader);

/** Read until the next event.
 * @param event gets an event: never LUM_FRAMER_NONE or LUM_FRAMER_FAILED.
 *              lum_framer_options.wants says which ones come. The framer of
 *              lum_reader_framer() has the data of the event until the next
 *              call.
 * @return 1; 0 at the end; -1 if the rest cannot be read or there is no memory,
 *         with the reason in error. Before 0 or -1 for the source, all that was
 *         read has come out. Further calls return the same again. */
LUM_MUST_CHECK int lum_reader_next(lum_reader *reader, lum_framer_event *event,
                                   lum_error *error);

/** Read until the next frame; other events are skipped.
 * @param out gets the frame in the first view; lives until the next call,
 *            longer with lum_frame_keep().
 * @return as lum_reader_next(). */
LUM_MUST_CHECK int lum_reader_next_frame(lum_reader *reader,
                                         const lum_frame **out,
                                         lum_error *error);

/** The framer, for the data of events, counters, views and skipping. Only the
 * reader may push records. */
lum_framer *lum_reader_framer(lum_reader *reader);

/** The progress of the reading, as lum_capture_progress(). */
void lum_reader_progress(const lum_reader *reader, uint64_t *done,
                         uint64_t *total);

/** Warnings about the stream, as lum_capture_remark().
 * @param i   from 0 on.
 * @param out gets it.
 * @return false after the last. */
LUM_MUST_CHECK bool lum_reader_remark(const lum_reader *reader, size_t i,
                                      lum_error *out);

/** As lum_capture_damaged(), of the current reading; 0 for records. */
uint64_t lum_reader_damaged(const lum_reader *reader, lum_error *error);

/** Go to a frame by its place in the order in which frames come, from 0 on:
 * lum_reader_next() or lum_reader_next_frame() gives it next, and then all that
 * follow. They are the same, in each column, line and info, as in a reading
 * from the start; events before it do not come. Frames that were not kept
 * become invalid.
 *
 * This takes as long as reading a few frames (milliseconds) if the index has an
 * entry before the frame (lum_reader_options.keeps_index); else as reading from
 * the present place, if that is before the frame, or from the start. A pipe
 * cannot be read again from its start. Several captures read as one, and
 * compressed ones, have no index: they are opened again. If a sensor has
 * stopped sending or sends its frames rarely, the time is longer.
 *
 * Counters (lum_framer_count(), lum_demux_count()) begin at 0 again, but
 * include a little from before the frame. lum_framer_skip_to() does not apply
 * any more.
 * @param frame if there are fewer, the reading is at its end.
 * @param error may be NULL; gets the reason: records that are not of a capture,
 *              a reader that gives no frames or was stopped, a source that
 *              cannot be read again, no memory.
 * @return 0, or -1. The work is done by the next reading, with its errors. */
LUM_MUST_CHECK int lum_reader_seek_frame(lum_reader *reader, uint64_t frame,
                                         lum_error *error);

/** Go to a sensor's frame with a number, or to its first with a higher one; as
 * lum_reader_seek_frame().
 * @param sensor its address, host order; if several share it, the first; to
 *               reach another, seek a time.
 * @param number 0 to 2^32 - 1. */
LUM_MUST_CHECK int lum_reader_seek_number(lum_reader *reader, uint32_t sensor,
                                          int64_t number, lum_error *error);

/** Go to the first frame, in the order in which they come, that begins at a
 * time or later: by its begin_utc_ns, or if its layout has no clock, by its
 * begin_arrival_ns. As lum_reader_seek_frame(). */
LUM_MUST_CHECK int lum_reader_seek_time(lum_reader *reader, int64_t utc_ns,
                                        lum_error *error);

/** The state of an index. */
typedef struct lum_reader_index {
    size_t struct_size; /**< sizeof(lum_reader_index), set by the caller */
    uint64_t frames;    /**< known so far, in all */
    bool is_whole;      /**< there are no more */
    bool is_kept;       /**< entries are made: lum_reader_options.keeps_index,
                             and the source allows it */
    uint64_t entries;   /**< frames that reading can begin with */
    uint64_t bytes;     /**< of memory that they take */
    uint64_t next;      /**< place of the frame that comes next, from 0 on */
} lum_reader_index;

/** Read the state of the index.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_reader_get_index(const lum_reader *reader,
                                lum_reader_index *out);

/** Write the index to a file (docs/formats.md, Index), which gets its name when
 * it is whole.
 * @param path NULL: the capture's name with ".lumindex" appended.
 * @param error may be NULL; gets the reason: there is no index, because it was
 *              not requested or the source is not one file; or the file cannot
 *              be written.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_reader_save_index(lum_reader *reader, const char *path,
                                         lum_error *error);

/** Use an index that was written. One that is damaged, or of another capture,
 * version or other options, is not used; one that knows less than the reader's
 * own is ignored.
 * @param path  as for lum_reader_save_index().
 * @param error may be NULL; gets why it is not used.
 * @return 1 if it is used or ignored; 0 if there is no such file; -1 if it is
 *         not used. Either way, the reader goes on as before. */
LUM_MUST_CHECK int lum_reader_load_index(lum_reader *reader, const char *path,
                                         lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
