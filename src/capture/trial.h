/** @file
 * Whether two interfaces of a capture bring the data of one sensor or of two
 * that have one address (docs/protocol.md, section 9). Internal.
 *
 * What a sensor sent of late is remembered. The data of its address on another
 * interface is on trial: it is compared with that, packet by packet, and all
 * data of the address is held meanwhile, so that whatever comes out, it goes on
 * in the order in which it came. */
#ifndef LUM_CAPTURE_TRIAL_H
#define LUM_CAPTURE_TRIAL_H

#include "lum/capture/record.h"
#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** How many packets of a sensor are remembered: of 45 ms at 640 lines. */
#define LUM_RECENT_PACKETS 4096u

/** Most packets of a trial. */
#define LUM_TRIAL_PACKETS 2048u

/** How long one lasts, in capture time. */
#define LUM_TRIAL_NS INT64_C(1000000000)

/** Most packets that are held, and most of their bytes but for the last. */
#define LUM_QUEUE_PACKETS 4096u
#define LUM_QUEUE_BYTES   ((size_t)8 * 1024 * 1024)

/** A packet as it is remembered. */
typedef struct lum_seen {
    uint64_t sum;   /**< tells packets apart: of the length, the headers, and
                         samples at the start and the end */
    uint64_t clock; /**< as sent */
    uint32_t line;
    uint32_t first; /**< sample index */
    uint8_t eye;
    uint8_t tag;
} lum_seen;

/** A data packet. */
lum_seen lum_seen_of(const lum_record *record, const lum_group *group);

/** What a sensor sent of late. All bytes 0: nothing. */
typedef struct lum_recent {
    lum_seen seen[LUM_RECENT_PACKETS];
    uint32_t count; /**< at most LUM_RECENT_PACKETS */
    uint32_t next;
    int64_t time_ns;    /**< of the last one */
    uint64_t since;     /**< the number of a record: no packet of one before it
                             is remembered */
    uint64_t turn;      /**< that of the packet in the first place */
    bool lacks_earlier; /**< packets before the first one are not known */
} lum_recent;

/** Remember a packet.
 * @param record the number of its record, which never falls. */
void lum_recent_note(lum_recent *recent, const lum_seen *seen, int64_t time_ns,
                     uint64_t record);

/** Forget them: records were passed over. */
void lum_recent_interrupt(lum_recent *recent);

/** Whether it has all that it would have without an interruption. */
bool lum_recent_is_whole(const lum_recent *recent);

/** How a packet stands to those of a sensor; of several sensors the lowest one
 * counts. */
typedef enum lum_stand {
    LUM_STAND_REPEAT,   /**< it is one of them */
    LUM_STAND_NEXT,     /**< the sensor goes on with it after a pause */
    LUM_STAND_FITS,     /**< its line is that of this time */
    LUM_STAND_AHEAD,    /**< there are no lines before or behind it yet */
    LUM_STAND_ASTRAY,   /**< the sensor has other lines at this time */
    LUM_STAND_ELSEWHERE /**< its clock is not where the sensor's is, or it has
                             other bytes in the same place */
} lum_stand;

/** What decides how packets stand. */
typedef struct lum_measure {
    unsigned clock_bits; /**< that go round; 0: there is no clock */
    uint32_t clock_unit_ns;
    uint32_t line_span_us;
    uint32_t gap_us;
    uint32_t reorder_lines;
} lum_measure;

/** Of a profile. */
lum_measure lum_measure_of(const lum_profile *profile, uint32_t gap_us,
                           uint32_t reorder_lines);

/** The time from one clock to another, of those that are a wrap apart the
 * nearest. */
int64_t lum_measure_us(const lum_measure *measure, uint64_t from, uint64_t to);

/** Where a packet stands among a sensor's: the lines next to it in time, of its
 * eye. All bytes 0: none is known. */
typedef struct lum_place_among {
    uint64_t to_before; /**< how far its clock is, plus 1; 0: there is none */
    uint64_t to_after;
    uint32_t before; /**< its line */
    uint32_t after;
    lum_stand stand; /**< what the lines do not decide; else LUM_STAND_FITS */
} lum_place_among;

/** Find where it stands. */
lum_place_among lum_recent_place(const lum_recent *recent,
                                 const lum_measure *measure,
                                 const lum_seen *seen, int64_t time_ns);

/** How it stands there. */
lum_stand lum_place_stand(const lum_place_among *place,
                          const lum_measure *measure, const lum_seen *seen);

/** Whether one that is remembered cannot be of the sensor that sent those next
 * to it in time: its line is not between theirs, or it is another packet of the
 * same place. Not without a clock. */
bool lum_recent_contradicts(const lum_recent *recent,
                            const lum_measure *measure);

/** A trial. All bytes 0: it begins. */
typedef struct lum_trial {
    lum_seen seen[LUM_TRIAL_PACKETS];
    lum_place_among place[LUM_TRIAL_PACKETS];
    size_t count;
    int64_t begin_ns;
} lum_trial;

/** A packet that is on trial. */
void lum_trial_add(lum_trial *trial, const lum_seen *seen,
                   const lum_place_among *place, int64_t time_ns);

/** The sensor sends a packet now, which may be one that was on trial, or stand
 * against one. */
void lum_trial_meet(lum_trial *trial, const lum_measure *measure,
                    const lum_seen *seen);

/** What a trial came to. */
typedef enum lum_verdict {
    LUM_VERDICT_OPEN, /**< it goes on */
    LUM_VERDICT_SAME, /**< it is the same sensor */
    LUM_VERDICT_OWN   /**< it is another one */
} lum_verdict;

/** What it came to so far. */
lum_verdict lum_trial_judge(const lum_trial *trial, const lum_measure *measure,
                            int64_t now_ns);

/** What it comes to if it ends here: not LUM_VERDICT_OPEN. */
lum_verdict lum_trial_settle(const lum_trial *trial,
                             const lum_measure *measure);

/** Packets that are held, in the order in which they came. All bytes 0: none.
 */
typedef struct lum_queue {
    struct lum_held {
        int64_t time_ns;
        size_t at; /**< of its bytes */
        size_t len;
        size_t way; /**< the number that the caller gave */
    } held[LUM_QUEUE_PACKETS];
    size_t count;
    size_t next;
    uint8_t *bytes; /**< allocated */
    size_t used;
    size_t room;
} lum_queue;

/** Hold a packet, which is copied; there are fewer than LUM_QUEUE_PACKETS.
 * @return false without memory. */
LUM_MUST_CHECK bool lum_queue_add(lum_queue *queue, const lum_record *record,
                                  size_t way);

/** Whether no more fits. */
bool lum_queue_is_full(const lum_queue *queue);

/** Take the first one out.
 * @param out gets payload and time; its payload lives until one is added.
 * @return false: there is none. */
bool lum_queue_take(lum_queue *queue, lum_record *out, size_t *way);

#endif
