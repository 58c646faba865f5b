#define _POSIX_C_SOURCE 200809L
#include "player.h"

#include "../common/misfit.h"
#include "../common/number.h"
#include "captures.h"
#include "lum/base/time.h"
#include "scan.h"
#include "thread.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

/* Records between looks at orders. */
#define RECORDS_A_LOOK 64u

/* A pause of the recording is waited out no longer. */
#define GAP_NS (2 * SECOND_NS)

/* Between frames, until there are two. */
#define DISTANCE_NS (SECOND_NS / 10)

/* Frames that are late by less are caught up with. */
#define LATE_NS (SECOND_NS / 10)

/* A view that is missing is made at once where the next frame is farther. */
#define REMAKE_NS (SECOND_NS / 5)

enum next {
    WAIT,
    GO_ON,
    REOPEN, /* read from the beginning, up to the target */
    STOP
};

struct player {
    struct player_options options;
    struct stage *stage;
    pthread_t thread;
    struct captures *captures;
    struct scan *scan; /* NULL: they can be read once */

    /* the thread's */
    lum_capture *capture;
    struct decoder *decoder;
    struct decoder *learned; /* of the begin of files; NULL: nothing */
    struct totals before;    /* of earlier passes */
    int64_t target;          /* of a jump */
    int64_t from;            /* pass over frames before it */
    bool is_due;             /* the next frame is shown whatever the pace */
    bool is_remake;          /* it is the one that is shown already */
    bool has_shown;
    int64_t shown;
    int64_t shown_ns; /* when it was, or should have been; monotonic */
    int64_t shown_arrival_ns;
    int64_t shown_clock_us;
    int64_t distance_ns; /* between the latest two frames */
    uint64_t cut;        /* points */
    int64_t cut_frame;
    lum_error broken; /* why the source could not be read to its end */
};

/* --- Reports and frames --- */

static void tell(struct player *p)
{
    char text[LUM_ERROR_BYTES] = "";
    char others[200];
    char shown[LUM_SENSOR_NAME_BYTES];
    size_t len = 0;
    if (p->broken.text[0] != '\0') {
        len = (size_t)snprintf(text, sizeof text, "%.280s", p->broken.text);
    }
    (void)decoder_others(p->decoder, shown, others, sizeof others);
    if (others[0] != '\0' && shown[0] != '\0') {
        (void)snprintf(text + len, sizeof text - len,
                       "%s%s is shown; there is also %s: choose by --sensor",
                       len > 0 ? "; " : "", shown, others);
        len = strlen(text);
    }
    if (p->cut > 0) {
        (void)snprintf(text + len, sizeof text - len,
                       "%sframe %" PRId64 " has more than %u points: %" PRIu64
                       " of them are not shown",
                       len > 0 ? "; " : "", p->cut_frame, FRAME_POINTS_MAX,
                       p->cut);
    }
    stage_set_message(p->stage, text);
}

static void tell_others(struct player *p)
{
    captures_tell_others(p->captures, p->capture, p->options.said, p->stage);
}

static void tell_remarks(struct player *p)
{
    char text[2u * LUM_ERROR_BYTES];
    stage_set_remarks(p->stage, captures_remarks(p->captures, p->capture,
                                                 decoder_demux(p->decoder),
                                                 text, sizeof text));
}

/* Of files the look ahead tells it. */
static void tell_of_sources(struct player *p)
{
    char text[LUM_ERROR_BYTES];
    if (p->scan == NULL) {
        tell_others(p);
        tell_remarks(p);
        stage_set_gaps(p->stage, captures_gaps(p->captures, p->capture, text,
                                               sizeof text));
    }
}

/* What has been told stays. */
static void tell_doubt(struct player *p)
{
    char what[160];
    char capture[128];
    char advice[MISFIT_ADVICE_BYTES + sizeof capture];
    char text[sizeof what + sizeof advice + 2];
    if (decoder_misfit(p->decoder, what, sizeof what)) {
        misfit_advise(
            "", misfit_capture(p->options.sources, capture, sizeof capture),
            advice, sizeof advice);
        (void)snprintf(text, sizeof text, "%s: %s", what, advice);
        stage_set_doubt(p->stage, text);
    }
}

