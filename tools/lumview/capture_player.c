/* Plays captures: opens and reads them, again and again, and gives complete
 * frames to the page where the playhead says so. It goes in steps, which a
 * thread takes, or who has none. */
#include "capture_player.h"

#include "capture_scan.h"
#include "captures.h"
#include "playhead.h"
#include "thread_monitor.h"

#include "base/text.h"
#include "lum/base/time.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Records between looks at orders. */
#define RECORDS_A_LOOK 64u

/* Without threads, what is done at a time. */
#define WORK_NS INT64_C(20000000)

#define SECOND_NS INT64_C(1000000000)

/* What the next step is about. */
enum phase {
    PHASE_UNWANTED, /* nobody has looked yet */
    PHASE_LEARNING, /* of the beginning of files */
    PHASE_OPENING,
    PHASE_READING,
    PHASE_PUSHING,  /* what was read, until it gives no more frames */
    PHASE_FLUSHING, /* all was read: those that are left */
    PHASE_SHOWING,  /* a frame is complete */
    PHASE_ENDED,
    PHASE_FAILED,
    PHASE_STOPPED
};

struct player {
    struct player_options options;
    struct thread *thread; /* NULL: there are none */
    struct captures *captures;
    struct scan *scan; /* NULL: they can be read once */

    /* of who takes the steps */
    enum phase phase;
    struct playhead head;
    struct totals before; /* of earlier passes */
    int64_t cut_frame;    /* the latest with too many points */
    uint64_t cut;         /* how many were left out of it; 0: of none */
    lum_error broken;     /* the reader's: why it did not get to the end; "" */
    const struct decoder *learned; /* the scan's; NULL: nothing */
    lum_go_on go_on;
    lum_capture *capture;
    struct decoder *decoder;
    lum_record record;
    bool has_record; /* it is being pushed; else the end is flushed */
};

/* --- What a person is told --- */

/* Why frames are incomplete, and which sensors are not shown. */
static void tell_message(const struct player *p)
{
    char text[LUM_ERROR_BYTES] = "";
    char others[200];
    char shown[LUM_SENSOR_NAME_BYTES];
    if (p->broken.text[0] != '\0') {
        lum_text_add(text, sizeof text, "%.280s", p->broken.text);
    }
    (void)decoder_others(p->decoder, shown, others, sizeof others);
    if (p->options.rig == NULL && others[0] != '\0' && shown[0] != '\0') {
        lum_text_add(text, sizeof text,
                     "%s%s is shown; there is also %s: choose by lumview "
                     "--sensor, or show all by a rig: lumview --rig, or a "
                     "rig file dropped on lumview.html",
                     *text != '\0' ? "; " : "", shown, others);
    }
    const char *sensor = "";
    const uint64_t late = decoder_late(p->decoder, &sensor);
    if (late > 0) {
        lum_text_add(text, sizeof text,
                     "%sa frame of %s is left out, as the sensor paused in "
                     "it or has stopped (%" PRIu64 " in all)",
                     *text != '\0' ? "; " : "", sensor, late);
    }
    if (p->cut > 0) {
        lum_text_add(text, sizeof text,
                     "%sframe %" PRId64 " has more than %u points: %" PRIu64
                     " of them are not shown",
                     *text != '\0' ? "; " : "", p->cut_frame, FRAME_POINTS_MAX,
                     p->cut);
    }
    stage_set_text(p->head.stage, FEED_MESSAGE, text);
}

static void tell_empty(const struct player *p)
{
    lum_error text;
    const struct sources *sources = p->options.sources;
    const bool are_several = sources->count > 1;
    if (p->broken.text[0] != '\0') {
        tell_message(p);
        return;
    }
    (void)lum_error_set(
        &text, "%s: there is no frame in %s%s; lumdump %s%stells what %s",
        sources->name, are_several ? "them" : "it",
        p->options.decoder.sensor.is_given ? " of the sensor that was chosen"
        : p->options.rig != NULL           ? " of the rig's sensors"
                                           : "",
        are_several ? "" : sources->name, are_several ? "" : " ",
        are_several ? "they hold" : "it holds");
    stage_set_text(p->head.stage, FEED_MESSAGE, text.text);
}

