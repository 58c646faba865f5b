/* Orders of the page and complete frames come in; what the reader of a capture
 * does next goes out: show the frame, read on, or begin again elsewhere. */
#include "playhead.h"

#include "lum/base/time.h"

#define SECOND_NS INT64_C(1000000000)

/* A pause of the recording is waited out no longer. */
#define GAP_NS (2 * SECOND_NS)

/* Between frames, until there are two. */
#define DISTANCE_NS (SECOND_NS / 10)

/* Frames that are late by less are caught up with. */
#define LATE_NS (SECOND_NS / 10)

/* As many frames are read rather than to open the captures again. */
#define NEAR_FRAMES 3

/* A view that is missing is made at once where the next frame is farther. */
#define REMAKE_NS (SECOND_NS / 5)

void playhead_init(struct playhead *out, struct stage *stage, struct scan *scan)
{
    *out = (struct playhead){.stage = stage,
                             .scan = scan,
                             .aim = AIM_FRAME,
                             .target = INT64_MIN,
                             .from = INT64_MIN,
                             .distance_ns = DISTANCE_NS};
}

/* --- Orders --- */

/* False: the stage is closing. */
static bool take_orders(struct playhead *h, struct orders *out)
{
    const bool goes_on = stage_take_orders(h->stage, out);
    h->serial = out->serial;
    return goes_on;
}

static enum play wait_until(struct playhead *h, int64_t until_ns)
{
    h->until_ns = until_ns;
    return PLAY_WAIT;
}

enum play playhead_begin(struct playhead *head)
{
    if (stage_is_closing(head->stage)) {
        return PLAY_STOP;
    }
    return stage_is_wanted(head->stage, &head->serial)
               ? PLAY_ON
               : wait_until(head, INT64_MAX);
}

static bool has_jump(const struct orders *o)
{
    return o->has_seek || o->steps != 0;
}

static bool runs(const struct orders *o)
{
    return o->plays && o->is_wanted;
}

/* The frame that an order leads to. */
static int64_t find_target(const struct playhead *h, const struct orders *o)
{
    const int64_t here = h->aim != AIM_NONE ? h->target : h->shown;
    const int64_t target = add_clamped(o->has_seek ? o->seek : here, o->steps);
    int64_t first = 0;
    int64_t last = 0;
    if (h->scan == NULL || !scan_range(h->scan, &first, &last)) {
        return target;
    }
    return target < first ? first : target > last ? last : target;
}

static enum play reopen_at(struct playhead *h, int64_t target, enum aim aim)
{
    h->target = target;
    h->aim = aim;
    h->was_paused = false;
    h->from = stage_aim(h->stage, target);
    return PLAY_REOPEN;
}

enum play playhead_restart(struct playhead *head)
{
    if (head->aim == AIM_NONE) {
        head->from = add_clamped(head->shown, 1);
    }
    return PLAY_REOPEN;
}

/* Whether the shown frame must be made again, in views that it lacks. */
static bool needs_remake(const struct playhead *h, const struct orders *o)
{
    return o->lacks_view && h->has_shown && h->scan != NULL;
}

/* --- Jumps --- */

/* The target of a jump, from the frames read so far. */
enum jump {
    JUMP_NOWHERE,
    JUMP_BACK,
    JUMP_PENDING,
    JUMP_AHEAD
};

/* pending: the frame that is complete and not shown; NULL: none. frames: that
 * are shown at once. */
static enum jump judge_jump(const struct playhead *h,
                            const struct decoder *decoder, int64_t target,
                            const struct picture *pending, unsigned frames)
{
    int64_t first = 0;
    int64_t last = 0;
    if (!decoder_range(decoder, &first, &last) ||
        add_clamped(target, 1 - (int64_t)frames) > last) {
        return JUMP_AHEAD;
    }
    if (pending != NULL && (target == pending->frame ||
                            (target < first && pending->frame == first))) {
        return JUMP_PENDING;
    }
    if (target > last) {
        return h->scan == NULL ? JUMP_AHEAD : JUMP_BACK;
    }
    const bool is_there =
        h->has_shown && h->aim == AIM_NONE && target == h->shown;
    return h->scan == NULL || is_there ? JUMP_NOWHERE : JUMP_BACK;
}

/* Of what can be read once, what is under way may be a part of a frame. */
static void skip_ahead(const struct playhead *h, struct decoder *decoder,
                       struct picture *pending)
{
    int64_t first = 0;
    int64_t last = 0;
    int64_t from = h->from;
    if (decoder_range(decoder, &first, &last) && last >= from) {
        from = add_clamped(last, 1);
    }
    if (pending != NULL && pending->frame >= h->from) {
        stage_keep(h->stage, pending);
    }
    decoder_skip_to(decoder, from);
}

/* Whether to begin again is the shorter way ahead. */
static bool leads_ahead(const struct playhead *h, const struct decoder *decoder,
                        int64_t from)
{
    int64_t first = 0;
    int64_t last = 0;
    int64_t begin = 0;
    return h->scan != NULL && decoder_range(decoder, &first, &last) &&
           scan_leads(h->scan, from, &begin) &&
           begin > add_clamped(last, NEAR_FRAMES);
}

