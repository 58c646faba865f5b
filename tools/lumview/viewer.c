#define _POSIX_C_SOURCE 200809L
#include "viewer.h"

#include "core/bytes.h"
#include "lum/base/time.h"
#include "lum/frame/packed.h"

#include <stdlib.h>
#include <string.h>

#define AT_COUNT 52u /* of the frames shown so far; see lum/frame/packed.h */

/* A frame that is sent within this time is sent whole. */
#define PATIENCE_NS INT64_C(250000000)

static const struct feed_view default_view = {LUM_EDGES_RISING, 0};

/* --- Viewers and the views they want --- */

int viewers_init(struct viewers *viewers, const struct options *options,
                 size_t room_before)
{
    *viewers = (struct viewers){.options = options, .room_before = room_before};
    viewers->piece = malloc(room_before + LUM_PACKED_PIECE_BYTES);
    return viewers->piece != NULL ? 0 : -1;
}

void viewers_free(struct viewers *viewers)
{
    free(viewers->piece);
    free(viewers->text.memory);
}

/* Those of all browsers but one. */
static struct feed_views collect_views(const struct viewers *viewers,
                                       const struct viewer *but)
{
    struct feed_views views = {.count = 0};
    for (const struct viewer *v = viewers->first; v != NULL; v = v->next) {
        if (v != but && views.count < FEED_VIEWS_MAX &&
            feed_views_find(&views, &v->view) == views.count) {
            views.at[views.count++] = v->view;
        }
    }
    return views;
}

static void want_views(struct viewers *viewers)
{
    const struct feed_views views = collect_views(viewers, NULL);
    if (viewers->feed != NULL) {
        feed_want(viewers->feed, views.at, views.count);
    }
}

/* As many as the browser that shows most. */
static void keep_frames(const struct viewers *viewers)
{
    unsigned most = 1;
    for (const struct viewer *v = viewers->first; v != NULL; v = v->next) {
        most = v->frames > most ? v->frames : most;
    }
    if (viewers->feed != NULL) {
        feed_keep(viewers->feed, most);
    }
}

/* Where all places are taken, a browser keeps the view that it has. */
static void set_view(struct viewers *viewers, struct viewer *viewer,
                     const struct feed_view *view)
{
    const struct feed_views views = collect_views(viewers, viewer);
    if (views.count < FEED_VIEWS_MAX ||
        feed_views_find(&views, view) < views.count) {
        viewer->view = *view;
        viewer->past = 0;
        want_views(viewers);
    }
}

void viewers_add(struct viewers *viewers, struct viewer *viewer)
{
    const struct feed_views views = collect_views(viewers, NULL);
    *viewer = (struct viewer){.frames = 1, .wants_status = true};
    viewer->view = views.count < FEED_VIEWS_MAX ? default_view : views.at[0];
    viewer->next = viewers->first;
    viewers->first = viewer;
    viewers->status.browsers++;
    want_views(viewers);
}

void viewers_remove(struct viewers *viewers, struct viewer *viewer)
{
    struct viewer **at = &viewers->first;
    while (*at != NULL && *at != viewer) {
        at = &(*at)->next;
    }
    if (*at == NULL) {
        return;
    }
    *at = viewer->next;
    viewers->status.browsers--;
    frame_release(viewer->frame);
    viewer->frame = NULL;
    want_views(viewers);
    keep_frames(viewers);
}

/* --- Waking --- */

static bool is_newer(const struct viewer *viewer, struct frame *frame)
{
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    return !viewer->has_last ||
           memcmp(bytes, viewer->last, sizeof viewer->last) != 0;
}

static bool has_newer(const struct viewers *viewers,
                      const struct viewer *viewer)
{
    struct frame *frame = feed_newest(viewers->feed, &viewer->view);
    const bool out = frame != NULL && is_newer(viewer, frame);
    frame_release(frame);
    return out;
}

static void update(struct viewers *viewers, const struct feed_status *now,
                   int64_t now_ns, bool at_tick)
{
    if (now->marks != viewers->status.feed.marks) {
        feed_look_marks(viewers->feed, &viewers->status.marks);
    }
    status_update(&viewers->status, now, now_ns, at_tick);
}

void viewers_wake(struct viewers *viewers)
{
    struct feed_status now;
    if (viewers->feed == NULL) {
        return;
    }
    feed_look(viewers->feed, &now);
    const bool differs = status_differs(&viewers->status.feed, &now);
    if (differs) {
        update(viewers, &now, 0, false);
    }
    for (struct viewer *v = viewers->first; v != NULL; v = v->next) {
        v->wants_status = v->wants_status || differs;
    }
}

void viewers_tick(struct viewers *viewers)
{
    struct feed_status now;
    feed_look(viewers->feed, &now);
    update(viewers, &now, lum_time_monotonic_ns(), true);
    for (struct viewer *v = viewers->first; v != NULL; v = v->next) {
        v->wants_status = true;
    }
}

/* --- The next message --- */

static int give_text(struct viewers *viewers, int failed,
                     struct viewer_message *out)
{
    if (failed != 0) {
        viewers->text.memory = NULL;
        return -1;
    }
    *out =
        (struct viewer_message){.bytes = (unsigned char *)viewers->text.bytes,
                                .len = viewers->text.len,
                                .is_text = true};
    return 1;
}

static int give_hello(struct viewers *viewers, struct viewer *viewer,
                      struct viewer_message *out)
{
    viewer->had_hello = true;
    return give_text(viewers,
                     status_hello(viewers->options, viewers->feed,
                                  viewers->room_before, &viewers->text),
                     out);
}

