/** @file
 * Points without lines: the words of each packet as it comes, with the angles
 * of its line.
 *
 * An assembler waits for whole lines and keeps all their words. A receiver
 * keeps the angles of one line of each eye, the current one, and the words of
 * one packet: half the memory, and points as soon as a datagram is there. It
 * hands out a ::lum_line with only the words of that packet, which
 * lum_points_fixed_compute() and lum_returns_compute() take as it is:
 *
 * @code
 * if (lum_packet_decode(&layout, bytes, len, &group) == LUM_PACKET_DATA &&
 *     lum_receiver_push(&r, &group) == LUM_OK) {
 *     const lum_line *line = lum_receiver_line(&r);
 *     for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
 *         n = lum_points_fixed_compute(&projector, line, i, BLOCK, points,
 *                                      &losses);
 *         use(points, n);
 *     }
 * }
 * @endcode
 *
 * **Words that come before the angles of their pixels are lost.** They are
 * counted in lum_point_losses.no_angle. An assembler keeps them until the
 * angles come; a receiver does not. A sensor that sends the words of a line
 * before its angles needs an assembler.
 *
 * **In order**, when each eye's lines follow one another and angles precede
 * their words, it gives the same points as an assembler, but in the order of a
 * packet's words, which an assembler sorts by pixel.
 *
 * **In disorder** it gives fewer points: each at most once, and each one that
 * an assembler gives of the same packets in order:
 *  - a packet of another line, unless that is older, ends the current line.
 *    Later packets of the ended line are dropped and counted as late;
 *  - a lost packet of angles takes the points of its pixels with it;
 *  - a packet is dropped and counted if one of its pixels already has samples
 *    of the packet's kind: a pixel never spans two packets;
 *  - a clock far from the eye's last is not believed until a second packet
 *    agrees; then it is a jump, and all lines are forgotten.
 *
 * It recognises a line by its number and a clock within line_span_us of the
 * line's first packet, as an assembler does. So a line must be shorter than
 * that, and its number must come again later than twice that. If packets do not
 * show this, angles of a line may be joined with words of another line of the
 * same number. So call lum_receiver_forget() after a silence: the sensor may
 * have restarted, or its clock wrapped. Do not rely on points of a receiver if
 * the profile has no clock, or one that wraps within a frame, and all packets
 * in between may be lost.
 *
 * While a line is under way, its frame and what is still to come are not known.
 * Return numbers, counts and pulse widths are known, because all words of a
 * pixel are in one packet: see lum_receiver_is_sorted().
 *
 * Any sequence of calls is defined, for a receiver that was begun or has all
 * bytes 0. Integers only, no heap; two receivers in two threads need no lock,
 * one receiver in two threads does. */
#ifndef LUM_RECEIVER_H
#define LUM_RECEIVER_H

#include "lum/assembler.h"
#include "lum/group.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LUM_RECEIVER_GAP_US LUM_GAP_US /**< the protocol's value of gap_us */

/** Most words of a datagram with this number of payload bytes. */
#define LUM_RECEIVER_WORDS(bytes) ((bytes) / LUM_SAMPLE_BYTES)

/** What was seen and lost since lum_receiver_init(); none ever wraps. A line is
 * counted when it has ended. */
typedef struct lum_receiver_counters {
    uint64_t stray;                /**< packets far from the stream's clock */
    uint64_t late;                 /**< packets of lines that have ended */
    uint64_t duplicate;            /**< packets whose samples had all come
                                        before */
    uint64_t conflict;             /**< packets with some samples that had come
                                        before */
    uint64_t no_room;              /**< packets of more words than fit */
    uint64_t bad_words;            /**< words of accepted packets skipped */
    uint64_t words;                /**< good words handed out, whether or not
                                        their pixels have angles */
    uint64_t lines;                /**< lines that ended */
    uint64_t lines_missing_angles; /**< of them with fewer than 1000 */
    uint64_t lines_skipped;        /**< line numbers without any packet */
    uint64_t lost_words;           /**< words known to be lost of lines that
                                        ended; may be more */
} lum_receiver_counters;

