/** @file
 * Writes lines as packets of a capture, as the sensor would have sent them: for
 * a drive that was cut, edited, disturbed or invented.
 *
 * @code
 * for each frame {
 *     for each of its lines { lum_packet_writer_add(writer, &line, &error); }
 *     lum_packet_writer_end_frame(writer, &error);
 * }
 * lum_packet_writer_close(writer, &error);
 * @endcode
 *
 * If a line's packets are known and still fit its angles and words, they keep
 * their cuts, times and order; if the line's clock or arrival is no longer that
 * of the first packet, all move with it. Otherwise the line is cut as the
 * sensor does it: 334, 334 and 332 angles, then words, whole pixels in packets
 * of up to 1472 bytes, each with the line's clock and arrival.
 *
 * Each packet also goes through the reassembly of a reader. If that takes it
 * for a stray, as at each jump of the clock, it is written twice: a reader
 * believes a jump only when a second packet confirms it. Packets that a reader
 * would still drop are written and counted.
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
                                                 pcap. The file gets its name
                                                 when it is closed; is_whole is
                                                 ignored */
} lum_packet_writer_options;

/** A line to be written. All bytes 0 except struct_size are an empty line. */
typedef struct lum_raw_line {
    size_t struct_size;       /**< sizeof(lum_raw_line) */
    const lum_layout *layout; /**< of its packets' clocks; NULL: the writer's.
                                 If its clock has another unit or fewer bits,
                                 each packet gets the line's clock */
    int64_t clock_us;   /**< sensor clock; cut to the width of the profile's
                             field, as the clock itself wraps. If it differs
                             from that of the first of packets, all of them
                             move */
    int64_t arrival_ns; /**< ns since 1970 UTC, 0 or above; likewise */
    const lum_angle *angles;       /**< LUM_LINE_PIXELS of them; NULL: none */
    const uint32_t *angle_marks;   /**< LUM_PIXEL_MARK_WORDS: which pixels have
                                        angles; NULL: none */
    const uint32_t *words;         /**< good ones, ordered by pixel */
    size_t word_count;             /**< how many */
    const lum_raw_packet *packets; /**< that it was made of, in the order of
                                        arrival; their member line is ignored */
    size_t packet_count;           /**< 0: not known */
    uint32_t sensor;               /**< address, host order */
    uint32_t number;               /**< line number */
    uint8_t eye;                   /**< an ::lum_eye */
    const uint16_t *places; /**< of each word, as in lum_frame_raw: the order of
                                 words in a packet, if it fits packets and
                                 words; if not, or NULL: ordered by pixel */
} lum_raw_line;

/** What was written. */
typedef struct lum_packet_writer_counters {
    size_t struct_size;      /**< set by the caller */
    uint64_t packets;        /**< written, counting both of those written
                                  twice */
    uint64_t repeated;       /**< written twice, because the clock jumps
                                  there */
    uint64_t lines;          /**< added */
    uint64_t lines_cut_anew; /**< of them cut as the sensor does it: their
                                  packets are unknown or no longer fit */
    uint64_t stray;     /**< packets that a reader drops: far from the clock */
    uint64_t late;      /**< likewise: their lines were handed out already */
    uint64_t duplicate; /**< likewise: all samples had come before */
    uint64_t conflict;  /**< likewise: some samples had come before */
    uint64_t no_room;   /**< likewise: their words do not fit */
    uint64_t clock_jumps; /**< steps of the clock by half a wrap of the
                               profile's field or more: later clocks are read
                               wrong, by whole wraps */
} lum_packet_writer_counters;

/** A writer of lines to a capture. */
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
 *         written: an invalid eye or word, words that are not ordered by pixel,
 *         a value that the profile's field cannot hold, a clock that the
 *         profile's field cannot distinguish from another one, more words of a
 *         pixel than a packet can hold, or there is no memory. Linear. */
LUM_MUST_CHECK int lum_packet_writer_add(lum_packet_writer *writer,
                                         const lum_raw_line *line,
                                         lum_error *error);

/** The lines added since the last call are a frame. Packets of a sensor's
 * frames overlap, so those of at most four frames of each sensor are kept in
 * memory until their order is known. A frame that begins before the previous
 * one, by order or by arrival, starts another drive: all frames added earlier
 * are written first.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_packet_writer_end_frame(lum_packet_writer *writer,
                                               lum_error *error);

/** What was written so far.
 * @return LUM_OK; LUM_E_VALUE if struct_size of out is not set. */
lum_result lum_packet_writer_count(const lum_packet_writer *writer,
                                   lum_packet_writer_counters *out);

/** Write all remaining packets to the file, which gets no name yet. After that
 * the counters are complete.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_packet_writer_flush(lum_packet_writer *writer,
                                           lum_error *error);

/** Write all remaining packets, give the file its name, and close. NULL is
 * allowed.
 * @return 0, or -1 with the reason in error, and there is no file; closed
 *         either way. */
LUM_MUST_CHECK int lum_packet_writer_close(lum_packet_writer *writer,
                                           lum_error *error);

/** Close, without a file. NULL is allowed. */
void lum_packet_writer_abort(lum_packet_writer *writer);

#ifdef __cplusplus
}
#endif

#endif
