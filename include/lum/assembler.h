/** @file
 * Data packets to lines and frames, under loss, repeats, reordering and
 * corruption (docs/protocol.md, section 6).
 *
 * One assembler serves one sensor, both eyes. There are no callbacks:
 * lum_assembler_push() returns an event *before* it consumes the packet. The
 * caller takes the line, or notes the frame, and pushes the same packet again.
 * Until then every other packet is refused with LUM_E_ORDER and counted, so an
 * `if` in place of this `while` is noticed at once:
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
 * Two assemblers in two threads need no lock. One assembler that two threads
 * use needs one. */
#ifndef LUM_ASSEMBLER_H
#define LUM_ASSEMBLER_H

#include "lum/clock.h"
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

/** How many slots an assembler needs: open_lines for each eye. */
#define LUM_ASSEMBLER_SLOTS(open_lines) (UINT32_C(2) * (open_lines))

/** How many words an assembler needs: those of a line for each slot. */
#define LUM_ASSEMBLER_WORDS(open_lines, words_per_line)                        \
    (LUM_ASSEMBLER_SLOTS(open_lines) * (words_per_line))

/** How many elements of lum_reach an assembler needs: reorder_lines for each
 * eye. */
#define LUM_ASSEMBLER_REACH(reorder_lines) (UINT32_C(2) * (reorder_lines))

/** The protocol's value of gap_us. */
#define LUM_GAP_US     100000u
#define LUM_GAP_US_END (UINT32_C(1) << 30) /**< gap_us is below it */

/** The constants of reassembly. */
typedef struct lum_assembler_config {
    uint8_t open_lines;      /**< of each eye, 1..LUM_OPEN_LINES_MAX; 4 */
    uint8_t reorder_lines;   /**< R, 1..LUM_REORDER_MAX; 8 */
    uint32_t words_per_line; /**< 1..LUM_LINE_WORDS_MAX; 16,384 */
    uint32_t gap_us;         /**< below LUM_GAP_US_END; LUM_GAP_US */
} lum_assembler_config;

/** What was seen and lost since lum_assembler_init(). A counter that has
 * reached its maximum stays there. */
typedef struct lum_assembly_counters {
    uint64_t stray;                /**< packets far from the stream's clock */
    uint64_t late;                 /**< packets of lines handed out already */
    uint64_t duplicate;            /**< packets whose samples had all come
                                        before */
    uint64_t conflict;             /**< packets with some samples that had come
                                        before */
    uint64_t no_room;              /**< packets whose words do not fit */
    uint64_t refused;              /**< calls answered with LUM_E_ORDER, and
                                        packets given up: errors of the caller,
                                        0 in correct code */
    uint64_t bad_words;            /**< words of accepted packets skipped */
    uint64_t lines;                /**< lines handed out */
    uint64_t lines_idle;           /**< of them closed as idle */
    uint64_t lines_missing_angles; /**< of them with fewer than 1000 */
    uint64_t lines_skipped;        /**< line numbers without any packet */
    uint64_t words;                /**< good words of lines handed out */
    uint64_t lost_words;           /**< words known to be lost; may be more */
    uint64_t frames; /**< distinct frames with lines; before the end, with open
                          lines too */
} lum_assembly_counters;

/** A line, as handed out. Everything it points to belongs to the assembler and
 * lives until the next push or flush. */
typedef struct lum_line {
    int64_t frame;           /**< frame number, 0 to 2^32 - 1; then 0 again */
    int64_t clock_us;        /**< extended sensor clock of its first packet */
    int64_t arrival;         /**< the arrival given with its first packet */
    const lum_angle *angles; /**< raw, of each pixel; 0 if unmarked */
    const uint32_t *angle_marks; /**< bit p % 32 of word p / 32: pixel p has
                                      angles */
    const uint32_t *words;       /**< by pixel, then in packet order */
    uint32_t word_count;         /**< how many */
    uint32_t lost_words;         /**< words known to be lost; may be more */
    uint32_t number;             /**< line number within the frame */
    uint16_t angle_count;        /**< pixels that have angles, 0..1000 */
    uint8_t eye;                 /**< an ::lum_eye */
} lum_line;

/** Whether a pixel of a line has angles; pixel < LUM_LINE_PIXELS. */
static inline bool lum_line_has_angles(const lum_line *line, uint32_t pixel)
{
    return ((line->angle_marks[pixel / 32u] >> (pixel % 32u)) & 1u) != 0;
}

/** Storage of one open line. Only its size is public. */
typedef struct lum_line_slot {
    lum_line line;                              /**< private */
    int64_t low_clock_us;                       /**< private */
    int64_t last_arrival;                       /**< private */
    struct lum_line_slot *next;                 /**< private */
    uint32_t *words;                            /**< private */
    uint32_t frame;                             /**< private */
    uint32_t accepted;                          /**< private */
    uint32_t words_seen;                        /**< private */
    uint32_t words_end;                         /**< private */
    uint32_t angle_marks[LUM_PIXEL_MARK_WORDS]; /**< private */
    lum_angle angles[LUM_LINE_PIXELS];          /**< private */
} lum_line_slot;