/** One eye. Private. Clocks are the low 32 bits. */
typedef struct lum_receiver_eye {
    bool is_open;        /**< private: slot has a line */
    bool has_heard;      /**< private: newest_us is a clock */
    bool has_candidate;  /**< private: candidate_us is a clock */
    bool has_settled;    /**< private: the next two are set */
    uint32_t settled;    /**< private: number of the last line that two packets
                              agreed on */
    uint32_t settled_us; /**< private: its clock; what is older is late */
    uint32_t newest_us;  /**< private: largest clock since the last jump */
    uint32_t candidate_us; /**< private: of a stray that may prove a jump */
    uint32_t word_marks[LUM_PIXEL_MARK_WORDS]; /**< private: pixels of the line
                                                    that have words */
    lum_line_slot slot;                        /**< private: the line */
} lum_receiver_eye;

/** One sensor's receiver, both eyes. Only its size is public. It points into
 * itself: do not copy it. One with all bytes 0 refuses all packets. */
typedef struct lum_receiver {
    uint8_t angle_order;            /**< private */
    bool is_sorted;                 /**< private */
    uint32_t line_span_us;          /**< private */
    uint32_t gap_us;                /**< private */
    uint32_t *words;                /**< private: of the packet at hand */
    uint32_t word_room;             /**< private */
    lum_line *line;                 /**< private: of the packet at hand */
    uint32_t clock_us;              /**< private: of the last that was no
                                         stray */
    lum_clock clock;                /**< private */
    lum_receiver_counters counters; /**< private */
    lum_receiver_eye eye[LUM_EYES]; /**< private */
} lum_receiver;

/** Begin.
 *
 * @code
 * static uint32_t words[LUM_RECEIVER_WORDS(1472)];
 * r = lum_receiver_init(&receiver, &layout, LUM_RECEIVER_GAP_US, words,
 *                       sizeof words / sizeof words[0]);
 * @endcode
 *
 * @param r          caller-owned; written only on LUM_OK.
 * @param layout     the one that packets are decoded with; copied as far as
 *                   needed.
 * @param gap_us     below 2^30; a packet whose clock is farther than this from
 *                   its eye's newest is a stray.
 * @param words      room for the words of one packet; kept, and the receiver's
 *                   alone while it is used. Need not be initialised.
 * @param word_count how many; packets of more good words are dropped.
 * @return LUM_OK; LUM_E_VALUE if gap_us is too large, or the linked layout file
 *         is made for another layout (docs/firmware-reference.md); LUM_E_SPACE
 *         if word_count is 0. Constant time. */
LUM_MUST_CHECK lum_result lum_receiver_init(lum_receiver *r,
                                            const lum_layout *layout,
                                            uint32_t gap_us, uint32_t *words,
                                            uint32_t word_count);

/** Take one data packet.
 * @param group a decoded packet; neither it nor its samples are kept, so the
 *              datagram may be overwritten at once.
 * @return LUM_OK: accepted; lum_receiver_line() has the packet's words, or none
 *         if it has angles.
 *         LUM_E_STRAY, LUM_E_LATE, LUM_E_DUPLICATE, LUM_E_CONFLICT,
 *         LUM_E_NO_ROOM: dropped and counted.
 *         LUM_E_ORDER: the receiver was not begun.
 *         LUM_E_VALUE: an eye, tag or count of samples that lum_group_decode()
 *         never gives.
 * On each of these errors lum_receiver_line() has no words. Linear in the
 * packet's samples, in any order. */
LUM_MUST_CHECK lum_result lum_receiver_push(lum_receiver *r,
                                            const lum_group *group);

/** The line of the packet that was pushed last, with that packet's good words
 * in their order. Its angles are those that came so far; if
 * lum_line_has_angles() is false, a pixel's angles have no meaning. frame and
 * arrival are 0; lost_words are those of the line so far; there may be more.
 * @return lives, with all it points to, until the next push or
 *         lum_receiver_forget(); NULL if the receiver was not begun. */
const lum_line *lum_receiver_line(const lum_receiver *r);

/** Whether the words of lum_receiver_line() are ordered by pixel, as all known
 * sensors send them. If not, their points are right, but lum_returns_compute(),
 * which needs the words of a pixel together, must not be called: number and
 * count of returns and pulse widths are not known. */
bool lum_receiver_is_sorted(const lum_receiver *r);

/** Forget the current lines: after a silence, or at the end of a stream, so
 * that the counters include them. Packets may come again, with any clock. */
void lum_receiver_forget(lum_receiver *r);

/** What was seen and lost. Lives as long as r; changes with each call. */
const lum_receiver_counters *lum_receiver_counted(const lum_receiver *r);

#ifdef __cplusplus
}
#endif

#endif