static void count(const struct player *p)
{
    struct totals now;
    decoder_count(p->decoder, &now);
    totals_add(&now, &p->before);
    stage_set_totals(p->head.stage, &now);
    decoder_tell_doubt(p->decoder, p->options.sources, "");
}

/* What files say of themselves, where no scan tells it. */
static void tell_files(const struct player *p)
{
    if (p->scan == NULL) {
        captures_tell(p->captures, p->capture, decoder_demux(p->decoder),
                      p->options.said, p->head.stage);
    }
}

static void tell_frame(struct player *p, const struct picture *picture)
{
    if (picture->cut > 0) {
        p->cut = picture->cut;
        p->cut_frame = picture->frame;
    }
    count(p);
    tell_message(p);
    tell_files(p);
}

/* A pass has come to the end of the captures. */
static void tell_end(const struct player *p)
{
    int64_t first = 0;
    int64_t last = 0;
    if (decoder_range(p->decoder, &first, &last)) {
        tell_message(p);
    } else {
        tell_empty(p);
    }
    if (p->scan != NULL) {
        captures_tell_others(p->captures, p->capture, p->options.said,
                             p->head.stage);
    } else {
        tell_files(p);
        captures_warn(p->captures, p->capture, decoder_demux(p->decoder));
    }
    count(p);
}

/* --- Where a pass leads --- */

static enum play become(struct player *p, enum phase phase)
{
    p->phase = phase;
    return PLAY_ON;
}

/* An error that stays until somebody wants to go elsewhere. */
static enum play fail(struct player *p, const lum_error *error)
{
    stage_set_text(p->head.stage, FEED_MESSAGE, error->text);
    stage_set_state(p->head.stage, FEED_FAILED);
    return become(p, PHASE_FAILED);
}

