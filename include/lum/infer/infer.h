/** @file
 * The wire profile of a capture: which layout of data packets explains its
 * datagrams (docs/protocol.md, "How a layout is found").
 *
 * @code
 * lum_infer_options options = {.struct_size = sizeof options};
 * if (lum_infer_create(&options, &infer, &error) == 0) {
 *     while (lum_capture_next(capture, &record, &error) == 1 &&
 *            lum_infer_push(infer, &record, &error) == 1) {
 *     }
 *     result.struct_size = sizeof result;
 *     found = lum_infer_solve(infer, &result, &error) == 0;
 * }
 * @endcode
 *
 * Only the datagrams of the capture and their times are used. The answer is the
 * same on every machine. It takes at most 64 MB and, for 20,000 datagrams,
 * seconds at most. Only one thread at a time may use an inference; two share
 * nothing. */
#ifndef LUM_INFER_INFER_H
#define LUM_INFER_INFER_H

#include "lum/base/error.h"
#include "lum/capture/record.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most datagrams that are examined. */
#define LUM_INFER_PACKETS_MAX 20000u

/** An inference under way. */
typedef struct lum_infer lum_infer;

/** Options of an inference. */
typedef struct lum_infer_options {
    size_t struct_size;   /**< sizeof(lum_infer_options), set by the caller */
    uint32_t packets_max; /**< datagrams to examine, at most
                               ::LUM_INFER_PACKETS_MAX, which 0 means */
    bool has_sensor;      /**< only one sensor is requested */
    uint32_t sensor;      /**< its address, host order */
    uint16_t port;        /**< of sensors, if NAT has changed it; 0:
                               ::LUM_PORT */
} lum_infer_options;

/** The result of an inference. */
typedef enum lum_infer_verdict {
    LUM_INFER_FOUND,       /**< one reading explains the packets better than
                                every other one that gives other points */
    LUM_INFER_UNSURE,      /**< a reading was found, but another one that gives
                                other points is about as good (the margin is
                                below ::LUM_INFER_MARGIN_SURE), or too many
                                packets or lines do not fit: the text says which
                                of these */
    LUM_INFER_TOO_LITTLE,  /**< too little data to decide: the text says what is
                                missing */
    LUM_INFER_NOTHING_FITS /**< no reading explains the packets: the text says
                                which identity of the manual fails */
} lum_infer_verdict;

/** What a finding is about: the keys of a profile (docs/protocol.md, section
 * 8), in the order of the YAML. */
typedef enum lum_infer_key {
    LUM_INFER_DATA_PACKET_TYPE,   /**< data_packet_type */
    LUM_INFER_TAG,                /**< group.tag */
    LUM_INFER_EYE,                /**< group.eye */
    LUM_INFER_LINE,               /**< group.line */
    LUM_INFER_NUM_SAMPLES,        /**< group.num_samples */
    LUM_INFER_FIRST_SAMPLE_INDEX, /**< group.first_sample_index */
    LUM_INFER_TIMESTAMP,          /**< group.timestamp */
    LUM_INFER_CLOCK_UNIT,         /**< group.timestamp.unit_ns */
    LUM_INFER_SAMPLES,            /**< group.samples */
    LUM_INFER_EYE_VALUES,         /**< eye_values */
    LUM_INFER_ANGLE_ORDER,        /**< angle_order */
    LUM_INFER_ANGLE_LSB,          /**< angle_lsb_deg */
    LUM_INFER_SAMPLE_ORDER,       /**< sample_order */
    LUM_INFER_LINE_SPAN,          /**< line_span_us */
    LUM_INFER_KEYS                /**< how many there are */
} lum_infer_key;

/** Bytes of a finding's texts, the NUL included. */
#define LUM_INFER_TEXT_BYTES 256

/** What was found out about one key. It never grows. */
typedef struct lum_infer_finding {
    lum_infer_key key;                   /**< which */
    bool is_told;                        /**< the packets determine it; false:
                                              it keeps the default */
    const char *name;                    /**< of the key, such as "group.tag";
                                              a constant */
    char value[LUM_INFER_TEXT_BYTES];    /**< as written in the YAML, such as
                                              "{at: 12, bytes: 2}" */
    char evidence[LUM_INFER_TEXT_BYTES]; /**< why, in one line */
    char equal[LUM_INFER_TEXT_BYTES];    /**< what fits equally well; empty:
                                              nothing does */
    char look[LUM_INFER_TEXT_BYTES];     /**< how to check it; empty: no check
                                              is needed */
} lum_infer_finding;