static void count(struct player *p)
{
    struct totals now;
    decoder_count(p->decoder, &now);
    totals_add(&now, &p->before);
    stage_set_totals(p->stage, &now);
    tell_doubt(p);
}

/* The time of a frame after the one that is shown. */
static int64_t distance_to(struct player *p, const struct picture *picture)
{
    int64_t ns = picture->arrival_ns - p->shown_arrival_ns;
    if (ns <= 0) {
        ns = (picture->clock_us - p->shown_clock_us) * 1000;
    }
    if (ns > 0 && picture->lines > 0) {
        p->distance_ns = ns < GAP_NS ? ns : GAP_NS;
    }
    return p->distance_ns;
}

static void show(struct player *p, struct picture *picture, int64_t due_ns,
                 bool plays)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (!p->is_remake) {
        p->shown_ns = now_ns - due_ns < LATE_NS ? due_ns : now_ns;
        stage_set_state(p->stage, plays ? FEED_PLAYING : FEED_PAUSED);
    }
    p->has_shown = true;
    p->shown = picture->frame;
    if (picture->lines > 0) {
        p->shown_arrival_ns = picture->arrival_ns;
        p->shown_clock_us = picture->clock_us;
    }
    p->is_due = false;
    p->is_remake = false;
    if (picture->cut > 0) {
        p->cut = picture->cut;
        p->cut_frame = picture->frame;
    }
    count(p);
    tell(p);
    tell_of_sources(p);
    stage_show(p->stage, picture, now_ns);
}

/* --- Jumps --- */

/* The frame that an order leads to. */
static int64_t find_target(struct player *p, const struct orders *o)
{
    const int64_t here = p->is_due ? p->target : p->shown;
    const int64_t target = add_clamped(o->has_seek ? o->seek : here, o->steps);
    int64_t first = 0;
    int64_t last = 0;
    if (p->scan == NULL || !scan_range(p->scan, &first, &last)) {
        return target;
    }
    return target < first ? first : target > last ? last : target;
}

static void aim(struct player *p, int64_t target, bool is_remake)
{
    p->target = target;
    p->is_due = true;
    p->is_remake = is_remake;
}

static enum next reopen_at(struct player *p, int64_t target, bool is_remake)
{
    aim(p, target, is_remake);
    p->from = stage_aim(p->stage, target);
    return REOPEN;
}

static bool has_jump(const struct orders *o)
{
    return o->has_seek || o->steps != 0;
}

static bool runs(const struct orders *o)
{
    return o->plays && o->wanted > 0;
}

/* The target of a jump, from the frames read so far. */
enum jump {
    JUMP_NOWHERE,
    JUMP_BACK,
    JUMP_PENDING,
    JUMP_AHEAD
};

/* pending: the frame that is complete and not shown; NULL: none. frames: that
 * are shown at once. */
static enum jump judge_jump(const struct player *p, int64_t target,
                            const struct picture *pending, unsigned frames)
{
    int64_t first = 0;
    int64_t last = 0;
    if (!decoder_range(p->decoder, &first, &last) ||
        add_clamped(target, 1 - (int64_t)frames) > last) {
        return JUMP_AHEAD;
    }
    if (pending != NULL && (target == pending->frame ||
                            (target < first && pending->frame == first))) {
        return JUMP_PENDING;
    }
    if (target > last) {
        return p->scan == NULL ? JUMP_AHEAD : JUMP_BACK;
    }
    const bool is_there = p->has_shown && !p->is_due && target == p->shown;
    return p->scan == NULL || is_there ? JUMP_NOWHERE : JUMP_BACK;
}

/* Of what can be read once, what is under way may be a part of a frame. */
static void skip_ahead(struct player *p, struct picture *pending)
{
    int64_t first = 0;
    int64_t last = 0;
    int64_t from = p->from;
    if (decoder_range(p->decoder, &first, &last) && last >= from) {
        from = add_clamped(last, 1);
    }
    if (pending != NULL && pending->frame >= p->from) {
        stage_keep(p->stage, pending);
    }
    decoder_skip_to(p->decoder, from);
}

