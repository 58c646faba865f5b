#include "live_internal.h"

#include <string.h>

#define FRAMES_64  10u /* that are rendered */
#define FRAMES_640 3u
#define SLICE_NS   INT64_C(500000)
#define LOOK_NS    INT64_C(10000000) /* for a reel to be done */
#define ROUNDS_MAX 2u                /* batches before the socket is served */

void live_order(struct live *live)
{
    const lum_device_settings *s = &live->device.settings;
    struct order order = {.options = live->options->render};
    if (live->options->mode == MODE_REPLAY) {
        return;
    }
    order.options.lines = s->lines;
    order.frames = live->options->frames > 0 ? (unsigned)live->options->frames
                   : s->lines == 64          ? FRAMES_64
                                             : FRAMES_640;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        order.is_aimed = lum_device_elevations(
            s, &order.options.layout, &order.options.calibration.eye[eye],
            order.elevations_udeg[eye]);
    }
    studio_order(live->studio, &order);
}

/* A line under way is sent whole before another reel takes its place. */
static bool may_fetch(struct live *live)
{
    const bool is_done = studio_is_done(live->studio);
    const bool is_over = scene_hold(&live->scene, is_done);
    return is_done && (is_over || !live->is_sending);
}

void live_fetch(struct live *live, int64_t now_ns)
{
    lum_reel *reel = NULL;
    lum_result result = LUM_OK;
    if (live->options->mode == MODE_REPLAY || !may_fetch(live) ||
        !studio_fetch(live->studio, &reel, &result)) {
        return;
    }
    if (result == LUM_OK) {
        outlet_drop_borrowed(&live->outlet);
        scene_load(&live->scene, reel, now_ns);
        live_log_frames(live, now_ns);
    } else {
        live->has_failed = true;
        (void)lum_error_set(&live->error,
                            result == LUM_E_SPACE
                                ? "not enough memory for the frames; fewer "
                                  "(--frames) need less"
                                : "the frames do not fit the profile");
    }
}

void live_begin_data(struct live *live, int64_t now_ns)
{
    if (live->options->mode == MODE_REPLAY) {
        playback_begin(&live->playback, now_ns);
    } else {
        scene_begin(&live->scene, now_ns);
    }
}

void live_end_data(struct live *live)
{
    outlet_drop(&live->outlet);
}

static size_t take(struct live *live, int64_t now_ns, struct parcel *out,
                   size_t max)
{
    return live->options->mode == MODE_REPLAY
               ? playback_take(&live->playback, now_ns, out, max)
               : scene_take(&live->scene, &live->device, now_ns, out, max);
}

static void note_link(struct live *live, bool is_up, int64_t now_ns)
{
    if (is_up != live->has_link) {
        live->has_link = is_up;
        live_log_text(live, now_ns, is_up ? "link up" : "link down", "reason",
                      is_up ? "" : live->outlet.error.text);
    }
}

static void send_what_is_due(struct live *live, int64_t now_ns)
{
    const lum_endpoint to = {live->device.client.address,
                             live->device.client.port};
    const uint64_t before = live->outlet.sent;
    const bool flows = outlet_send(&live->outlet, live->socket, to, now_ns);
    if (!flows) {
        note_link(live, false, now_ns);
    } else if (live->outlet.sent > before) {
        note_link(live, true, now_ns);
    }
}

/* Whether a whole batch was due: more may be. */
static bool stream_batch(struct live *live, int64_t now_ns)
{
    struct parcel parcels[LUM_SOCKET_BATCH];
    const size_t room = outlet_room(&live->outlet);
    const size_t n = take(live, now_ns, parcels, room);
    if (live->is_silent) {
        live->unsent += n;
    } else if (n > 0) {
        outlet_put(&live->outlet, parcels, n, now_ns);
    }
    send_what_is_due(live, now_ns);
    return n > 0 && n == room;
}

static void fail_with(struct live *live, const lum_error *error)
{
    live->has_failed = true;
    live->error = *error;
}

void live_stream(struct live *live, int64_t now_ns)
{
    if (!live->device.is_streaming) {
        return;
    }
    for (unsigned i = 0; i < ROUNDS_MAX && stream_batch(live, now_ns); i++) {
    }
    if (live->playback.rounds > live->rounds) {
        live->rounds = live->playback.rounds;
        live_log_round(live, now_ns);
    }
    if (live->playback.has_failed) {
        fail_with(live, &live->playback.error);
    }
    live_log_skipped(live, now_ns);
}

static int64_t earlier(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* When data is due; data that is due soon waits for the data after it. */
static int64_t data_next_ns(const struct live *live, int64_t now_ns)
{
    const int64_t out_ns = outlet_next_ns(&live->outlet, now_ns);
    if (!live->device.is_streaming || outlet_is_stuck(&live->outlet)) {
        return out_ns;
    }
    const int64_t data_ns =
        earlier(out_ns, live->options->mode == MODE_REPLAY
                            ? playback_next_ns(&live->playback)
                            : scene_next_ns(&live->scene));
    return data_ns > now_ns && data_ns - now_ns < SLICE_NS ? now_ns + SLICE_NS
                                                           : data_ns;
}

int64_t live_stream_next_ns(const struct live *live, int64_t now_ns)
{
    const int64_t data_ns = data_next_ns(live, now_ns);
    return live->options->mode == MODE_SCENE && studio_is_busy(live->studio)
               ? earlier(data_ns, now_ns + LOOK_NS)
               : data_ns;
}
