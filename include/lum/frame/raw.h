/** @file
 * The raw data of a frame: the words, angles and packets of its lines, as they
 * came. A framer keeps them only if lum_framer_options.keeps_raw is set;
 * without it they cost nothing.
 *
 * With a packet writer (lum/frame/packet_writer.h) they become packets again.
 */
#ifndef LUM_FRAME_RAW_H
#define LUM_FRAME_RAW_H

#include "lum/frame/frame.h"
#include "lum/group.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most bytes after the last sample of a packet that are kept. */
#define LUM_RAW_TAIL_MAX 16u

/** Most samples of a line's packets of ranges whose places are kept. */
#define LUM_RAW_PLACES_MAX 65535u

/** A packet that a line was made of. It never grows. */
typedef struct lum_raw_packet {
    uint64_t clock_raw; /**< sensor clock as sent, in ticks */
    int64_t arrival_ns; /**< when it came, ns since 1970 UTC */
    uint64_t order;     /**< the order in which a framer accepted packets of all
                             lines and sensors; from 0, and rising */
    uint32_t line;      /**< its line's place in the frame */
    uint32_t first_sample_index; /**< as in lum_group */
    uint32_t num_samples;        /**< likewise, with the bad words */
    uint32_t bad_words;          /**< words of it that were skipped */
    uint32_t tag;                /**< LUM_TAG_ANGLES or LUM_TAG_RANGES */
    uint32_t first_pixel; /**< of its first good sample; 0: it has none */
    uint8_t head[LUM_GROUP_HEAD_MAX]; /**< the bytes before its first sample, as
                                           they came, then 0: a sensor may send
                                           more than the profile's fields */
    uint8_t tail[LUM_RAW_TAIL_MAX];   /**< the bytes after its last sample */
    uint32_t tail_bytes; /**< how many these are; 0: none, or more than
                              LUM_RAW_TAIL_MAX: then none are kept */
} lum_raw_packet;

/** The raw part of a frame. Its arrays live as long as the frame. */
typedef struct lum_frame_raw {
    size_t struct_size;         /**< sizeof(lum_frame_raw), set by the caller */
    size_t line_count;          /**< as lum_frame_line_count() */
    const uint64_t *first_word; /**< line_count + 1 of them: the words of line i
                                     are from first_word[i] on, up to
                                     first_word[i + 1] */
    const uint32_t *words; /**< all good words, in the order of the lines, then
                                as in lum_line */
    const uint8_t *gives_point;  /**< a byte for each word: 1 if its pixel has
                                      angles and its range is above 0, whatever
                                      views select and
                                      lum_framer_options.points_max cuts */
    const lum_angle *angles;     /**< LUM_LINE_PIXELS for each line; 0 if
                                      unmarked */
    const uint32_t *angle_marks; /**< LUM_PIXEL_MARK_WORDS for each line, as in
                                      lum_line */
    size_t packet_count;         /**< how many packets are known */
    const lum_raw_packet *packets; /**< in the order of the lines, and within a
                                        line in the order of arrival. A line has
                                        all packets that were accepted, or none
                                        if not all are known: so after a seek,
                                        if it had begun before the place where
                                        reading went on */
    size_t lines_without_packets;  /**< lines whose packets are not known */
    const uint16_t *places; /**< of each word, its place among the samples of
                                 its line's packets of ranges, in the order of
                                 packets and with the bad words: 0, 1, ... NULL:
                                 in each line that is the order of its words.
                                 The same is assumed for a line with more than
                                 LUM_RAW_PLACES_MAX such samples, or without
                                 known packets */
} lum_frame_raw;

/** The raw part of a frame.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if the frame has none, or struct_size is not set:
 *         then nothing is written. Constant time, any thread. */
lum_result lum_frame_get_raw(const lum_frame *frame, lum_frame_raw *out);

#ifdef __cplusplus
}
#endif

#endif