/** Storage for one line within the reach of reordering. Only its size is
 * public. */
typedef struct lum_reach {
    int64_t clock_us; /**< private: of a closed line, by lines.c */
    uint32_t number;  /**< private: of that line, by lines.c */
    uint32_t frame;   /**< private: one of the highest, by frames.c */
} lum_reach;

/* Flags and small numbers stand first, where small processors reach them with
 * one instruction. */

/** The clock of the sensor's packets. Private: only stream.c changes it. */
typedef struct lum_stream {
    uint32_t begun;  /**< private: a packet came since start or flush */
    lum_clock clock; /**< private */
} lum_stream;

/** The clock of one eye's packets. Private: only stream.c changes it. */
typedef struct lum_eye_stream {
    uint32_t seen;        /**< private: newest_us is a clock */
    int64_t newest_us;    /**< private: largest clock since the last break */
    int64_t heard_us;     /**< private: when it was last known to send */
    int64_t candidate_us; /**< private: of a stray that may prove a jump */
} lum_eye_stream;

/** Open and closed lines of one eye. Private: only lines.c changes it. */
typedef struct lum_eye_lines {
    uint8_t open_count;    /**< private */
    uint8_t closed_next;   /**< private: of reach, to be overwritten next */
    lum_line_slot *oldest; /**< private: the open line that closes first */
    lum_line_slot *unused; /**< private: where the next line opens */
    int64_t low_clock_us;  /**< private: what is older is late */
} lum_eye_lines;

/** Frame numbering of one eye. Private: only frames.c changes it. */
typedef struct lum_eye_frames {
    uint8_t straggling;    /**< private: lines that may still be of the frame
                                before, plus 1 */
    bool begun;            /**< private: frame and top are set */
    bool after_break;      /**< private: the next line begins a frame */
    uint32_t frame;        /**< private: the current one */
    uint32_t top;          /**< private: highest line of it */
    uint32_t previous_top; /**< private: highest line of the one before */
    uint32_t gap;          /**< private: lines below top that did not come */
} lum_eye_frames;

/** All of one eye. Private. */
typedef struct lum_eye_state {
    lum_eye_frames frames; /**< private */
    lum_reach *reach;      /**< private: reorder_lines of them */
    lum_eye_lines lines;   /**< private */
    lum_eye_stream stream; /**< private */
} lum_eye_state;

/** Which frames there are, of both eyes. Private: only frames.c changes it. */
typedef struct lum_frame_span {
    uint32_t announced; /**< private: one was announced, next only rises */
    uint32_t next;      /**< private: to be announced */
    uint32_t first;     /**< private: lowest of all lines, 1 or 0 */
    uint32_t highest;   /**< private: of all lines; 0 before the first */
} lum_frame_span;

/** The current packet; after an event, the one that must be pushed again.
 * Private. */
typedef struct lum_awaited {
    uint8_t step;     /**< private */
    uint8_t to_close; /**< private */
    lum_group group;  /**< private: set by an event; not its samples */
    uint64_t ticks;   /**< private */
    int64_t clock_us; /**< private */
    int64_t arrival;  /**< private */
} lum_awaited;

/** One sensor's assembler. Only its size is public. One with all bytes 0
 * refuses all calls. */
typedef struct lum_assembler {
    lum_assembler_config config;         /**< private */
    lum_awaited awaited;                 /**< private */
    const lum_line *line;                /**< private */
    uint32_t line_span_us;               /**< private */
    uint8_t angle_order;                 /**< private */
    lum_frame_span frames;               /**< private */
    lum_stream stream;                   /**< private */
    lum_eye_state eye[LUM_EYES];         /**< private */
    lum_assembly_counters counters;      /**< private */
    uint16_t placement[LUM_LINE_PIXELS]; /**< private: words.c's, all 0 */
} lum_assembler;

/** The constants that the protocol gives, for a computer: they need half a
 * megabyte. If your arrays are smaller, set open_lines and words_per_line to
 * what the arrays were made for. Cannot fail. */
void lum_assembler_config_default(lum_assembler_config *out);

/** The memory of an assembler, and how large it is. It need not be initialised.
 * Do not use it otherwise while the assembler is in use. */
typedef struct lum_assembler_storage {
    lum_line_slot *slots; /**< of open lines */
    uint32_t *words;      /**< range words of these lines */
    lum_reach *reach;     /**< for the reach of reordering */
    size_t slot_count;    /**< LUM_ASSEMBLER_SLOTS(open_lines) or more */
    size_t word_count;    /**< LUM_ASSEMBLER_WORDS(open_lines,
                               words_per_line) or more */
    size_t reach_count;   /**< LUM_ASSEMBLER_REACH(reorder_lines) or more */
} lum_assembler_storage;