/* PLAY_WAIT: no jump, or to the pending frame, which is due then. */
static enum play jump(struct playhead *h, const struct orders *o,
                      struct decoder *decoder, struct picture *pending)
{
    if (!has_jump(o)) {
        return PLAY_WAIT;
    }
    const int64_t target = find_target(h, o);
    const enum jump jump = judge_jump(h, decoder, target, pending, o->frames);
    switch (jump) {
    case JUMP_BACK:
        return reopen_at(h, target, AIM_FRAME);
    case JUMP_AHEAD:
        (void)reopen_at(h, target, AIM_FRAME);
        if (leads_ahead(h, decoder, h->from)) {
            return PLAY_REOPEN;
        }
        skip_ahead(h, decoder, pending);
        return PLAY_ON;
    case JUMP_PENDING:
        h->target = target;
        h->aim = AIM_FRAME;
        return PLAY_WAIT;
    case JUMP_NOWHERE:
    default:
        return PLAY_WAIT;
    }
}

enum play playhead_look(struct playhead *head, struct decoder *decoder)
{
    struct orders o;
    if (!take_orders(head, &o)) {
        return PLAY_STOP;
    }
    return jump(head, &o, decoder, NULL) == PLAY_REOPEN ? PLAY_REOPEN : PLAY_ON;
}

/* --- A frame that is complete --- */

/* The time of a frame after the one that is shown. */
static int64_t distance_to(struct playhead *h, const struct picture *picture)
{
    int64_t ns = picture->arrival_ns - h->shown_arrival_ns;
    if (ns <= 0) {
        ns = (picture->clock_us - h->shown_clock_us) * 1000;
    }
    if (ns > 0 && picture->lines > 0) {
        h->distance_ns = ns < GAP_NS ? ns : GAP_NS;
    }
    return h->distance_ns;
}

static enum play show(struct playhead *h, const struct picture *picture,
                      int64_t due_ns, bool plays)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (h->aim != AIM_REMAKE) {
        h->shown_ns = now_ns - due_ns < LATE_NS ? due_ns : now_ns;
        stage_set_state(h->stage, plays ? FEED_PLAYING : FEED_PAUSED);
    }
    h->has_shown = true;
    h->shown = picture->frame;
    if (picture->lines > 0) {
        h->shown_arrival_ns = picture->arrival_ns;
        h->shown_clock_us = picture->clock_us;
    }
    h->aim = AIM_NONE;
    return PLAY_SHOW;
}

/* What becomes of it, as nothing leads elsewhere. */
static enum play judge(struct playhead *h, struct picture *pending,
                       const struct orders *o, int64_t due_ns)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (h->aim != AIM_NONE && pending->frame >= h->target) {
        return show(h, pending, now_ns, o->plays);
    }
    if (h->aim != AIM_NONE) {
        stage_keep(h->stage, pending);
        return PLAY_ON;
    }
    if (needs_remake(h, o) && (!o->plays || due_ns - now_ns > REMAKE_NS)) {
        return reopen_at(h, h->shown, AIM_REMAKE);
    }
    if (runs(o) && now_ns >= due_ns) {
        return show(h, pending, due_ns, true);
    }
    stage_set_state(h->stage, o->plays ? FEED_PLAYING : FEED_PAUSED);
    return PLAY_WAIT;
}

enum play playhead_present(struct playhead *head, struct decoder *decoder,
                           struct picture *complete)
{
    const double distance_ns = (double)distance_to(head, complete);
    struct orders o;
    if (!take_orders(head, &o)) {
        return PLAY_STOP;
    }
    const int64_t due_ns = head->shown_ns + (int64_t)(distance_ns / o.speed);
    const enum play next = jump(head, &o, decoder, complete);
    (void)wait_until(head, runs(&o) ? due_ns : INT64_MAX);
    return next == PLAY_WAIT ? judge(head, complete, &o, due_ns) : next;
}

/* --- Where nothing more is read --- */

enum play playhead_fail(struct playhead *head)
{
    struct orders o;
    if (!take_orders(head, &o)) {
        return PLAY_STOP;
    }
    return has_jump(&o) && head->scan != NULL
               ? reopen_at(head, find_target(head, &o), AIM_FRAME)
               : wait_until(head, INT64_MAX);
}

/* What an order makes of the end; PLAY_WAIT: it stays. Play goes on at the
 * beginning. */
static enum play leave_end(struct playhead *h, const struct orders *o,
                           int64_t last)
{
    const bool was_paused = h->was_paused;
    if (has_jump(o)) {
        const int64_t target = find_target(h, o);
        if (target < last || h->shown != last) {
            return reopen_at(h, target < last ? target : last, AIM_FRAME);
        }
    }
    if (needs_remake(h, o)) {
        return reopen_at(h, h->shown, AIM_REMAKE);
    }
    if (runs(o) && (o->loops || was_paused)) {
        return reopen_at(h, INT64_MIN, was_paused ? AIM_FRAME : AIM_NONE);
    }
    return PLAY_WAIT;
}

enum play playhead_end(struct playhead *head, const struct decoder *decoder)
{
    int64_t first = 0;
    int64_t last = 0;
    const bool has_any = decoder_range(decoder, &first, &last);
    const bool can_go = has_any && head->scan != NULL;
    struct orders o;
    if (can_go && head->aim != AIM_NONE &&
        !(head->has_shown && head->shown == last)) {
        return reopen_at(head, last, head->aim);
    }
    head->aim = AIM_NONE;
    if (!take_orders(head, &o)) {
        return PLAY_STOP;
    }
    const enum play next = can_go ? leave_end(head, &o, last) : PLAY_WAIT;
    if (next != PLAY_WAIT) {
        return next;
    }
    head->was_paused = !o.plays;
    stage_set_state(head->stage,
                    o.plays || !has_any ? FEED_ENDED : FEED_PAUSED);
    return wait_until(head, INT64_MAX);
}
