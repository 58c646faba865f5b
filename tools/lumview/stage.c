#define _POSIX_C_SOURCE 200809L
#include "stage.h"

#include "lum/base/time.h"

#include <stdio.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

/* --- Sums --- */

int64_t add_clamped(int64_t a, int64_t b)
{
    if (b > 0) {
        return a > INT64_MAX - b ? INT64_MAX : a + b;
    }
    return a < INT64_MIN - b ? INT64_MIN : a + b;
}

/* Totals are numbers of 64 bits alone, so none can be left out of a sum. To
 * take away is to add -1 times as much. */
static void add_numbers(void *to, const void *more, uint64_t times)
{
    uint64_t *sums = to;
    const uint64_t *numbers = more;
    for (size_t i = 0; i < sizeof(struct totals) / sizeof *sums; i++) {
        sums[i] += times * numbers[i];
    }
}

void totals_add(struct totals *to, const struct totals *more)
{
    add_numbers(to, more, 1);
}

void totals_subtract(struct totals *from, const struct totals *less)
{
    add_numbers(from, less, UINT64_MAX);
}

void loss_add(struct feed_loss *to, const struct feed_loss *more)
{
    to->words += more->words;
    to->lines += more->lines;
    to->pauses += more->pauses;
}

/* --- Its beginning and end --- */

bool stage_init(struct stage *stage, void (*wake)(void *context), void *context)
{
    *stage = (struct stage){.wake = wake, .context = context};
    stage->trail.from = INT64_MIN;
    stage->monitor = monitor_new();
    return stage->monitor != NULL;
}

void stage_end(struct stage *stage)
{
    picture_drop(&stage->shown);
    trail_cut(&stage->trail, 0, 0);
    monitor_free(stage->monitor);
}

static void lock(struct stage *stage)
{
    monitor_lock(stage->monitor);
}

static void unlock(struct stage *stage)
{
    monitor_unlock(stage->monitor);
}

static void unlock_and_wake(struct stage *stage, bool has_news)
{
    unlock(stage);
    if (has_news) {
        stage->wake(stage->context);
    }
}

/* --- Orders --- */

/* Called with the lock. The first of the frames that are shown at once with the
 * last of them. */
static int64_t first_at_once(const struct stage *stage, int64_t last)
{
    return last == INT64_MIN
               ? last
               : add_clamped(last, 1 - (int64_t)stage->orders.frames);
}

/* Likewise. */
static bool lacks_view(const struct stage *stage)
{
    return !picture_has(&stage->shown, &stage->views) ||
           !trail_has(&stage->trail, &stage->views) ||
           stage->trail.from > first_at_once(stage, stage->shown.frame);
}

bool stage_take_orders(struct stage *stage, struct orders *out)
{
    lock(stage);
    *out = stage->orders;
    out->lacks_view = lacks_view(stage);
    stage->orders.has_seek = false;
    stage->orders.steps = 0;
    unlock(stage);
    return !out->closing;
}

/* The clock that waits go by may jump, so none is long. */
void stage_wait(struct stage *stage, unsigned serial, int64_t until_ns)
{
    int64_t wait_ns = until_ns - lum_time_monotonic_ns();
    if (wait_ns <= 0) {
        return;
    }
    wait_ns = wait_ns < SECOND_NS / 4 ? wait_ns : SECOND_NS / 4;
    bool goes_on = true;
    lock(stage);
    while (stage->orders.serial == serial && goes_on) {
        goes_on = monitor_wait(stage->monitor, wait_ns);
    }
    unlock(stage);
}

bool stage_is_wanted(struct stage *stage, unsigned *serial)
{
    lock(stage);
    const bool is_wanted = stage->orders.is_wanted;
    *serial = stage->orders.serial;
    unlock(stage);
    return is_wanted;
}

bool stage_is_closing(struct stage *stage)
{
    lock(stage);
    const bool closing = stage->orders.closing;
    unlock(stage);
    return closing;
}

struct feed_views stage_views(struct stage *stage)
{
    lock(stage);
    const struct feed_views views = stage->views;
    unlock(stage);
    return views;
}

int64_t stage_aim(struct stage *stage, int64_t target)
{
    lock(stage);
    const int64_t from = first_at_once(stage, target);
    trail_cut(&stage->trail, from, target);
    /* Each is made again, but for those that the files do not have any more. */
    trail_shed(&stage->trail, &stage->views);
    stage->trail.from = from;
    unlock(stage);
    return from;
}

/* --- Pictures --- */

/* To the page it is older than the frame that is shown. */
void stage_keep(struct stage *stage, struct picture *picture)
{
    lock(stage);
    const uint64_t shown = stage->status.frames;
    unlock(stage);
    picture_seal(picture, stage->pool, lum_time_monotonic_ns(),
                 shown > 0 ? shown - 1u : 0);
    lock(stage);
    trail_put(&stage->trail, picture);
    unlock(stage);
}

/* Called with the lock: the trail of the frame that is shown now. */
static void follow(struct stage *stage, struct picture *before)
{
    const int64_t first = first_at_once(stage, stage->shown.frame);
    if (before->views.count > 0 &&
        trail_find(&stage->trail, before->frame) == NULL) {
        trail_put(&stage->trail, before);
    }
    trail_cut(&stage->trail, first, stage->shown.frame);
    if (stage->trail.from < first) {
        stage->trail.from = first;
    }
}

