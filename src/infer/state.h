/** @file
 * The steps of an inference, and what they hand to each other. Internal. */
#ifndef LUM_INFER_STATE_H
#define LUM_INFER_STATE_H

#include "lum/infer/infer.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Bytes of a payload that can be read, whatever its length: a field of 8 bytes
 * may begin at 64. */
#define LUM_INFER_HEAD_BYTES 72u

/* Where fields and samples may stand. */
#define LUM_INFER_FIELDS_AT      12u
#define LUM_INFER_SAMPLES_AT_MAX 64u

/* Four bytes of ticks shorter than this wrap within minutes. */
#define LUM_INFER_SHORT_TICK_NS 100.0

/* Most sensors that are told apart. */
#define LUM_INFER_SENSORS_MAX 16u

/** What a packet's samples look like, whatever its header says. */
typedef enum lum_infer_kind {
    LUM_INFER_UNKNOWN, /**< too few, or neither */
    LUM_INFER_ANGLES,  /**< one value sweeps, the other is calm */
    LUM_INFER_RANGES   /**< bit 11 clear, pixels 0..999 rise */
} lum_infer_kind;

/** A packet that is looked at. */
typedef struct lum_infer_packet {
    const uint8_t *bytes; /**< the first kept of them, and zeros up to
                               ::LUM_INFER_HEAD_BYTES */
    int64_t time_ns;      /**< of its capture */
    uint32_t len;         /**< of the whole payload */
    uint32_t kept;        /**< bytes of the payload that are there */
    uint8_t sensor;       /**< which */
    uint8_t kind;         /**< a ::lum_infer_kind */
    uint8_t sweeps;       /**< angles: 1, 2: which of a pair sweeps; 0: none */
    bool is_reserved_0;   /**< bytes 9..11 are 0 */
    int16_t calm;         /**< angles: the value that hardly changes */
    int16_t first[2];     /**< angles: of each of a pair, the first value */
    int16_t low[2];       /**< likewise the least */
    int16_t high[2];      /**< likewise the largest */
} lum_infer_packet;

/** Packets in the order of their arrival, sensor by sensor. */
typedef struct lum_infer_packets {
    lum_infer_packet **at;
    size_t count;
} lum_infer_packets;

/** The bits of a header that a field has taken, 8 for each byte, bit 0 the
 * lowest of a byte. */
typedef struct lum_infer_bits {
    uint8_t byte[LUM_INFER_HEAD_BYTES];
} lum_infer_bits;

/** How the samples are read. */
typedef struct lum_infer_samples {
    unsigned at;      /**< offset of the first */
    bool is_big;      /**< byte order */
    bool is_el_first; /**< the second of a pair sweeps */
    size_t angles;    /**< packets that look like angles */
    size_t ranges;    /**< and like ranges */
    double smooth;    /**< share of angle packets that go on smoothly at at */
    double before;    /**< and one sample before */
    double cut;       /**< share of angle packets of 334 or 332 samples */
    double equal;     /**< share of lengths that are at + 4 n */
    int low[2];       /**< least azimuth and elevation, but for a few */
    int high[2];      /**< largest, likewise */
} lum_infer_samples;

/** A field with the share of packets that it explains. */
typedef struct lum_infer_choice {
    lum_field field; /**< bytes 0: none */
    double share;    /**< 0..1 */
    double second;   /**< of the best that gives other values */
    lum_field rival; /**< that one; bytes 0: none */
} lum_infer_choice;

/** A line number and an eye, which only together make sense. */
typedef struct lum_infer_reading {
    lum_field line; /**< bytes 0: there is no such reading */
    lum_field eye;  /**< bytes 0: it has no place */
    uint32_t eye_value[LUM_EYES];
    bool is_one_eye;     /**< only one was recorded */
    double share;        /**< what it explains, 0..1 */
    lum_field equal_eye; /**< tells the same as eye; bytes 0: nothing does */
} lum_infer_reading;

/** Line number and eye. Set by readings.c and eyes.c. */
typedef struct lum_infer_readings {
    lum_infer_reading best;
    lum_infer_reading other_line; /**< the best with other line numbers */
    lum_infer_reading other_eye;  /**< the best with other eyes */
    lum_field equal_line;         /**< numbers lines alike; bytes 0: none */
    size_t lines;                 /**< beginnings of lines */
    size_t steps;                 /**< from line to line that were judged */
} lum_infer_readings;

/** What the clock is. Set by clocks.c. */
typedef struct lum_infer_clock {
    lum_infer_bits varying; /**< that change, of what follows time best */
    lum_infer_bits whole;   /**< all of that */
    bool has_times;         /**< times of capture rise */
    double span_ns;         /**< that the packets of the clock span */
    double tick_ns;         /**< length of a tick, as measured; 0: not */
    double spread;          /**< share of it by which half of what was measured
                                 differs */
    uint32_t unit_ns;       /**< what is taken */
    bool is_unit_told;      /**< it was measured */
    uint32_t rival_unit_ns; /**< of the clock's rival */
    lum_field equal;        /**< gives the same times; bytes 0: none */
    unsigned unread_at;     /**< a byte that changes from line to line, where
                                 nothing is a clock and no field has it; 0:
                                 there is none */
} lum_infer_clock;

