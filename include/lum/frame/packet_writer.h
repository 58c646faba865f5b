/** @file
 * Lines to packets in a capture, as the sensor would have sent them: for a
 * drive that is cut, edited, disturbed or made up.
 *
 * @code
 * for each frame {
 *     for each of its lines { lum_packet_writer_add(writer, &line, &error); }
 *     lum_packet_writer_end_frame(writer, &error);
 * }
 * lum_packet_writer_close(writer, &error);
 * @endcode
 *
 * Where a line's packets are known and still fit its angles and words, they are
 * cut, stamped and ordered as they were, moved if its clock or arrival is not
 * that of the first of them any more. Otherwise the line is cut as the
 * sensor does it: 334, 334 and 332 angles, then words, whole pixels in packets
 * of up to 1472 bytes, each with the line's clock and arrival.
 *
 * Each packet also goes through the reassembly of a reader. Where that takes it
 * for a stray, which is so at each jump of the clock, it is written twice: a
 * reader believes a jump only when a second packet confirms it. What a reader
 * would drop all the same is written and counted.
 *
 * Only one thread at a time may use a writer. */
#ifndef LUM_FRAME_PACKET_WRITER_H
#define LUM_FRAME_PACKET_WRITER_H

#include "lum/base/error.h"
#include "lum/capture/capture.h"
#include "lum/frame/raw.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How packets are written. */
typedef struct lum_packet_writer_options {
    size_t struct_size;       /**< sizeof(lum_packet_writer_options) */
    const lum_layout *layout; /**< of the packets; NULL: lum_layout_default() */
    const lum_capture_writer_options *file; /**< format and comments; NULL:
                                               pcap. The file gets its name when
                                               it is closed, whatever is_whole
                                                 says */
} lum_packet_writer_options;

/** A line to be written. All bytes 0 except struct_size are an empty line. */
typedef struct lum_raw_line {
    size_t struct_size; /**< sizeof(lum_raw_line) */
    const lum_layout
        *layout;        /**< that its packets' clocks are of; NULL: the
                             writer's. Where its clock has another unit or
                             fewer bits, each packet has the line's clock */
    int64_t clock_us;   /**< sensor clock; cut to the width of the profile's
                             field, as the clock itself goes round. Another one
                             than that of the first of packets moves them all */
    int64_t arrival_ns; /**< ns since 1970 UTC, 0 or above; likewise */
    const lum_angle *angles;       /**< LUM_LINE_PIXELS of them; NULL: none */
    const uint32_t *angle_marks;   /**< LUM_PIXEL_MARK_WORDS: which pixels have
                                        angles; NULL: none */
    const uint32_t *words;         /**< good ones, ordered by pixel */
    size_t word_count;             /**< how many */
    const lum_raw_packet *packets; /**< that it was made of, in the order of
                                        arrival; their line is not looked at */
    size_t packet_count;           /**< 0: not known */
    uint32_t sensor;               /**< address, host order */
    uint32_t number;               /**< line number */
    uint8_t eye;                   /**< an ::lum_eye */
    const uint16_t *places; /**< of each word, as in lum_frame_raw: the words
                                 of a packet are written in this order if that
                                 fits packets and words; NULL, or it does not
                                 fit: ordered by pixel */
} lum_raw_line;

/** What was written. */
typedef struct lum_packet_writer_counters {
    size_t struct_size;      /**< set by the caller */
    uint64_t packets;        /**< written, with those written twice */
    uint64_t repeated;       /**< written twice, since the clock jumps there */
    uint64_t lines;          /**< added */
    uint64_t lines_cut_anew; /**< of them cut as the sensor does it: their
                                  packets are not known, or do not fit any
                                  more */
    uint64_t stray;     /**< packets that a reader drops: far from the clock */
    uint64_t late;      /**< likewise: their lines were handed out already */
    uint64_t duplicate; /**< likewise: all of them was there */
    uint64_t conflict;  /**< likewise: some of them was there */
    uint64_t no_room;   /**< likewise: their words do not fit */
    uint64_t clock_jumps; /**< steps of the clock by half a round of the
                               profile's field or more: the clocks of what
                               follows are read as others, by rounds */
} lum_packet_writer_counters;

/** A capture that lines are written to. */
typedef struct lum_packet_writer lum_packet_writer;

/** Begin a capture.
 * @param path    as for lum_capture_writer_open_as(). It does not change before
 *                lum_packet_writer_close().
 * @param options read, with all that it points to, and not kept.
 * @return 0, or -1 with the reason in error; errno as there. */
LUM_MUST_CHECK int lum_packet_writer_open(
    const char *path, const lum_packet_writer_options *options,
    lum_packet_writer **out, lum_error *error);

/** Add a line.
 * @param line read, with all that it points to, and not kept.
 * @return 0, or -1 with the reason in error, and nothing of the line is
 * written: an eye or a word that is none, words that are not ordered by pixel,
 * a value that the profile's field cannot hold, a clock that the profile's
 *         cannot tell from another one, more words of a pixel than a packet can
 *         hold, or there is no memory. Linear. */
LUM_MUST_CHECK int lum_packet_writer_add(lum_packet_writer *writer,
                                         const lum_raw_line *line,
                                         lum_error *error);

/** The lines added since the last call were a frame. Packets of the frames of a
 * sensor overlap: those of at most four frames of each sensor are kept in
 * memory until their order is known. Frames that begin before the one before
 * them, by order or by arrival, are another drive: what was added before is
 * written first.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_packet_writer_end_frame(lum_packet_writer *writer,
                                               lum_error *error);

/** What was written so far.
 * @return LUM_OK; LUM_E_VALUE if struct_size of out is not set. */
lum_result lum_packet_writer_count(const lum_packet_writer *writer,
                                   lum_packet_writer_counters *out);

/** Write all that is left; the packets are in the file then, which has no name
 * yet. After that the counters are those of the whole.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_packet_writer_flush(lum_packet_writer *writer,
                                           lum_error *error);

/** Write all that is left, give the file its name, and close. NULL is allowed.
 * @return 0, or -1 with the reason in error, and there is no file; closed
 * either way. */
LUM_MUST_CHECK int lum_packet_writer_close(lum_packet_writer *writer,
                                           lum_error *error);

/** Close, without a file. NULL is allowed. */
void lum_packet_writer_abort(lum_packet_writer *writer);

#ifdef __cplusplus
}
#endif

#endif
