/* The thread that plays captures: it opens and reads them, again and again,
 * and gives complete frames to the page where the playhead says so. */
#define _POSIX_C_SOURCE 200809L
#include "player.h"

#include "captures.h"
#include "playhead.h"
#include "report.h"
#include "scan.h"
#include "thread.h"

#include "lum/base/time.h"

#include <stdlib.h>

/* Records between looks at orders. */
#define RECORDS_A_LOOK 64u

struct player {
    struct player_options options;
    pthread_t thread;
    struct captures *captures;
    struct scan *scan; /* NULL: they can be read once */

    /* the thread's */
    struct playhead head;
    struct report report;
    lum_capture *capture;
    struct decoder *decoder;
    struct decoder *learned; /* of the beginning of files; NULL: nothing */
};

/* --- Reading --- */

/* An error that stays until somebody wants to go elsewhere. */
static enum play fail(struct player *p, const lum_error *error)
{
    stage_set_text(p->head.stage, FEED_MESSAGE, error->text);
    stage_set_state(p->head.stage, FEED_FAILED);
    return playhead_fail(&p->head);
}

static enum play fail_for_memory(struct player *p)
{
    lum_error error;
    (void)lum_error_set(&error, "%s: out of memory", p->options.sources->name);
    return fail(p, &error);
}

static enum play present(struct player *p)
{
    struct picture *picture = decoder_picture(p->decoder);
    const enum play next = playhead_present(&p->head, p->decoder, picture);
    if (next != PLAY_SHOW) {
        return next;
    }
    const int64_t now_ns = lum_time_monotonic_ns();
    report_frame(&p->report, p->capture, p->decoder, picture);
    stage_show(p->head.stage, picture, now_ns);
    return PLAY_ON;
}

/* All frames of a record, or those that are left at the end: record is NULL. */
static enum play take(struct player *p, const lum_record *record)
{
    for (;;) {
        const enum decoded decoded = record != NULL
                                         ? decoder_push(p->decoder, record)
                                         : decoder_flush(p->decoder);
        if (decoded != DECODED_FRAME) {
            return decoded == DECODED_ALL ? PLAY_ON : fail_for_memory(p);
        }
        const enum play next = present(p);
        if (next != PLAY_ON) {
            return next;
        }
    }
}

static enum play read_all(struct player *p)
{
    lum_record record;
    lum_error error = {""};
    int status = 1;
    for (uint64_t i = 0; status > 0; i++) {
        enum play next = i % RECORDS_A_LOOK == 0
                             ? playhead_look(&p->head, p->decoder)
                             : PLAY_ON;
        if (next == PLAY_ON) {
            status = captures_next(p->captures, p->capture, &record, &error);
        }
        if (next == PLAY_ON && status > 0) {
            decoder_set_interface(p->decoder,
                                  lum_capture_interface(p->capture));
            next = take(p, &record);
        }
        if (next != PLAY_ON) {
            return next;
        }
    }
    if (status < 0) {
        p->report.broken = error;
    }
    return take(p, NULL);
}

static enum play pass(struct player *p)
{
    lum_error error = {""};
    if (captures_open(p->captures, &p->capture, &error) != 0) {
        return fail(p, &error);
    }
    captures_tell_others(p->captures, p->capture, p->options.said,
                         p->head.stage);
    p->decoder = decoder_new(&p->options.decoder);
    if (p->decoder == NULL ||
        (p->learned != NULL && !decoder_learn(p->decoder, p->learned))) {
        return fail_for_memory(p);
    }
    if (p->head.from != INT64_MIN) {
        decoder_skip_to(p->decoder, p->head.from);
    }
    const enum play next = read_all(p);
    if (next != PLAY_ON) {
        return next;
    }
    report_end(&p->report, p->capture, p->decoder);
    return playhead_end(&p->head, p->decoder);
}

static void end_pass(struct player *p)
{
    if (p->decoder != NULL) {
        report_add_pass(&p->report, p->decoder);
    }
    decoder_free(p->decoder);
    lum_capture_close(p->capture);
    p->decoder = NULL;
    p->capture = NULL;
}

/* A recording does not pass before somebody looks. The time of the first frames
 * is known as well as that of the rest. */
static void *run(void *argument)
{
    struct player *p = argument;
    enum play next = stage_wait_wanted(p->head.stage) ? PLAY_REOPEN : PLAY_STOP;
    if (next != PLAY_STOP) {
        p->learned = scan_learn(p->captures, &p->options.decoder);
    }
    while (next != PLAY_STOP) {
        next = pass(p);
        end_pass(p);
    }
    return NULL;
}

/* --- Starting and ending --- */

static int start(struct player *p, lum_error *error)
{
    if (captures_new(p->options.sources, p->options.rig, p->options.is_quiet,
                     &p->captures, error) != 0 ||
        (captures_are_files(p->captures) &&
         scan_start(p->captures, p->options.said, &p->options.decoder, &p->scan,
                    error) != 0)) {
        return -1;
    }
    playhead_init(&p->head, p->options.decoder.stage, p->scan);
    p->report = (struct report){.options = &p->options,
                                .captures = p->captures,
                                .is_scanned = p->scan != NULL};
    return thread_start(&p->thread, run, p, error);
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
    captures_stop(player->captures);
    (void)pthread_join(player->thread, NULL);
    release(player);
}