/** All that has been found out. */
typedef struct lum_infer_state {
    lum_infer_packets all;  /**< what may be data */
    lum_infer_packets data; /**< of the data's type */
    lum_infer_packets good; /**< of these, with a kind */
    unsigned type;          /**< of the data */
    bool is_tag_type;       /**< types 2 and 3 are the tags */
    lum_infer_samples samples;
    lum_infer_choice field[LUM_GROUP_FIELDS];
    /* What fields were before zeros beside them were taken; bytes 0: none
     * were. */
    lum_field narrow[LUM_GROUP_FIELDS];
    lum_infer_bits used;
    lum_infer_readings readings;
    lum_infer_clock clock;
    double line_us;        /**< longest line */
    uint32_t line_span_us; /**< what is taken */
} lum_infer_state;

/* --- The packets that are looked at: packet_store.c --- */

/** Most blocks of bytes. */
#define LUM_INFER_BLOCKS_MAX 44u

/** Packets by sensor, and what else was seen. */
typedef struct lum_infer_store {
    lum_infer_packet *packets;             /**< in the order of their arrival */
    uint32_t count;                        /**< of them */
    uint8_t *blocks[LUM_INFER_BLOCKS_MAX]; /**< where their bytes are */
    size_t block_count;                    /**< of them */
    size_t used;                           /**< bytes of the last block */
    uint32_t sensors[LUM_INFER_SENSORS_MAX]; /**< their addresses */
    uint32_t max;                            /**< packets that are wanted */
    lum_infer_counts counts; /**< what was pushed, but for packets and
                                  other_type */
} lum_infer_store;

/** Make room for the packets.
 * @return 0, or -1 without memory. */
int lum_infer_store_init(lum_infer_store *store, uint32_t max);

/** Free what it holds. */
void lum_infer_store_free(lum_infer_store *store);

/** Whether there is room for no more. */
bool lum_infer_store_is_full(const lum_infer_store *store);

/** Keep a datagram if it may be data.
 * @param sensor the address of the sensor's side.
 * @return 1: there is room for more; 0: there is none; -1: no memory. */
int lum_infer_store_add(lum_infer_store *store, const lum_record *record,
                        uint32_t sensor);

/* --- The steps, each in the file that has its name or its subject --- */

/** Find the order and the place of samples, and each packet's kind.
 * @param state its packets are marked; samples and their range are set.
 * @return whether samples of angles were found. */
bool lum_infer_find_samples(lum_infer_state *state);

/** Where samples begin, of the packets of the data's type. */
void lum_infer_place_samples(lum_infer_state *state);

/** Samples that fit behind the header.
 * @return how many; 0 where it is too short. */
uint32_t lum_infer_room(const lum_infer_packet *packet, unsigned samples_at);

/** Find the tag: 2 where samples are angles, 3 where they are ranges. */
void lum_infer_find_tag(lum_infer_state *state);

/** Find num_samples: 4 times it, and the samples' offset, is the length. */
void lum_infer_find_num_samples(lum_infer_state *state);

/** Find first_sample_index: 0, 334, 668 of angles; of ranges, the words that
 * came before. */
void lum_infer_find_first(lum_infer_state *state);

/** Find which bits follow the time of capture, before it is known which are the
 * line's and the eye's: as a whole they are a clock, and alone none of them
 * tells the eye.
 * @return 0, or -1 without memory. */
int lum_infer_follow_time(lum_infer_state *state);

/** Find the clock among what other fields have left: it rises as the time of
 * capture does. Its unit and the length of lines come with it.
 * @return 0, or -1 without memory. */
int lum_infer_find_clock(lum_infer_state *state);

/** Find the line number and the eye: eyes take turns, and for each of them the
 * number rises by 1 from line to line. The clock's bits are known already. With
 * one eye alone, only the line number is taken.
 * @return 0, or -1 without memory. */
int lum_infer_find_lines(lum_infer_state *state);

/** With one eye alone, once all other fields are known: a place for the eye.
 * @return 0, or -1 without memory. */
int lum_infer_place_one_eye(lum_infer_state *state);

/** Give fields their shape. Values do not change. */
void lum_infer_shape(lum_infer_state *state);

/** Whether two fields share bytes as no profile can say.
 * @param one which, if so
 * @param two the other one */
bool lum_infer_clash(const lum_infer_state *state, unsigned *one,
                     unsigned *two);

/** A wider field with the same values, all of whose further bytes are 0 and of
 * no other field.
 * @return false: there is none. */
bool lum_infer_wider(const lum_infer_state *state, lum_field field,
                     lum_field *out);

/** The name of a key, such as "group.tag". */
const char *lum_infer_name(unsigned key);

/** Each key with its value and the evidence, of a result with a profile. */
void lum_infer_report(const lum_infer_state *state, lum_infer_result *out);

/** Set the second best reading of a result: the profile with the rival of a
 * field. There is none if no profile can say it, or if it decodes the packets
 * as the profile does.
 * @param field a ::lum_group_field. */
void lum_infer_second(const lum_infer_state *state, unsigned field,
                      lum_infer_result *out);

#endif
