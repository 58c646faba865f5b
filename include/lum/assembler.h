/** @file
 * Data packets to lines and frames, under loss, repeats, reordering and
 * corruption (docs/protocol.md, section 6).
 *
 * One assembler serves one sensor, both eyes. It calls nobody: an event is
 * returned by lum_assembler_push() *before* the packet at hand is consumed; the
 * caller takes the line, or notes the frame, and pushes the same packet again.
 *
 * @code
 * lum_result r;
 * while ((r = lum_assembler_push(&a, &group, arrival)) > 0) {
 *     if (r == LUM_LINE_READY) {
 *         use(lum_assembler_line(&a));
 *     }
 * }
 * @endcode
 *
 * Two assemblers in two threads need no lock; one assembler in two does. */
#ifndef LUM_ASSEMBLER_H
#define LUM_ASSEMBLER_H

#include "lum/group.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LUM_OPEN_LINES_MAX 16u    /**< most open lines of an eye */
#define LUM_REORDER_MAX    32u    /**< largest reach of reordering, in lines */
#define LUM_LINE_WORDS_MAX 32768u /**< most words of a line */

/** 32-bit words of a mark for each pixel. */
#define LUM_PIXEL_MARK_WORDS ((LUM_LINE_PIXELS + 31u) / 32u)

/** How many slots lum_assembler_init() takes: open_lines for each eye. */
#define LUM_ASSEMBLER_SLOTS(open_lines) (UINT32_C(2) * (open_lines))

/** How many words lum_assembler_init() takes. */
#define LUM_ASSEMBLER_WORDS(open_lines, words_per_line)                        \
    (LUM_ASSEMBLER_SLOTS(open_lines) * (words_per_line))

/** The constants of reassembly. open_lines and words_per_line say how large the
 * arrays are that lum_assembler_init() is given. */
typedef struct lum_assembler_config {
    uint8_t open_lines;      /**< of each eye, 1..LUM_OPEN_LINES_MAX; 4 */
    uint8_t reorder_lines;   /**< R, 1..LUM_REORDER_MAX; 8 */
    uint32_t words_per_line; /**< 1..LUM_LINE_WORDS_MAX; 16,384 */
    uint32_t gap_us;         /**< below 2^30; 100,000 */
} lum_assembler_config;

/** What was seen and lost since lum_assembler_init(); none ever wraps. */
typedef struct lum_assembly_counters {
    uint64_t late;                 /**< packets of lines handed out already */
    uint64_t duplicate;            /**< packets all of which was there */
    uint64_t conflict;             /**< packets some of which was there */
    uint64_t no_room;              /**< packets whose words do not fit */
    uint64_t stray;                /**< packets far from the stream's clock */
    uint64_t bad_words;            /**< words of accepted packets skipped */
    uint64_t lines;                /**< lines handed out */
    uint64_t lines_missing_angles; /**< of them with fewer than 1000 */
    uint64_t lines_skipped;        /**< line numbers nobody heard of */
    uint64_t words;                /**< good words of lines handed out */
    uint64_t lost_words;           /**< words known to be lost, from below */
    uint64_t frames; /**< distinct frames of lines handed out; before
                          the end, those between them too */
} lum_assembly_counters;

/** A line, as handed out. Everything it points to belongs to the assembler and
 * lives until the next push or flush. */
typedef struct lum_line {
    int64_t frame;           /**< frame number; a label, can be 0 or less */
    int64_t clock_us;        /**< extended sensor clock of its first packet */
    int64_t arrival;         /**< what came with its first packet */
    const lum_angle *angles; /**< raw, of each pixel; 0 if unmarked */
    const uint32_t *angle_marks; /**< bit p % 32 of word p / 32: pixel p has
                                      angles */
    const uint32_t *words;       /**< by pixel, then as in their packet */
    uint32_t word_count;         /**< how many */
    uint32_t lost_words;         /**< of this line, from below */
    uint32_t number;             /**< line number within the frame */
    uint16_t angle_count;        /**< pixels that have angles, 0..1000 */
    uint8_t eye;                 /**< an ::lum_eye */
} lum_line;

/** Whether a pixel of a line has angles; pixel < LUM_LINE_PIXELS. */
static inline bool lum_line_has_angles(const lum_line *line, uint32_t pixel)
{
    return ((line->angle_marks[pixel / 32u] >> (pixel % 32u)) & 1u) != 0;
}

/** Storage of one open line. Private but in size. */
typedef struct lum_line_slot {
    lum_line line;                              /**< private */
    int64_t low_clock_us;                       /**< private */
    struct lum_line_slot *next;                 /**< private */
    uint32_t *words;                            /**< private */
    uint32_t accepted;                          /**< private */
    uint32_t words_seen;                        /**< private */
    uint32_t words_end;                         /**< private */
    uint32_t angle_marks[LUM_PIXEL_MARK_WORDS]; /**< private */
    lum_angle angles[LUM_LINE_PIXELS];          /**< private */
} lum_line_slot;

/** Number and clock of a line that was handed out. Private. */
typedef struct lum_closed_line {
    int64_t clock_us; /**< private */
    uint32_t number;  /**< private */
} lum_closed_line;