void stage_show(struct stage *stage, struct picture *picture,
                int64_t complete_ns)
{
    lock(stage);
    const uint64_t shown = stage->status.frames + 1u;
    unlock(stage);
    picture_seal(picture, stage->pool, complete_ns, shown);
    lock(stage);
    struct picture before = stage->shown;
    stage->shown = *picture;
    stage->status.frame = picture->frame;
    stage->status.frames = shown;
    stage->status.frame_ns = complete_ns;
    follow(stage, &before);
    unlock_and_wake(stage, true);
    picture_drop(&before);
    *picture = (struct picture){0};
}

/* --- What is told --- */

/* Called with the lock. Whether that was news. */
static bool set_text(struct stage *stage, enum feed_text which,
                     const char *text)
{
    char *to = stage->status.texts[which];
    const bool is_news = (which != FEED_MESSAGE || !stage->has_failed) &&
                         strncmp(to, text, FEED_TEXT_BYTES - 1u) != 0;
    if (is_news) {
        (void)snprintf(to, FEED_TEXT_BYTES, "%s", text);
    }
    return is_news;
}

/* Likewise. */
static bool set_state(struct stage *stage, enum feed_state state)
{
    const bool is_news = !stage->has_failed && stage->status.state != state;
    if (is_news) {
        stage->status.state = state;
    }
    return is_news;
}

void stage_set_state(struct stage *stage, enum feed_state state)
{
    lock(stage);
    unlock_and_wake(stage, set_state(stage, state));
}

void stage_set_text(struct stage *stage, enum feed_text which, const char *text)
{
    lock(stage);
    unlock_and_wake(stage, set_text(stage, which, text));
}

void stage_fail(struct stage *stage, const char *message)
{
    lock(stage);
    bool is_news = set_text(stage, FEED_MESSAGE, message);
    is_news |= set_state(stage, FEED_FAILED);
    stage->has_failed = true;
    unlock_and_wake(stage, is_news);
}

/* The first of the frames that have a mark together. */
static int64_t first_of(int64_t frame, int64_t frames)
{
    const int64_t rest = frame % frames;
    return frame - (rest < 0 ? rest + frames : rest);
}

static void widen(struct feed_marks *m)
{
    size_t kept = 0;
    m->frames *= 2;
    for (size_t i = 0; i < m->count; i++) {
        const struct feed_mark mark = {.frame =
                                           first_of(m->at[i].frame, m->frames),
                                       .loss = m->at[i].loss};
        if (kept > 0 && m->at[kept - 1u].frame == mark.frame) {
            loss_add(&m->at[kept - 1u].loss, &mark.loss);
        } else {
            m->at[kept++] = mark;
        }
    }
    m->count = kept;
}

/* False: there is no room. */
static bool put(struct feed_marks *m, int64_t frame,
                const struct feed_loss *loss)
{
    size_t i = m->count;
    frame = first_of(frame, m->frames);
    while (i > 0 && m->at[i - 1u].frame > frame) {
        i--;
    }
    if (i > 0 && m->at[i - 1u].frame == frame) {
        loss_add(&m->at[i - 1u].loss, loss);
        return true;
    }
    if (m->count == FEED_MARKS_MAX) {
        return false;
    }
    (void)memmove(m->at + i + 1u, m->at + i, (m->count - i) * sizeof m->at[0]);
    m->at[i] = (struct feed_mark){.frame = frame, .loss = *loss};
    m->count++;
    return true;
}

void stage_mark(struct stage *stage, int64_t frame,
                const struct feed_loss *loss)
{
    lock(stage);
    struct feed_marks *m = &stage->marks;
    m->frames = m->frames > 0 ? m->frames : 1;
    while (!put(m, frame, loss)) {
        widen(m);
    }
    stage->status.marks++;
    unlock(stage);
}

void stage_set_range(struct stage *stage, int64_t first, int64_t last)
{
    lock(stage);
    stage->status.has_range = true;
    stage->status.first_frame = first;
    stage->status.last_frame = last;
    unlock_and_wake(stage, true);
}

void stage_set_scanned(struct stage *stage, double share)
{
    lock(stage);
    stage->status.scanned = share;
    unlock(stage);
}

void stage_set_totals(struct stage *stage, const struct totals *totals)
{
    lock(stage);
    if (!stage->status.is_live) {
        stage->status.received = totals->received;
    }
    stage->status.decoded = totals->decoded;
    unlock(stage);
}

void stage_set_received(struct stage *stage,
                        const struct feed_received *received,
                        const struct feed_dropped *dropped)
{
    lock(stage);
    stage->status.received = *received;
    stage->status.dropped = *dropped;
    unlock(stage);
}

void stage_set_laser(struct stage *stage, bool is_known, uint16_t status)
{
    lock(stage);
    const bool is_news = stage->status.has_laser != is_known ||
                         (is_known && stage->status.laser != status);
    stage->status.has_laser = is_known;
    stage->status.laser = status;
    unlock_and_wake(stage, is_news);
}

/* --- Looks and orders of the page --- */

const struct feed_status *stage_begin_look(struct stage *stage)
{
    lock(stage);
    return &stage->status;
}

void stage_end_look(struct stage *stage)
{
    unlock(stage);
}

struct orders *stage_begin_order(struct stage *stage)
{
    lock(stage);
    return &stage->orders;
}

void stage_end_order(struct stage *stage)
{
    stage->orders.serial++;
    monitor_notify(stage->monitor);
    unlock(stage);
}