static enum jump jump(struct player *p, const struct orders *o,
                      struct picture *pending)
{
    const int64_t target = find_target(p, o);
    const enum jump jump = judge_jump(p, target, pending, o->frames);
    if (jump != JUMP_NOWHERE) {
        aim(p, target, false);
    }
    if (jump == JUMP_AHEAD || jump == JUMP_BACK) {
        p->from = stage_aim(p->stage, target);
    }
    if (jump == JUMP_AHEAD) {
        skip_ahead(p, pending);
    }
    return jump;
}

/* --- A frame that is due --- */

/* Whether the shown frame must be made again, in views that it lacks. */
static bool needs_remake(const struct player *p, const struct orders *o)
{
    return o->lacks_view && p->has_shown && p->scan != NULL;
}

/* What becomes of a frame that is complete. */
static enum next judge(struct player *p, struct picture *pending,
                       const struct orders *o, int64_t due_ns)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (p->is_due && pending->frame >= p->target) {
        show(p, pending, now_ns, o->plays);
        return GO_ON;
    }
    if (p->is_due) {
        stage_keep(p->stage, pending);
        return GO_ON;
    }
    if (needs_remake(p, o) && (!o->plays || due_ns - now_ns > REMAKE_NS)) {
        return reopen_at(p, p->shown, true);
    }
    if (runs(o) && now_ns >= due_ns) {
        show(p, pending, due_ns, true);
        return GO_ON;
    }
    stage_set_state(p->stage, o->plays ? FEED_PLAYING : FEED_PAUSED);
    return WAIT;
}

/* WAIT: the pending picture stays pending. */
static enum next follow_jump(struct player *p, const struct orders *o,
                             struct picture *pending)
{
    switch (has_jump(o) ? jump(p, o, pending) : JUMP_NOWHERE) {
    case JUMP_BACK:
        return REOPEN;
    case JUMP_AHEAD:
        return GO_ON;
    case JUMP_NOWHERE:
    case JUMP_PENDING:
    default:
        return WAIT;
    }
}

/* Wait until a frame is due and show it, unless an order leads elsewhere. */
static enum next present(struct player *p, struct picture *pending)
{
    const double distance_ns = (double)distance_to(p, pending);
    enum next next = WAIT;
    while (next == WAIT) {
        struct orders o;
        stage_take_orders(p->stage, &o);
        const int64_t due_ns = p->shown_ns + (int64_t)(distance_ns / o.speed);
        next = o.closing ? STOP : follow_jump(p, &o, pending);
        if (next == WAIT) {
            next = judge(p, pending, &o, due_ns);
        }
        if (next == WAIT) {
            stage_wait(p->stage, o.serial, runs(&o) ? due_ns : INT64_MAX);
        }
    }
    return next;
}

/* --- Reading --- */

/* An error that stays until somebody wants to go elsewhere. */
static enum next fail(struct player *p, const lum_error *error)
{
    stage_set_message(p->stage, error->text);
    stage_set_state(p->stage, FEED_FAILED);
    for (;;) {
        struct orders o;
        stage_take_orders(p->stage, &o);
        if (o.closing) {
            return STOP;
        }
        if (has_jump(&o) && p->scan != NULL) {
            return reopen_at(p, find_target(p, &o), false);
        }
        stage_wait(p->stage, o.serial, INT64_MAX);
    }
}

static enum next fail_for_memory(struct player *p)
{
    lum_error error;
    (void)lum_error_set(&error, "%s: out of memory", p->options.sources->name);
    return fail(p, &error);
}

static enum next take(struct player *p, const lum_record *record)
{
    enum decoded decoded = DECODED_ALL;
    while ((decoded = decoder_push(p->decoder, record)) == DECODED_FRAME) {
        const enum next next = present(p, decoder_picture(p->decoder));
        if (next != GO_ON) {
            return next;
        }
    }
    return decoded == DECODED_ALL ? GO_ON : fail_for_memory(p);
}

