/* The arrivals that a fit keeps: readings come in one by one; the earliest of
 * each span go out, and by how much the truth may be later than a line. */
#include "clock_line.h"

/* Arrivals that differ by less than this count as equally late. */
#define SAME_NS 10000

/* Stamps may be rounded once more, to a whole microsecond. */
#define SECOND_NS INT64_C(1000000000)
#define ROUND_NS  1000

/* What the host's clock may gain on a line: 500 ppm when it is slewed, and what
 * its crystal wanders. */
#define GAIN_PPB INT64_C(600000)

/* So many batches do not all come late. */
#define BATCHES_MANY 8u

/* --- The resolution of stamps --- */

static bool is_multiple(int64_t ns, uint32_t halvings)
{
    const int64_t above = ns * (INT64_C(1) << halvings) % SECOND_NS;
    const int64_t off = above < SECOND_NS - above ? above : SECOND_NS - above;
    return off >> halvings <= ROUND_NS;
}

static int64_t common_divisor(int64_t a, int64_t b)
{
    while (b != 0) {
        const int64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

void lum_clock_arrivals_note_stamp(struct lum_clock_arrivals *a,
                                   int64_t arrival_ns)
{
    struct lum_clock_stamps *s = &a->stamps;
    const int64_t rest = arrival_ns % SECOND_NS;
    const int64_t ns = rest < 0 ? rest + SECOND_NS : rest;
    const int64_t us = (ns + 500) / 1000;
    s->step_us = common_divisor(
        s->step_us != 0 ? s->step_us : LUM_CLOCK_STEP_MAX_US, us);
    while (s->halvings < LUM_CLOCK_HALVINGS && !is_multiple(ns, s->halvings)) {
        s->halvings++;
    }
}

/* If the lines come in such steps themselves, as each 5 ms, the stamps need not
 * be coarser than their digits. */
static int64_t step_of(const struct lum_clock_stamps *s)
{
    int64_t step_us = 1;
    if (s->lines_us == 0 || s->step_us == 0 || s->lines_us % s->step_us != 0) {
        return s->step_us;
    }
    while (s->step_us % (step_us * 10) == 0) {
        step_us *= 10;
    }
    return step_us;
}

int64_t lum_clock_arrivals_resolution(const struct lum_clock_arrivals *a)
{
    const struct lum_clock_stamps *s = &a->stamps;
    const int64_t halved =
        s->halvings < LUM_CLOCK_HALVINGS ? SECOND_NS >> s->halvings : 0;
    const int64_t step_ns = step_of(s) * 1000;
    return step_ns > halved ? step_ns : halved;
}

/* --- The earliest of a span --- */

static int64_t widest_gap(const struct lum_clock_earliest *e)
{
    int64_t gap_ns = 0;
    for (uint32_t i = 1; i < e->count; i++) {
        const int64_t ns = e->late_ns[i] - e->late_ns[i - 1u];
        gap_ns = ns > gap_ns ? ns : gap_ns;
    }
    return gap_ns;
}

/* Note an arrival of the span. Returns the widest gap among the earliest. */
static int64_t note_lateness(struct lum_clock_earliest *e, int64_t late_ns)
{
    uint32_t i = 0;
    while (i < e->count && late_ns >= e->late_ns[i] + SAME_NS) {
        i++;
    }
    if (i == LUM_CLOCK_EARLIEST ||
        (i < e->count && late_ns > e->late_ns[i] - SAME_NS)) {
        return widest_gap(e);
    }
    e->count += e->count < LUM_CLOCK_EARLIEST ? 1u : 0u;
    for (uint32_t k = e->count - 1u; k > i; k--) {
        e->late_ns[k] = e->late_ns[k - 1u];
    }
    e->late_ns[i] = late_ns;
    return widest_gap(e);
}

/* --- The window --- */

static int64_t index_of(int64_t clock_us)
{
    const int64_t towards_0 = clock_us / LUM_CLOCK_BUCKET_US;
    return clock_us % LUM_CLOCK_BUCKET_US < 0 ? towards_0 - 1 : towards_0;
}

/* NULL: nothing of that span has arrived, or it is long ago. */
static const struct lum_clock_bucket *find_bucket(
    const struct lum_clock_arrivals *a, int64_t index)
{
    const struct lum_clock_bucket *b =
        &a->buckets[(uint64_t)index % LUM_CLOCK_BUCKETS];
    return b->index == index ? b : NULL;
}

static int64_t newest_index(const struct lum_clock_arrivals *a)
{
    return index_of(a->newest.clock_us);
}

void lum_clock_arrivals_look(const struct lum_clock_arrivals *a,
                             struct lum_clock_window *out)
{
    const int64_t newest = newest_index(a);
    out->count = 0;
    out->batches = 1;
    out->resolution_ns = lum_clock_arrivals_resolution(a);
    for (int64_t i = newest - LUM_CLOCK_BUCKETS + 1; i <= newest; i++) {
        const struct lum_clock_bucket *b = find_bucket(a, i);
        if (b != NULL) {
            out->list[out->count++] = b;
            out->batches += b->batches;
        }
    }
}

/* A reading that does not arrive together with the one before ends a batch. */
static bool ends_batch(const struct lum_clock_reading *last,
                       const struct lum_clock_reading *r)
{
    const int64_t us = r->clock_us - last->clock_us;
    return us > 0 && r->arrival_ns - last->arrival_ns >= us * 500;
}

static void put(struct lum_clock_arrivals *a, const struct lum_clock_reading *r,
                int64_t drift_ppb)
{
    const int64_t index = index_of(r->clock_us);
    struct lum_clock_bucket *b =
        &a->buckets[(uint64_t)index % LUM_CLOCK_BUCKETS];
    struct lum_clock_earliest *e = &a->earliest;
    if (b->index != index) {
        *b = (struct lum_clock_bucket){.index = index, .best = *r};
    }
    if (index > index_of(e->first.clock_us)) {
        *e = (struct lum_clock_earliest){.first = *r};
    }
    if (lum_clock_lateness(&b->best, r, drift_ppb) < 0) {
        b->best = *r;
    }
    /* The eyes' lines have one clock, and one comes after the other. */
    if (index == index_of(e->first.clock_us) &&
        (e->count == 0 || r->clock_us != a->last.clock_us)) {
        b->gap_ns =
            note_lateness(e, lum_clock_lateness(&e->first, r, drift_ppb));
    }
    b->batches += ends_batch(&a->last, r) ? 1u : 0u;
}

/* No later than its own arrival, or than an earlier one and the most that the
 * host's clock may gain since. */
static void note_latest(struct lum_clock_arrivals *a,
                        const struct lum_clock_reading *r, int64_t drift_ppb)
{
    struct lum_clock_reading *latest = &a->latest;
    const int64_t us = r->clock_us - latest->clock_us;
    if (us >= 0) {
        const int64_t most_ns =
            us * 1000 + lum_clock_scale(us, drift_ppb + GAIN_PPB);
        latest->clock_us = r->clock_us;
        latest->arrival_ns =
            lum_clock_smaller(r->arrival_ns, latest->arrival_ns + most_ns);
    }
}

void lum_clock_arrivals_begin(struct lum_clock_arrivals *a,
                              const struct lum_clock_line *line,
                              const struct lum_clock_reading *r)
{
    for (size_t i = 0; i < LUM_CLOCK_BUCKETS; i++) {
        a->buckets[i].index = LUM_CLOCK_NOTHING;
    }
    a->newest = *r;
    a->last = *r;
    a->latest = *r;
    a->earliest = (struct lum_clock_earliest){.first = *r};
    put(a, r, line->drift_ppb);
}

bool lum_clock_arrivals_take(struct lum_clock_arrivals *a,
                             const struct lum_clock_line *line,
                             const struct lum_clock_reading *r)
{
    const int64_t newest = newest_index(a);
    const int64_t index = index_of(r->clock_us);
    if (index <= newest - LUM_CLOCK_BUCKETS) {
        return false;
    }
    a->stamps.lines_us =
        common_divisor(a->stamps.lines_us,
                       lum_clock_magnitude(r->clock_us - a->last.clock_us));
    put(a, r, line->drift_ppb);
    note_latest(a, r, line->drift_ppb);
    a->last = *r;
    if (r->clock_us > a->newest.clock_us) {
        a->newest = *r;
    }
    return index > newest || lum_clock_above(line, r) < -LUM_CLOCK_SLACK_NS;
}

/* --- What bounds the truth --- */

/* By how much the truth may be later than the line in a bucket: no packet
 * arrives before it was sent.
 * 1. The newest bucket may still get an earlier arrival: by as much as its
 *    latest truth is above the line.
 * 2. By no more than the earliest arrival of this bucket, or of one beside it
 *    with what the host's clock may gain until then, if that is complete.
 * 3. If all of many arrivals of the bucket are far above that, perhaps the
 *    host's clock was stepped: then the bucket's own earliest one counts. */
static int64_t later_in(const struct lum_clock_arrivals *a,
                        const struct lum_clock_line *line, int64_t index)
{
    const struct lum_clock_bucket *b = find_bucket(a, index);
    const int64_t newest = newest_index(a);
    int64_t least_ns =
        index == newest ? lum_clock_above(line, &a->latest) : LUM_CLOCK_NOTHING;
    if (b == NULL) {
        return 0;
    }
    for (int64_t i = index - 1; i <= index + 1 && i < newest; i++) {
        const struct lum_clock_bucket *near = find_bucket(a, i);
        if (near != NULL) {
            const int64_t away_us =
                lum_clock_magnitude(near->best.clock_us - b->best.clock_us);
            least_ns = lum_clock_smaller(
                least_ns, lum_clock_above(line, &near->best) +
                              lum_clock_scale(away_us, GAIN_PPB));
        }
    }
    const int64_t own_ns = lum_clock_above(line, &b->best);
    return b->batches >= BATCHES_MANY && own_ns > least_ns + LUM_CLOCK_LOW_NS
               ? own_ns
               : least_ns;
}

/* By what arrived on both sides of the reading. */
int64_t lum_clock_arrivals_later(const struct lum_clock_arrivals *a,
                                 const struct lum_clock_line *line,
                                 int64_t clock_us)
{
    const int64_t index =
        lum_clock_smaller(index_of(clock_us), newest_index(a));
    int64_t later_ns = 0;
    for (int64_t i = index - 1; i <= index + 1; i++) {
        const int64_t ns = later_in(a, line, i);
        later_ns = ns > later_ns ? ns : later_ns;
    }
    return later_ns;
}

int64_t lum_clock_arrivals_error(const struct lum_clock_arrivals *a,
                                 const struct lum_clock_line *line,
                                 int64_t clock_us)
{
    return lum_clock_error(line, clock_us) + lum_clock_arrivals_resolution(a) +
           lum_clock_arrivals_later(a, line, clock_us);
}

/* --- As bytes --- */

/* Its place follows from its reading. */
static void pack_bucket(lum_pack *p, struct lum_clock_bucket *b,
                        const struct lum_clock_reading *near)
{
    bool is_used = b->index != LUM_CLOCK_NOTHING;
    lum_pack_bool(p, &is_used);
    if (!is_used) {
        b->index = LUM_CLOCK_NOTHING;
        return;
    }
    lum_clock_reading_pack(p, &b->best, near);
    b->index = index_of(b->best.clock_us);
    lum_clock_pack_limited(p, &b->gap_ns, LUM_CLOCK_NS_MAX);
    lum_pack_u32(p, &b->batches);
}

static void pack_stamps(lum_pack *p, struct lum_clock_stamps *s)
{
    lum_pack_i64(p, &s->step_us);
    lum_pack_i64(p, &s->lines_us);
    lum_pack_u32(p, &s->halvings);
    (void)lum_pack_check(
        p, s->step_us > 0 && s->step_us <= LUM_CLOCK_STEP_MAX_US &&
               s->lines_us >= 0 && s->halvings <= LUM_CLOCK_HALVINGS);
}

static void pack_earliest(lum_pack *p, struct lum_clock_earliest *e,
                          const struct lum_clock_reading *near)
{
    lum_clock_reading_pack(p, &e->first, near);
    lum_pack_u32(p, &e->count);
    if (lum_pack_check(p, e->count <= LUM_CLOCK_EARLIEST)) {
        for (uint32_t i = 0; i < e->count; i++) {
            lum_clock_pack_limited(p, &e->late_ns[i], LUM_CLOCK_NS_MAX);
        }
    }
}

void lum_clock_arrivals_pack(struct lum_clock_arrivals *a, lum_pack *pack)
{
    static const struct lum_clock_reading zero = {0, 0};
    lum_clock_reading_pack(pack, &a->newest, &zero);
    lum_clock_reading_pack(pack, &a->last, &a->newest);
    lum_clock_reading_pack(pack, &a->latest, &a->newest);
    pack_stamps(pack, &a->stamps);
    pack_earliest(pack, &a->earliest, &a->newest);
}

void lum_clock_arrivals_pack_buckets(struct lum_clock_arrivals *a,
                                     lum_pack *pack)
{
    for (size_t i = 0; i < LUM_CLOCK_BUCKETS && !pack->has_failed; i++) {
        pack_bucket(pack, &a->buckets[i], &a->newest);
    }
    /* The bucket of the newest reading is in use. */
    (void)lum_pack_check(pack, find_bucket(a, newest_index(a)) != NULL);
}
