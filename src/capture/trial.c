#include "trial.h"

#include "base/grow.h"
#include "core/field.h"
#include "lum/clock.h"

#include <string.h>

enum {
    HEAD_WORDS = 6, /* of 8 bytes, that a sum looks at */
    TAIL_WORDS = 2,

    /* Packets that prove another sensor, or the same one. Fewer may be damaged,
     * and angles alone may be alike. */
    ELSEWHERE_ENOUGH = 4,
    FOREIGN_MIN = 2,
    REPEATS_ENOUGH = 4,
    COMPARED_ENOUGH = 32,

    /* How far a clock may be from where the sensor's is by now: what arrivals
     * and their stamps are off by. */
    NEAR_US = 10000,
    DRIFT_OF = 10000, /* in a pause a clock drifts by less than one part */

    /* Those that came before one that is compared, if all are there. */
    COMPARED_BEFORE = 512,
    SETTLED_AFTER = 64, /* packets behind the newest: the clock was set back */

    /* Without a clock only so many packets are compared: less than a frame. */
    CLOCKLESS_PACKETS = 64
};

/* Until then the sensor has come to where a clock that is near may be ahead. */
#define COMPARED_NS ((int64_t)2 * NEAR_US * 1000)

/* --- What was sent of late --- */

static uint64_t mix(uint64_t sum, uint64_t word)
{
    sum = (sum ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return sum ^ sum >> 32;
}

static uint64_t sum_of(const uint8_t *p, size_t len)
{
    const size_t words = len / sizeof(uint64_t);
    const size_t head = words < HEAD_WORDS ? words : HEAD_WORDS;
    const size_t tail = words < TAIL_WORDS ? words : TAIL_WORDS;
    uint64_t sum = len;
    uint64_t word = 0;
    for (size_t i = 0; i < head; i++) {
        memcpy(&word, p + i * sizeof word, sizeof word);
        sum = mix(sum, word);
    }
    for (size_t i = 1; i <= tail; i++) {
        memcpy(&word, p + len - i * sizeof word, sizeof word);
        sum = mix(sum, word);
    }
    return sum;
}

lum_seen lum_seen_of(const lum_record *record, const lum_group *group)
{
    return (lum_seen){.sum = sum_of(record->payload, record->len),
                      .clock = group->clock_raw,
                      .line = group->line,
                      .first = group->first_sample_index,
                      .eye = group->eye,
                      .tag = group->tag};
}

void lum_recent_note(lum_recent *recent, const lum_seen *seen, int64_t time_ns,
                     uint64_t record)
{
    if (recent->next == 0) {
        recent->since = recent->count == 0 ? record : recent->turn;
        recent->turn = record;
    }
    recent->seen[recent->next] = *seen;
    recent->next = (recent->next + 1u) % LUM_RECENT_PACKETS;
    recent->count += recent->count < LUM_RECENT_PACKETS;
    recent->time_ns = time_ns;
}

void lum_recent_interrupt(lum_recent *recent)
{
    recent->count = 0;
    recent->next = 0;
    recent->lacks_earlier = true;
}

bool lum_recent_is_whole(const lum_recent *recent)
{
    return !recent->lacks_earlier || recent->count == LUM_RECENT_PACKETS;
}

/* The i-th from the last one on, which is 0. */
static const lum_seen *recent_at(const lum_recent *recent, uint32_t i)
{
    return &recent->seen[(recent->next + LUM_RECENT_PACKETS - 1u - i) %
                         LUM_RECENT_PACKETS];
}

lum_measure lum_measure_of(const lum_profile *profile, uint32_t gap_us,
                           uint32_t reorder_lines)
{
    const lum_field *field = &profile->group[LUM_FIELD_TIMESTAMP];
    return (lum_measure){.clock_bits = clock_bits(field),
                         .clock_unit_ns = profile->clock_unit_ns,
                         .line_span_us = profile->line_span_us,
                         .gap_us = gap_us,
                         .reorder_lines = reorder_lines};
}

int64_t lum_measure_us(const lum_measure *measure, uint64_t from, uint64_t to)
{
    return lum_clock_us(lum_clock_extend(0, to - from, measure->clock_bits),
                        measure->clock_unit_ns);
}

static uint64_t size_of(int64_t us)
{
    return us < 0 ? 0u - (uint64_t)us : (uint64_t)us;
}

static bool is_same_place(const lum_seen *a, const lum_seen *b)
{
    return a->eye == b->eye && a->tag == b->tag && a->line == b->line &&
           a->first == b->first;
}

static bool is_within_line(const lum_measure *m, const lum_seen *a,
                           const lum_seen *b)
{
    return size_of(lum_measure_us(m, a->clock, b->clock)) <= m->line_span_us;
}

/* ahead: how far the one that is looked at is ahead of a line, by its clock. */
static void take_neighbour(lum_place_among *place, uint32_t line, int64_t ahead)
{
    const uint64_t away = size_of(ahead) + 1u;
    if (ahead >= 0 && (place->to_before == 0 || away < place->to_before)) {
        place->to_before = away;
        place->before = line;
    }
    if (ahead <= 0 && (place->to_after == 0 || away < place->to_after)) {
        place->to_after = away;
        place->after = line;
    }
}

/* One of the sensor's packets is looked at. */
static void look(lum_place_among *place, const lum_measure *m,
                 const lum_seen *seen, const lum_seen *other)
{
    if (seen->eye != other->eye || !is_within_line(m, seen, other)) {
        return;
    }
    if (is_same_place(seen, other)) {
        place->stand = LUM_STAND_ELSEWHERE;
    }
    take_neighbour(place, other->line,
                   lum_measure_us(m, other->clock, seen->clock));
}

static bool is_near_line(const lum_measure *m, uint32_t a, uint32_t b)
{
    return size_of((int64_t)a - (int64_t)b) <= m->reorder_lines;
}

/* Numbers rise, but for the step to the next frame. */
static bool is_between(uint32_t line, uint32_t before, uint32_t after)
{
    return before <= after ? line >= before && line <= after
                           : line >= before || line <= after;
}

lum_stand lum_place_stand(const lum_place_among *place,
                          const lum_measure *measure, const lum_seen *seen)
{
    const bool has_clock = measure->clock_bits != 0;
    if (place->stand != LUM_STAND_FITS) {
        return place->stand;
    }
    if (place->to_before == 0 || place->to_after == 0) {
        return LUM_STAND_AHEAD;
    }
    return (has_clock ? is_between(seen->line, place->before, place->after)
                      : is_near_line(measure, seen->line, place->before))
               ? LUM_STAND_FITS
               : LUM_STAND_ASTRAY;
}

static bool is_remembered(const lum_recent *recent, const lum_seen *seen)
{
    for (uint32_t i = 0; i < recent->count; i++) {
        if (recent_at(recent, i)->sum == seen->sum) {
            return true;
        }
    }
    return false;
}

/* What the clock says; LUM_STAND_FITS: it is near. */
static lum_stand judge_clock(const lum_recent *recent, const lum_measure *m,
                             const lum_seen *seen, int64_t time_ns)
{
    const int64_t passed_ns = time_ns - recent->time_ns;
    const uint64_t passed_us = size_of(passed_ns / 1000);
    const bool is_next = passed_ns > (int64_t)m->gap_us * 1000;
    const uint64_t limit_us =
        is_next ? m->gap_us + passed_us / DRIFT_OF : (uint64_t)NEAR_US;
    const uint64_t ticks = (uint64_t)(passed_ns / (int64_t)m->clock_unit_ns);
    const uint64_t expected = recent_at(recent, 0)->clock + ticks;
    if (size_of(lum_measure_us(m, expected, seen->clock)) > limit_us) {
        return LUM_STAND_ELSEWHERE;
    }
    return is_next ? LUM_STAND_NEXT : LUM_STAND_FITS;
}

lum_place_among lum_recent_place(const lum_recent *recent,
                                 const lum_measure *measure,
                                 const lum_seen *seen, int64_t time_ns)
{
    const uint32_t most = measure->clock_bits != 0
                              ? LUM_RECENT_PACKETS
                              : (uint32_t)CLOCKLESS_PACKETS;
    lum_place_among place = {.stand = LUM_STAND_FITS};
    if (recent->count == 0) {
        return place;
    }
    place.stand = is_remembered(recent, seen)
                      ? LUM_STAND_REPEAT
                      : judge_clock(recent, measure, seen, time_ns);
    for (uint32_t i = 0;
         i < recent->count && i < most && place.stand == LUM_STAND_FITS; i++) {
        look(&place, measure, seen, recent_at(recent, i));
    }
    return place;
}

/* Several lines may have one coarse clock. */
static bool is_near_at_once(const lum_place_among *place, const lum_measure *m,
                            const lum_seen *seen)
{
    return (place->to_before == 1u &&
            is_near_line(m, seen->line, place->before)) ||
           (place->to_after == 1u && is_near_line(m, seen->line, place->after));
}

static void compare(lum_place_among *place, const lum_seen *seen,
                    const lum_seen *other, int64_t ticks, int64_t span)
{
    if (other->line == seen->line) {
        if (other->first == seen->first && other->tag == seen->tag &&
            other->sum != seen->sum && ticks <= span && -ticks <= span) {
            place->stand = LUM_STAND_ELSEWHERE;
        }
        return;
    }
    take_neighbour(place, other->line, -ticks);
}

/* With newer packets (step -1) or older ones (1): all that have one clock, or
 * clocks of two sensors in turn, up to where it was set back for good. In ticks
 * instead of us, as thousands are compared. */
static void compare_from(lum_place_among *place, const lum_recent *recent,
                         const lum_measure *m, uint32_t at, int step)
{
    const lum_seen *seen = recent_at(recent, at);
    const unsigned shift = 64u - m->clock_bits;
    const int64_t scale = (int64_t)1 << shift;
    const int64_t span = (int64_t)m->line_span_us * 1000 / m->clock_unit_ns;
    int64_t edge = 0;
    uint32_t behind = 0;
    for (uint32_t i = at + (uint32_t)step;
         i < recent->count && behind < SETTLED_AFTER; i += (uint32_t)step) {
        const lum_seen *other = recent_at(recent, i);
        const int64_t ticks =
            (int64_t)((other->clock - seen->clock) << shift) / scale;
        const bool is_on = step < 0 ? ticks >= edge : ticks <= edge;
        behind = is_on ? 0 : behind + 1u;
        edge = is_on ? ticks : edge;
        if (other->eye == seen->eye) {
            compare(place, seen, other, ticks, span);
        }
    }
}

bool lum_recent_contradicts(const lum_recent *recent,
                            const lum_measure *measure)
{
    lum_place_among place = {.stand = LUM_STAND_FITS};
    if (measure->clock_bits == 0 || recent->count == 0) {
        return false;
    }
    /* those of another clock came before it, or, as likely, after it */
    const uint32_t at = recent->count < LUM_RECENT_PACKETS
                            ? recent->count / 2u
                            : recent->count - COMPARED_BEFORE;
    const lum_seen *seen = recent_at(recent, at);
    compare_from(&place, recent, measure, at, -1);
    compare_from(&place, recent, measure, at, 1);
    return !is_near_at_once(&place, measure, seen) &&
           lum_place_stand(&place, measure, seen) >= LUM_STAND_ASTRAY;
}

/* --- Trials --- */

void lum_trial_add(lum_trial *trial, const lum_seen *seen,
                   const lum_place_among *place, int64_t time_ns)
{
    trial->begin_ns = trial->count == 0 ? time_ns : trial->begin_ns;
    trial->seen[trial->count] = *seen;
    trial->place[trial->count] = *place;
    trial->count++;
}

void lum_trial_meet(lum_trial *trial, const lum_measure *measure,
                    const lum_seen *seen)
{
    for (size_t i = 0; i < trial->count; i++) {
        lum_place_among *place = &trial->place[i];
        if (trial->seen[i].sum == seen->sum) {
            place->stand = LUM_STAND_REPEAT;
        } else if (place->stand == LUM_STAND_FITS) {
            look(place, measure, &trial->seen[i], seen);
        }
    }
}

struct tally {
    size_t of[LUM_STAND_ELSEWHERE + 1];
    size_t ranges;
    size_t range_repeats;
};

static struct tally count(const lum_trial *t, const lum_measure *m)
{
    struct tally n = {.range_repeats = 0};
    for (size_t i = 0; i < t->count; i++) {
        const bool has_ranges = t->seen[i].tag == LUM_TAG_RANGES;
        const lum_stand stand = lum_place_stand(&t->place[i], m, &t->seen[i]);
        n.of[stand]++;
        n.ranges += has_ranges;
        n.range_repeats += has_ranges && stand == LUM_STAND_REPEAT;
    }
    return n;
}

/* Another sensor's: 2 or more, and a quarter of those whose place is known,
 * stand elsewhere or astray. Repeated ranges, 4 and a quarter of all, outweigh
 * that. */
static lum_verdict settle(const lum_trial *trial, const struct tally *n)
{
    const size_t foreign = n->of[LUM_STAND_ASTRAY] + n->of[LUM_STAND_ELSEWHERE];
    const bool is_proven = n->range_repeats >= REPEATS_ENOUGH &&
                           4u * n->range_repeats >= n->ranges;
    const size_t placed = trial->count - n->of[LUM_STAND_AHEAD];
    return !is_proven && foreign >= FOREIGN_MIN && 4u * foreign >= placed
               ? LUM_VERDICT_OWN
               : LUM_VERDICT_SAME;
}

lum_verdict lum_trial_settle(const lum_trial *trial, const lum_measure *measure)
{
    const struct tally n = count(trial, measure);
    return settle(trial, &n);
}

/* Over when the sensor goes on, or 4 repeat it and none stands elsewhere, or
 * the first 4 all do; else after 32 whose place is known and 20 ms, or 2,048
 * packets, or 1 s. */
lum_verdict lum_trial_judge(const lum_trial *trial, const lum_measure *measure,
                            int64_t now_ns)
{
    const struct tally n = count(trial, measure);
    const size_t elsewhere = n.of[LUM_STAND_ELSEWHERE];
    const int64_t passed_ns = now_ns - trial->begin_ns;
    const size_t placed = trial->count - n.of[LUM_STAND_AHEAD];
    const bool is_own = elsewhere >= ELSEWHERE_ENOUGH && elsewhere == placed;
    const bool is_same =
        elsewhere == 0 &&
        (n.of[LUM_STAND_NEXT] > 0 ||
         (n.of[LUM_STAND_REPEAT] >= REPEATS_ENOUGH && n.range_repeats > 0));
    const bool is_over = trial->count == LUM_TRIAL_PACKETS ||
                         passed_ns > LUM_TRIAL_NS ||
                         (placed >= COMPARED_ENOUGH && passed_ns > COMPARED_NS);
    return is_own || is_same || is_over ? settle(trial, &n) : LUM_VERDICT_OPEN;
}

/* --- Packets that are held --- */

bool lum_queue_add(lum_queue *queue, const lum_record *record, size_t way)
{
    lum_queue *q = queue;
    uint8_t *bytes = lum_grown(q->bytes, q->used, record->len, 1, &q->room);
    if (bytes == NULL) {
        return false;
    }
    q->bytes = bytes;
    memcpy(q->bytes + q->used, record->payload, record->len);
    q->held[q->count++] = (struct lum_held){.time_ns = record->time_ns,
                                            .at = q->used,
                                            .len = record->len,
                                            .way = way};
    q->used += record->len;
    return true;
}

bool lum_queue_is_full(const lum_queue *queue)
{
    return queue->count == LUM_QUEUE_PACKETS || queue->used >= LUM_QUEUE_BYTES;
}

bool lum_queue_take(lum_queue *queue, lum_record *out, size_t *way)
{
    if (queue->next == queue->count) {
        queue->next = 0;
        queue->count = 0;
        queue->used = 0;
        return false;
    }
    const struct lum_held *h = &queue->held[queue->next++];
    *out = (lum_record){
        .time_ns = h->time_ns, .payload = queue->bytes + h->at, .len = h->len};
    *way = h->way;
    return true;
}