static enum next flush(struct player *p)
{
    enum decoded decoded = DECODED_ALL;
    while ((decoded = decoder_flush(p->decoder)) == DECODED_FRAME) {
        const enum next next = present(p, decoder_picture(p->decoder));
        if (next != GO_ON) {
            return next;
        }
    }
    return decoded == DECODED_ALL ? GO_ON : fail_for_memory(p);
}

/* Orders while reading. */
static enum next look(struct player *p)
{
    struct orders o;
    stage_take_orders(p->stage, &o);
    if (o.closing) {
        return STOP;
    }
    return has_jump(&o) && jump(p, &o, NULL) == JUMP_BACK ? REOPEN : GO_ON;
}

static enum next read_all(struct player *p)
{
    lum_record record;
    lum_error error = {""};
    int status = 1;
    for (uint64_t i = 0; status > 0; i++) {
        enum next next = i % RECORDS_A_LOOK == 0 ? look(p) : GO_ON;
        if (next == GO_ON) {
            status = captures_next(p->captures, p->capture, &record, &error);
        }
        if (next == GO_ON && status > 0) {
            decoder_set_interface(p->decoder,
                                  lum_capture_interface(p->capture));
            next = take(p, &record);
        }
        if (next != GO_ON) {
            return next;
        }
    }
    if (status < 0) {
        p->broken = error;
    }
    return flush(p);
}

/* --- The end of a capture --- */

static void tell_empty(struct player *p)
{
    lum_error text;
    const struct sources *sources = p->options.sources;
    const char *whose = p->options.decoder.has_sensor
                            ? " of the sensor that was asked for"
                            : "";
    if (p->broken.text[0] != '\0') {
        tell(p);
        return;
    }
    if (sources->count > 1) {
        (void)lum_error_set(&text,
                            "%s: there is no frame in them%s; lumdump tells "
                            "what they hold",
                            sources->name, whose);
    } else {
        (void)lum_error_set(&text,
                            "%s: there is no frame in it%s; lumdump %s tells "
                            "what it holds",
                            sources->name, whose, sources->name);
    }
    stage_set_message(p->stage, text.text);
}

/* Play continues at the beginning. */
static enum next begin_anew(struct player *p, bool at_once)
{
    p->target = INT64_MIN;
    p->from = stage_aim(p->stage, INT64_MIN);
    p->is_due = at_once;
    p->is_remake = false;
    return REOPEN;
}

/* What an order makes of the end; GO_ON: it stays. */
static enum next leave_end(struct player *p, struct orders *o, int64_t last,
                           bool was_paused)
{
    if (o->closing) {
        return STOP;
    }
    if (has_jump(o)) {
        const int64_t target = find_target(p, o);
        if (target < last || p->shown != last) {
            return reopen_at(p, target < last ? target : last, false);
        }
    }
    if (needs_remake(p, o)) {
        return reopen_at(p, p->shown, true);
    }
    if (runs(o) && (o->loops || was_paused)) {
        return begin_anew(p, was_paused);
    }
    return GO_ON;
}

/* Stay at the end until an order leads elsewhere. */
static enum next finish(struct player *p)
{
    int64_t first = 0;
    int64_t last = 0;
    const bool has_any = decoder_range(p->decoder, &first, &last);
    const bool can_go = has_any && p->scan != NULL;
    bool was_paused = false;
    if (has_any) {
        tell(p);
    } else {
        tell_empty(p);
    }
    tell_others(p);
    tell_of_sources(p);
    if (p->scan == NULL) {
        captures_warn(p->captures, p->capture, decoder_demux(p->decoder));
    }
    count(p);
    if (can_go && p->is_due && !(p->has_shown && p->shown == last)) {
        return reopen_at(p, last, p->is_remake);
    }
    p->is_due = false;
    for (;;) {
        struct orders o;
        stage_take_orders(p->stage, &o);
        const enum next next =
            can_go || o.closing ? leave_end(p, &o, last, was_paused) : GO_ON;
        if (next != GO_ON) {
            return next;
        }
        was_paused = !o.plays;
        stage_set_state(p->stage,
                        o.plays || !has_any ? FEED_ENDED : FEED_PAUSED);
        stage_wait(p->stage, o.serial, INT64_MAX);
    }
}