/** Reassembly and frame numbering of one eye. Private. */
typedef struct lum_eye_state {
    uint8_t open_count;                      /**< private */
    uint8_t closed_next;                     /**< private */
    uint8_t closed_count;                    /**< private */
    uint8_t straggling;                      /**< private */
    bool seen;                               /**< private */
    bool begun;                              /**< private */
    bool after_break;                        /**< private */
    lum_line_slot *oldest;                   /**< private */
    lum_line_slot *unused;                   /**< private */
    uint32_t top;                            /**< private */
    uint32_t previous_top;                   /**< private */
    uint32_t gap;                            /**< private */
    int64_t frame;                           /**< private */
    int64_t newest_us;                       /**< private */
    int64_t heard_us;                        /**< private */
    int64_t candidate_us;                    /**< private */
    int64_t low_clock_us;                    /**< private */
    lum_closed_line closed[LUM_REORDER_MAX]; /**< private */
    int64_t highest[LUM_REORDER_MAX];        /**< private */
} lum_eye_state;

/** One sensor's assembler. Public in size, private in content. */
typedef struct lum_assembler {
    lum_assembler_config config;         /**< private */
    uint32_t line_span_us;               /**< private */
    uint8_t stage;                       /**< private */
    uint8_t to_close;                    /**< private */
    uint8_t clock_bytes;                 /**< private */
    uint8_t angle_order;                 /**< private */
    bool clock_begun;                    /**< private */
    bool announced;                      /**< private */
    const lum_line *line;                /**< private */
    int64_t clock_us;                    /**< private */
    int64_t packet_clock_us;             /**< private */
    int64_t next_frame;                  /**< private */
    int64_t highest_frame;               /**< private */
    int64_t handed_low;                  /**< private */
    int64_t handed_high;                 /**< private */
    lum_assembly_counters counters;      /**< private */
    lum_eye_state eye[LUM_EYES];         /**< private */
    uint16_t placement[LUM_LINE_PIXELS]; /**< private */
} lum_assembler;

/** The constants as the protocol gives them, for a computer: they ask for half
 * a megabyte. Where the arrays are smaller, set open_lines and words_per_line
 * to what the arrays were made for. Cannot fail. */
void lum_assembler_config_default(lum_assembler_config *out);

/** Begin. Sizes of arrays are not known to it: it writes to as much of slots
 * and words as config says. So set config's open_lines and words_per_line
 * before, from the same constants as the arrays:
 *
 * @code
 * static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
 * static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, WORDS_PER_LINE)];
 *
 * lum_assembler_config_default(&config);
 * config.open_lines = OPEN_LINES;
 * config.words_per_line = WORDS_PER_LINE;
 * @endcode
 *
 * @param a      caller-owned, overwritten.
 * @param config copied.
 * @param layout copied; its line_span_us is used.
 * @param slots  LUM_ASSEMBLER_SLOTS(open_lines) of them; the assembler's until
 *               it is no longer used. Need not be initialised.
 * @param words  LUM_ASSEMBLER_WORDS(open_lines, words_per_line) of them;
 *               likewise.
 * @return LUM_OK; LUM_E_VALUE if a constant is outside its range. */
LUM_MUST_CHECK lum_result lum_assembler_init(lum_assembler *a,
                                             const lum_assembler_config *config,
                                             const lum_layout *layout,
                                             lum_line_slot *slots,
                                             uint32_t *words);

/** Take one data packet.
 * @param group   decoded with the same layout, so that its eye is one; not
 *                kept. After an event only the same packet may follow, or
 *                lum_assembler_flush().
 * @param arrival anything, such as a time of reception; the line that this
 *                packet opens is handed out with it.
 * @return LUM_OK: accepted. LUM_LINE_READY, LUM_FRAME_READY: an event, see
 *         above; push the same packet again. LUM_E_STRAY, LUM_E_LATE,
 *         LUM_E_DUPLICATE, LUM_E_CONFLICT, LUM_E_NO_ROOM: dropped and counted.
 * Linear in the packet's samples where they are in order and behind those of
 * the line, else in the words of the line too. */
LUM_MUST_CHECK lum_result lum_assembler_push(lum_assembler *a,
                                             const lum_group *group,
                                             int64_t arrival);

/** The end of the stream: close all lines. Call until it returns LUM_OK; after
 * that only lum_assembler_counters() may be called.
 * @return LUM_LINE_READY or LUM_FRAME_READY, then LUM_OK. */
LUM_MUST_CHECK lum_result lum_assembler_flush(lum_assembler *a);

/** The line that LUM_LINE_READY announced.
 * @return lives, with all it points to, until the next push or flush. */
const lum_line *lum_assembler_line(const lum_assembler *a);

/** The frame that LUM_FRAME_READY announced: no line of it, nor of one before
 * it, is open or expected, but for those of an eye that has been silent for
 * gap_us; what such an eye left open comes when it speaks again or at the
 * flush. Frames are announced in rising order, each once. */
int64_t lum_assembler_frame(const lum_assembler *a);

/** What was seen and lost so far. */
const lum_assembly_counters *lum_assembler_counters(const lum_assembler *a);

#ifdef __cplusplus
}
#endif

#endif