/** An initialiser of a storage that consists of three arrays. If one of them is
 * a pointer, the size comes out too small, and lum_assembler_init() refuses
 * it. */
#define LUM_ASSEMBLER_STORAGE(slots, words, reach)                             \
    {                                                                          \
        (slots), (words), (reach), sizeof(slots) / sizeof((slots)[0]),         \
            sizeof(words) / sizeof((words)[0]),                                \
            sizeof(reach) / sizeof((reach)[0])                                 \
    }

/** Begin.
 *
 * @code
 * static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
 * static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, WORDS_PER_LINE)];
 * static lum_reach reach[LUM_ASSEMBLER_REACH(REORDER_LINES)];
 * const lum_assembler_storage storage =
 *     LUM_ASSEMBLER_STORAGE(slots, words, reach);
 *
 * lum_assembler_config_default(&config);
 * config.open_lines = OPEN_LINES;
 * config.reorder_lines = REORDER_LINES;
 * config.words_per_line = WORDS_PER_LINE;
 * @endcode
 *
 * @param a       caller-owned; written only on LUM_OK.
 * @param config  copied.
 * @param layout  the one that packets are decoded with; copied as far as
 *                needed.
 * @param storage copied; what it points to is kept, and written only on LUM_OK.
 * @return LUM_OK; LUM_E_VALUE if a constant is outside its range, or the linked
 *         layout file is made for another layout (docs/firmware-reference.md);
 *         LUM_E_SPACE if an array is shorter than config asks for.
 * Linear in open_lines and reorder_lines. */
LUM_MUST_CHECK lum_result lum_assembler_init(
    lum_assembler *a, const lum_assembler_config *config,
    const lum_layout *layout, const lum_assembler_storage *storage);

/** Take one data packet (docs/protocol.md, section 6).
 * @param group   a decoded packet; not kept.
 * @param arrival any number that never becomes smaller, such as the time of
 *                reception; may be 0. A line has the arrival of the packet that
 *                opened it, and lum_assembler_close_idle() compares with it.
 * @return LUM_OK: accepted.
 *         LUM_LINE_READY, LUM_FRAME_READY: an event, see above; push the same
 *         packet again.
 *         LUM_E_STRAY, LUM_E_LATE, LUM_E_DUPLICATE, LUM_E_CONFLICT,
 *         LUM_E_NO_ROOM: dropped and counted.
 *         LUM_E_ORDER: refused and counted, because the packet of the last
 *         event must be pushed first, or lum_assembler_init() was not called.
 *         LUM_E_VALUE: refused: an eye, tag or count of samples that
 *         lum_group_decode() never gives.
 * The time is linear in the packet's samples if they are in order and follow
 * all samples of the line. Otherwise it is also linear in the words of the line
 * (docs/firmware-reference.md has a bound). */
LUM_MUST_CHECK lum_result lum_assembler_push(lum_assembler *a,
                                             const lum_group *group,
                                             int64_t arrival);

/** Close idle lines: those whose last accepted packet had an arrival below
 * `before`. Without this call a line stays open until packets of newer lines
 * come, however long that takes. Call it until it returns LUM_OK. Later packets
 * of such a line are dropped as late.
 * @return LUM_LINE_READY; LUM_OK if no line is idle; LUM_E_ORDER, counted, if
 *         the packet of the last event must be pushed first, or
 *         lum_assembler_init() was not called. Linear in open_lines. */
LUM_MUST_CHECK lum_result lum_assembler_close_idle(lum_assembler *a,
                                                   int64_t before);

/** The end of the stream: close all lines. Call until it returns LUM_OK. After
 * that packets may come again, as after a jump of the clock: they begin a new
 * frame with a number above all that were announced. If the packet of the last
 * event was not pushed again, it is dropped and counted in refused.
 * @return LUM_LINE_READY or LUM_FRAME_READY, then LUM_OK; LUM_E_ORDER if
 *         lum_assembler_init() was not called. */
LUM_MUST_CHECK lum_result lum_assembler_flush(lum_assembler *a);

/** The line that LUM_LINE_READY announced last; NULL before the first.
 * @return valid, with all that it points to, until the next call of
 *         lum_assembler_push(), _flush() or _close_idle(). */
const lum_line *lum_assembler_line(const lum_assembler *a);

/** The frame that LUM_FRAME_READY announced. No line of it, or of a frame
 * before it, is open or expected. The exception is an eye that has sent nothing
 * for gap_us: its open lines come when it sends again, or at the flush. Frames
 * are announced in rising order, each once; 2^32 - 1 is followed by 0. */
int64_t lum_assembler_frame(const lum_assembler *a);

/** What was seen and lost so far. */
const lum_assembly_counters *lum_assembler_counters(const lum_assembler *a);

#ifdef __cplusplus
}
#endif

#endif