static int give_status(struct viewers *viewers, struct viewer *viewer,
                       struct viewer_message *out)
{
    const unsigned marks = viewers->status.feed.marks;
    const bool has_marks = viewer->marks == marks;
    viewer->wants_status = false;
    viewer->marks = marks;
    return give_text(viewers,
                     status_text(&viewers->status, viewer->skipped, has_marks,
                                 viewers->room_before, &viewers->text),
                     out);
}

static int give_piece(struct viewers *viewers, struct viewer *viewer,
                      struct viewer_message *out)
{
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(viewer->frame, &len);
    *out = (struct viewer_message){
        .bytes = viewers->piece + viewers->room_before,
        .len = frame_piece(viewer->frame, viewer->sent)};
    (void)memcpy(out->bytes, bytes + viewer->sent, out->len);
    viewer->sent += out->len;
    if (viewer->sent == len) {
        frame_release(viewer->frame);
        viewer->frame = NULL;
    }
    return 1;
}

/* Frames between the last one and this were never sent. */
static void count_skipped(struct viewer *viewer, const uint8_t *head)
{
    const uint32_t step =
        load_u32(head + AT_COUNT) - load_u32(viewer->last + AT_COUNT);
    if (viewer->has_last && step > 1u && step < UINT32_MAX / 2u) {
        viewer->skipped += step - 1u;
    }
    (void)memcpy(viewer->last, head, sizeof viewer->last);
    viewer->has_last = true;
}

/* The newest that was asked for and that there is; NULL: none. */
static struct frame *take_past(const struct viewers *viewers,
                               struct viewer *viewer)
{
    struct frame *frame = NULL;
    for (int64_t i = 1; viewer->past != 0 && frame == NULL; i++) {
        if ((viewer->past & 1u) != 0) {
            frame = feed_past(viewers->feed, &viewer->view,
                              viewer->past_before - i);
        }
        viewer->past >>= 1;
        viewer->past_before -= frame != NULL ? i : 0;
    }
    return frame;
}

/* Those that were asked for come behind the newest. */
static int begin_frame(struct viewers *viewers, struct viewer *viewer,
                       struct viewer_message *out)
{
    size_t len = 0;
    struct frame *frame = feed_newest(viewers->feed, &viewer->view);
    const bool is_past = frame == NULL || !is_newer(viewer, frame);
    if (!is_past) {
        count_skipped(viewer, frame_bytes(frame, &len));
    } else {
        frame_release(frame);
        frame = take_past(viewers, viewer);
    }
    viewer->frame = frame;
    viewer->sent = 0;
    viewer->is_past = is_past;
    viewer->begin_ns = lum_time_monotonic_ns();
    return frame != NULL ? give_piece(viewers, viewer, out) : 0;
}

/* An eighth of a frame is a picture, and what was asked for can be asked for
 * again. */
static void leave_old(struct viewers *viewers, struct viewer *viewer)
{
    size_t len = 0;
    (void)frame_bytes(viewer->frame, &len);
    if (lum_time_monotonic_ns() - viewer->begin_ns > PATIENCE_NS &&
        (viewer->is_past || viewer->sent >= len / 8u) &&
        has_newer(viewers, viewer)) {
        viewer->skipped += viewer->is_past ? 0 : 1u;
        frame_release(viewer->frame);
        viewer->frame = NULL;
    }
}

bool viewer_has_next(const struct viewers *viewers, const struct viewer *viewer)
{
    return viewer->frame != NULL || !viewer->had_hello ||
           viewer->wants_status || viewer->past != 0 ||
           (viewers->feed != NULL && has_newer(viewers, viewer));
}

int viewer_next(struct viewers *viewers, struct viewer *viewer,
                struct viewer_message *out)
{
    free(viewers->text.memory);
    viewers->text.memory = NULL;
    if (!viewer->had_hello) {
        return give_hello(viewers, viewer, out);
    }
    if (viewer->wants_status) {
        return give_status(viewers, viewer, out);
    }
    if (viewer->frame != NULL) {
        leave_old(viewers, viewer);
    }
    if (viewer->frame != NULL) {
        return give_piece(viewers, viewer, out);
    }
    return begin_frame(viewers, viewer, out);
}

/* --- Commands --- */

static void obey(struct viewers *viewers, struct viewer *viewer,
                 const struct command *command)
{
    struct feed *feed = viewers->feed;
    switch (command->kind) {
    case COMMAND_VIEW:
        set_view(viewers, viewer, &command->view);
        break;
    case COMMAND_FRAMES:
        viewer->frames = (unsigned)command->number;
        keep_frames(viewers);
        break;
    case COMMAND_PAST:
        viewer->past_before = command->number;
        viewer->past = command->past;
        break;
    case COMMAND_PLAY:
    case COMMAND_PAUSE:
        feed_play(feed, command->kind == COMMAND_PLAY);
        break;
    case COMMAND_STEP:
        feed_step(feed, command->number);
        break;
    case COMMAND_SEEK:
        feed_seek(feed, command->number);
        break;
    case COMMAND_SPEED:
        feed_speed(feed, command->speed);
        break;
    case COMMAND_LOOP:
    default:
        feed_loop(feed, command->loops);
        break;
    }
}

bool viewer_take(struct viewers *viewers, struct viewer *viewer,
                 const char *text, size_t len)
{
    struct command command;
    if (len > COMMAND_BYTES || !command_parse(text, len, &command)) {
        return false;
    }
    obey(viewers, viewer, &command);
    return true;
}