static enum play fail_for_memory(struct player *p)
{
    lum_error error;
    (void)lum_error_set(&error, "%s: out of memory", p->options.sources->name);
    return fail(p, &error);
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

/* --- Steps of a pass --- */

/* To the frames that are wanted: at once, where it is known where they are. */
static void skip(struct player *p)
{
    const int64_t from = p->head.from;
    if (from != INT64_MIN) {
        if (p->scan != NULL) {
            (void)scan_go(p->scan, p->capture, p->decoder, from);
        }
        decoder_skip_to(p->decoder, from);
    }
}

static enum play open_pass(struct player *p)
{
    lum_error error = {""};
    if (captures_open(p->captures, &p->go_on, &p->capture, &error) != 0) {
        return fail(p, &error);
    }
    captures_tell_others(p->captures, p->capture, p->options.said,
                         p->head.stage);
    p->decoder = decoder_new(&p->options.decoder);
    if (p->decoder == NULL ||
        (p->learned != NULL && !decoder_learn(p->decoder, p->learned))) {
        return fail_for_memory(p);
    }
    skip(p);
    return become(p, PHASE_READING);
}

/* All frames of the record, or those that are left at the end. */
static enum play push(struct player *p)
{
    switch (p->has_record ? decoder_push(p->decoder, &p->record)
                          : decoder_flush(p->decoder)) {
    case DECODED_FRAME:
        return become(p, PHASE_SHOWING);
    case DECODED_ALL:
        if (p->has_record) {
            return become(p, PHASE_READING);
        }
        tell_end(p);
        return become(p, PHASE_ENDED);
    case DECODED_FAILED:
    default:
        return fail_for_memory(p);
    }
}

static enum play read_record(struct player *p)
{
    lum_error error = {""};
    const int status = lum_capture_next(p->capture, &p->record, &error);
    p->has_record = status > 0;
    if (status < 0) {
        p->broken = error;
    }
    if (!p->has_record) {
        return become(p, PHASE_FLUSHING);
    }
    if (decoder_is_lost(p->decoder) && p->scan != NULL) {
        scan_drop_places(p->scan);
        return playhead_restart(&p->head);
    }
    decoder_set_interface(p->decoder, lum_capture_interface(p->capture));
    p->phase = PHASE_PUSHING;
    return push(p);
}

static enum play read_some(struct player *p)
{
    enum play next = playhead_look(&p->head, p->decoder);
    for (unsigned i = 0;
         i < RECORDS_A_LOOK && next == PLAY_ON && p->phase == PHASE_READING;
         i++) {
        next = read_record(p);
    }
    return next;
}

static enum play show(struct player *p)
{
    struct picture *picture = decoder_picture(p->decoder);
    const enum play next = playhead_present(&p->head, p->decoder, picture);
    if (next == PLAY_SHOW) {
        const int64_t now_ns = lum_time_monotonic_ns();
        tell_frame(p, picture);
        stage_show(p->head.stage, picture, now_ns);
    }
    if (next == PLAY_SHOW || next == PLAY_ON) {
        return become(p, p->has_record ? PHASE_PUSHING : PHASE_FLUSHING);
    }
    return next;
}

/* --- Before the first pass --- */

/* A recording does not pass before somebody looks. */
static enum play await_look(struct player *p)
{
    const enum play next = playhead_begin(&p->head);
    if (next != PLAY_ON) {
        return next;
    }
    return become(p, p->scan != NULL ? PHASE_LEARNING : PHASE_OPENING);
}

/* The time of the first frames is then known as well as that of the rest. */
static enum play learn(struct player *p)
{
    if (stage_is_closing(p->head.stage)) {
        return PLAY_STOP;
    }
    return scan_learn(p->scan, &p->learned) ? become(p, PHASE_OPENING)
                                            : PLAY_ON;
}

/* --- Who takes the steps --- */

static enum play take_step(struct player *p)
{
    switch (p->phase) {
    case PHASE_UNWANTED:
        return await_look(p);
    case PHASE_LEARNING:
        return learn(p);
    case PHASE_OPENING:
        return open_pass(p);
    case PHASE_READING:
        return read_some(p);
    case PHASE_PUSHING:
    case PHASE_FLUSHING:
        return push(p);
    case PHASE_SHOWING:
        return show(p);
    case PHASE_ENDED:
        return playhead_end(&p->head, p->decoder);
    case PHASE_FAILED:
        return playhead_fail(&p->head);
    case PHASE_STOPPED:
    default:
        return PLAY_STOP;
    }
}

/* False: nothing is to be done before the head's time, or an order. */
static bool step(struct player *p)
{
    const enum play next = take_step(p);
    if (next == PLAY_REOPEN) {
        end_pass(p);
        p->phase = PHASE_OPENING;
    } else if (next == PLAY_STOP) {
        p->head.until_ns = INT64_MAX;
        p->phase = PHASE_STOPPED;
    }
    return next != PLAY_WAIT && next != PLAY_STOP;
}

static void *run(void *argument)
{
    struct player *p = argument;
    while (p->phase != PHASE_STOPPED) {
        if (!step(p) && p->phase != PHASE_STOPPED) {
            stage_wait(p->head.stage, p->head.serial, p->head.until_ns);
        }
    }
    return NULL;
}

/* The scan has the time that is left. */
int64_t player_work(struct player *player)
{
    const int64_t end_ns = lum_time_monotonic_ns() + WORK_NS;
    int64_t now_ns = 0;
    bool has_more = true;
    do {
        has_more = step(player) || scan_step(player->scan);
        now_ns = lum_time_monotonic_ns();
    } while (has_more && now_ns < end_ns);
    if (has_more || player->head.until_ns <= now_ns) {
        return 0;
    }
    const int64_t wait_ns = player->head.until_ns - now_ns;
    return wait_ns < SECOND_NS ? wait_ns : SECOND_NS;
}

/* --- Starting and ending --- */

static bool goes_on(void *stage)
{
    return !stage_is_closing(stage);
}

static int start(struct player *p, lum_error *error)
{
    p->go_on =
        (lum_go_on){.function = goes_on, .context = p->options.decoder.stage};
    if (captures_new(p->options.sources, p->options.rig, p->options.is_quiet,
                     &p->captures, error) != 0 ||
        (captures_are_files(p->captures) &&
         scan_start(p->captures, p->options.said, &p->options.decoder, &p->scan,
                    error) != 0)) {
        return -1;
    }
    playhead_init(&p->head, p->options.decoder.stage, p->scan);
    return thread_exists() ? thread_start(&p->thread, run, p, error) : 0;
}

static void release(struct player *p)
{
    decoder_free(p->decoder);
    lum_capture_close(p->capture);
    scan_end(p->scan);
    captures_free(p->captures);
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
    if (start(p, error) != 0) {
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
    thread_join(player->thread);
    release(player);
}