/** From this margin on, a reading is ::LUM_INFER_FOUND. */
#define LUM_INFER_MARGIN_SURE 2.0

/** What was pushed: the sum of packets, other_type, control, foreign,
 * cut_short, left_out and elsewhere, with joined datagrams split. It is the
 * last member of the answer, and grows with that. */
typedef struct lum_infer_counts {
    uint32_t packets;    /**< datagrams that were examined: with the magic, of
                              the data's packet type */
    uint32_t other_type; /**< with the magic, maybe data, but not of the data's
                              type, or not 0 in bytes 9 to 11; all of them if
                              none has samples */
    uint32_t control;    /**< heartbeats, commands and answers, and bare
                              headers */
    uint32_t foreign;    /**< to or from port 5517, without the magic */
    uint32_t cut_short;  /**< datagrams that the capture has in part */
    uint32_t left_out;   /**< datagrams of sensors beyond 16, or pushed after it
                              had enough */
    uint32_t elsewhere;  /**< of another port or sensor than requested, or no
                              datagram; lumdump and Python add those of another
                              interface, which they do not push */
    uint32_t joined;     /**< datagrams that came joined with others by a
                              receiving host, until it had enough */
    uint32_t sensors;    /**< addresses that sent the examined datagrams */
    bool is_full;        /**< it had enough; later datagrams are only in
                              left_out and elsewhere */
} lum_infer_counts;

/** The answer. Filled in by lum_infer_solve(). */
typedef struct lum_infer_result {
    size_t struct_size; /**< sizeof(lum_infer_result), set by the caller */
    lum_infer_verdict verdict;  /**< the result */
    bool has_profile;           /**< profile is set: found or unsure */
    lum_profile profile;        /**< the best reading, valid */
    bool has_second;            /**< second is set */
    lum_profile second;         /**< the best reading that gives other points */
    double margin;              /**< the smallest of all keys: percentage points
                                     by which the field explains more than the
                                     best one that gives other values
                                     (docs/protocol.md, "The margin") */
    lum_infer_key margin_key;   /**< the key that it is of */
    uint32_t fit;               /**< of counts.packets, those that the profile
                                     decodes and whose samples agree with their
                                     tag, if there are enough to tell */
    char text[LUM_ERROR_BYTES]; /**< one line: what was found, what is missing,
                                     or which identity fails */
    size_t finding_count;       /**< of findings; 0 without a profile */
    lum_infer_finding findings[LUM_INFER_KEYS]; /**< by ::lum_infer_key */
    lum_infer_counts counts;                    /**< what was pushed */
} lum_infer_result;

/** Begin.
 * @param options copied.
 * @param out     to be freed with lum_infer_free(); NULL on failure.
 * @param error   may be NULL; gets the message on failure: struct_size is not
 *                set, packets_max is too large, or there is no memory.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_infer_create(const lum_infer_options *options,
                                    lum_infer **out, lum_error *error);

/** Take a record of a capture; joined datagrams are split, as by
 * lum_demux_push(). Records that are not a datagram to or from its port do no
 * harm.
 * @param record not kept; as much of its payload as is needed is copied.
 * @param error  may be NULL; gets the message on failure: there is no memory.
 * @return 1: more are wanted; 0: it has enough, and further datagrams are only
 *         counted; -1. */
LUM_MUST_CHECK int lum_infer_push(lum_infer *infer, const lum_record *record,
                                  lum_error *error);

/** Find the layout of what was pushed. May be called again after more.
 * @param out   the caller sets struct_size; the members within that size are
 *              overwritten.
 * @param error may be NULL; gets the message on failure: struct_size is not
 *              set, or there is no memory.
 * @return 0: a profile, found or unsure; 1: none, and the text of the result
 *         says why; -1. */
LUM_MUST_CHECK int lum_infer_solve(lum_infer *infer, lum_infer_result *out,
                                   lum_error *error);

/** Free it. NULL is allowed. */
void lum_infer_free(lum_infer *infer);

/** Bytes that hold any text of lum_infer_write_yaml(), with its NUL. */
#define LUM_INFER_YAML_BYTES 16384

/** The profile as YAML, with the evidence for each key as comments above it. It
 * can be loaded as it is.
 * @param result of lum_infer_solve(), with a profile.
 * @param out    room bytes, NUL-terminated if room is not 0; what does not fit
 *               is left out.
 * @return bytes of the whole text without the NUL; 0 if the result has no
 *         profile. */
size_t lum_infer_write_yaml(const lum_infer_result *result, char *out,
                            size_t room);

#ifdef __cplusplus
}
#endif

#endif
