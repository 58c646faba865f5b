/** @file
 * What the steps of an inference hand to each other. Internal. */
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

#endif