/* --- The thread --- */

static enum next pass(struct player *p)
{
    lum_error error = {""};
    if (captures_open(p->captures, &p->capture, &error) != 0) {
        return fail(p, &error);
    }
    tell_others(p);
    p->decoder = decoder_new(&p->options.decoder);
    if (p->decoder == NULL ||
        (p->learned != NULL && !decoder_learn(p->decoder, p->learned))) {
        return fail_for_memory(p);
    }
    if (p->from != INT64_MIN) {
        decoder_skip_to(p->decoder, p->from);
    }
    const enum next next = read_all(p);
    return next == GO_ON ? finish(p) : next;
}

static void end_pass(struct player *p)
{
    if (p->decoder != NULL) {
        struct totals now;
        decoder_count(p->decoder, &now);
        totals_add(&p->before, &now);
    }
    decoder_free(p->decoder);
    lum_capture_close(p->capture);
    p->decoder = NULL;
    p->capture = NULL;
}

static void learn_from(struct player *p, lum_capture *capture)
{
    lum_record record;
    int64_t end_ns = INT64_MAX;
    bool goes_on = true;
    for (uint64_t i = 0;
         goes_on && captures_next(p->captures, capture, &record, NULL) > 0;
         i++) {
        end_ns =
            i == 0 ? add_clamped(record.time_ns, SOURCES_LEARN_NS) : end_ns;
        decoder_set_interface(p->learned, lum_capture_interface(capture));
        goes_on = record.time_ns <= end_ns &&
                  (i % RECORDS_A_LOOK != 0 || !stage_is_closing(p->stage)) &&
                  decoder_push(p->learned, &record) == DECODED_ALL;
    }
}

/* The time of the first frames is known as well as that of the rest. What
 * cannot be read is told when it is read again. */
static void learn(struct player *p)
{
    lum_capture *capture = NULL;
    if (!captures_are_files(p->captures) ||
        captures_open(p->captures, &capture, NULL) != 0) {
        return;
    }
    struct decoder_options alone = p->options.decoder;
    alone.second_layout = NULL;
    p->learned = decoder_new(&alone);
    if (p->learned != NULL) {
        decoder_skip_to(p->learned, INT64_MAX);
        learn_from(p, capture);
    }
    lum_capture_close(capture);
}

/* A recording does not pass before somebody looks. */
static void *run(void *argument)
{
    struct player *p = argument;
    enum next next = stage_wait_wanted(p->stage) ? REOPEN : STOP;
    if (next != STOP) {
        learn(p);
    }
    while (next != STOP) {
        next = pass(p);
        end_pass(p);
    }
    return NULL;
}

/* --- Starting and ending --- */

static int start_reading(struct player *p, lum_error *error)
{
    if (captures_new(p->options.sources, p->options.is_quiet, &p->captures,
                     error) != 0) {
        return -1;
    }
    return captures_are_files(p->captures)
               ? scan_start(p->captures, p->options.said, &p->options.decoder,
                            &p->scan, error)
               : 0;
}

static void release(struct player *p)
{
    scan_end(p->scan);
    captures_free(p->captures);
    decoder_free(p->learned);
    free(p);
}

int player_start(const struct player_options *options, struct player **out,
                 lum_error *error)
{
    struct player *p = calloc(1, sizeof *p);
    if (p == NULL) {
        return lum_error_set(error, "out of memory");
    }
    p->options = *options;
    p->stage = options->decoder.stage;
    p->target = INT64_MIN;
    p->from = INT64_MIN;
    p->is_due = true;
    p->distance_ns = DISTANCE_NS;
    if (start_reading(p, error) != 0 ||
        thread_start(&p->thread, run, p, error) != 0) {
        release(p);
        return -1;
    }
    *out = p;
    return 0;
}

void player_end(struct player *player)
{
    if (player == NULL) {
        return;
    }
    captures_stop(player->captures);
    (void)pthread_join(player->thread, NULL);
    release(player);
}
