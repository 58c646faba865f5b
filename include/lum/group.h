/** @file
 * Data packets: samples of one line of one eye (docs/protocol.md, section 6).
 *
 * Input may have any length and any alignment. All functions are reentrant and
 * allocate nothing. */
#ifndef LUM_GROUP_H
#define LUM_GROUP_H

#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LUM_SAMPLE_BYTES   4u  /**< an angle pair, or a range word */
#define LUM_TAG_ANGLES     2u  /**< samples are angle pairs */
#define LUM_TAG_RANGES     3u  /**< samples are range words */
#define LUM_GROUP_HEAD_MAX 64u /**< most bytes before the first sample */

/** A data packet, as a view of its datagram. */
typedef struct lum_group {
    const uint8_t *samples; /**< num_samples x 4 bytes inside the datagram */
    uint64_t clock_raw;     /**< sensor clock as sent, in ticks of the
                                 profile's clock_unit_ns */
    uint32_t line;          /**< line number within the frame */
    uint32_t num_samples;   /**< at least 1 */
    uint32_t first_sample_index; /**< angles: the first pixel; ranges: the
                                      first word's index within the line */
    uint8_t eye;                 /**< an ::lum_eye */
    uint8_t tag;                 /**< LUM_TAG_ANGLES or LUM_TAG_RANGES */
    uint8_t sample_order;        /**< a ::lum_byte_order, of the samples */
} lum_group;

/** Read a datagram whose header is that of a data packet, which
 * lum_packet_decode() checks.
 * @param out its samples point into bytes.
 * @return LUM_OK; LUM_E_MALFORMED if it is shorter than its fields or its
 *         samples, has no samples, the value of neither eye, a line, count or
 *         index above 2^32 - 1, or angles past the line's last pixel;
 *         LUM_E_UNKNOWN_TAG. Constant time. */
LUM_MUST_CHECK lum_result lum_group_decode(const lum_layout *layout,
                                           const void *bytes, size_t len,
                                           lum_group *out);

/** Write a data packet up to its samples, header included.
 * @param out   gets the bytes before the samples; those between fields are 0.
 * @param size  room at out.
 * @param group samples is not read.
 * @param len   gets their count: the samples belong at that offset.
 * clock_raw is cut to the width of its field, as the clock itself wraps.
 * @return LUM_OK; LUM_E_SPACE; LUM_E_VALUE if another value does not fit,
 *         the eye or the tag is unknown, num_samples is 0 or angles would pass
 *         the line's last pixel. */
LUM_MUST_CHECK lum_result lum_group_encode(const lum_layout *layout,
                                           const lum_group *group, void *out,
                                           size_t size, size_t *len);

/** An angle sample: the mirror's position at a pixel's rising edge. */
typedef struct lum_angle {
    int16_t azimuth;   /**< raw; positive to the left */
    int16_t elevation; /**< raw; positive up */
} lum_angle;

/** Read sample i of a packet of angles; i < num_samples. */
lum_angle lum_group_angle(const lum_layout *layout, const lum_group *group,
                          uint32_t i);

/** Write an angle sample. */
void lum_angle_encode(const lum_layout *layout, lum_angle angle,
                      uint8_t out[LUM_SAMPLE_BYTES]);

/** Read sample i of a packet of ranges; i < num_samples. */
uint32_t lum_group_word(const lum_group *group, uint32_t i);

/** Write a range word, its lowest byte first, as the default profile has it. */
void lum_word_encode(uint32_t word, uint8_t out[LUM_SAMPLE_BYTES]);

/** Write a range word in the order of a layout's samples. */
void lum_group_word_encode(const lum_layout *layout, uint32_t word,
                           uint8_t out[LUM_SAMPLE_BYTES]);

#define LUM_TOF_MIN (-524288) /**< smallest time of flight of a word */
#define LUM_TOF_MAX 524287    /**< largest time of flight of a word */

/** Bits of a range word. */
enum lum_word_bits {
    LUM_WORD_PIXEL = 0x3ff,  /**< bits 9..0: pixel, 0..999 */
    LUM_WORD_RISING = 0x400, /**< bit 10: rising edge */
    LUM_WORD_ZERO = 0x800    /**< bit 11: zero in a good word */
};

/** Time of flight in units of the calibration's tof lsb, 13 ps by default. */
static inline int32_t lum_word_tof(uint32_t word)
{
    return LUM_CAST(int32_t, (word >> 12) ^ 0x80000u) - 0x80000;
}

/** Pixel, 0..1023; a good word has at most 999. */
static inline uint32_t lum_word_pixel(uint32_t word)
{
    return word & LUM_WORD_PIXEL;
}

/** Whether the word has a rising edge. */
static inline bool lum_word_is_rising(uint32_t word)
{
    return (word & LUM_WORD_RISING) != 0;
}

/** Whether bit 11 is clear and the pixel is one of the line's. */
static inline bool lum_word_is_good(uint32_t word)
{
    return (word & LUM_WORD_ZERO) == 0 &&
           lum_word_pixel(word) < LUM_LINE_PIXELS;
}

/** Build a range word.
 * @param tof    LUM_TOF_MIN..LUM_TOF_MAX; only its low 20 bits are used.
 * @param pixel  0..999. */
static inline uint32_t lum_word_make(int32_t tof, bool rising, uint32_t pixel)
{
    return (LUM_CAST(uint32_t, tof) << 12) |
           (rising ? LUM_CAST(uint32_t, LUM_WORD_RISING) : 0u) |
           (pixel & LUM_WORD_PIXEL);
}

#ifdef __cplusplus
}
#endif

#endif
