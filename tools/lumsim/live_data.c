/* The data of a sensor on the network: of a scene or a recording, to its
 * client, when it is due. */
#include "live_sensor.h"

#define FRAMES_640 3u /* that are rendered */
#define SLICE_NS   INT64_C(500000)
#define LOOK_NS    INT64_C(10000000) /* for a reel to be done */
#define ROUNDS_MAX 2u                /* batches before the socket is served */

/* --- Where it comes from --- */

int live_open_data(struct live *live)
{
    const struct options *o = live->options;
    struct live_data *d = &live->data;
    d->has_link = true;
    d->scene.rate_hz = o->render.rate_hz;
    if (sender_open(&d->sender, &o->delivery, o->render.seed) != 0) {
        return lum_error_set(&live->error, "not enough memory");
    }
    return o->mode == MODE_REPLAY ? playback_open(&d->playback, o, &live->error)
                                  : renderer_open(&d->renderer, &live->error);
}

void live_close_data(struct live *live)
{
    renderer_close(live->data.renderer);
    lum_reel_free(live->data.scene.reel);
    playback_close(&live->data.playback);
    sender_close(&live->data.sender);
}

unsigned live_frames(const struct live *live)
{
    return live->options->frames > 0           ? (unsigned)live->options->frames
           : live->device.settings.lines == 64 ? FRAMES_USUAL
                                               : FRAMES_640;
}

void live_order(struct live *live)
{
    const lum_device_settings *s = &live->device.settings;
    struct render_order order = {.options = live->options->render};
    if (live->options->mode == MODE_REPLAY) {
        return;
    }
    order.options.lines = s->lines;
    order.frames = live_frames(live);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        order.is_aimed = lum_device_elevations(
            s, &order.options.layout, &order.options.calibration.eye[eye],
            order.elevations_udeg[eye]);
    }
    renderer_order(live->data.renderer, &order);
}

/* A line under way is sent whole before another reel takes its place. */
static bool may_fetch(struct live *live)
{
    const bool is_done = renderer_is_done(live->data.renderer);
    const bool is_over = scene_hold(&live->data.scene, is_done);
    return is_done && (is_over || !live->data.has_begun);
}

void live_fetch(struct live *live, int64_t now_ns)
{
    lum_reel *reel = NULL;
    lum_result result = LUM_OK;
    if (live->options->mode == MODE_REPLAY || !may_fetch(live) ||
        !renderer_fetch(live->data.renderer, &reel, &result)) {
        return;
    }
    if (result == LUM_OK) {
        sender_drop_borrowed(&live->data.sender);
        scene_load(&live->data.scene, reel, now_ns);
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

/* A new client gets the data from the present point on. */
void live_switch_data(struct live *live, int64_t now_ns)
{
    const bool streams = live->device.is_streaming;
    const bool begins = streams && !live->data.has_begun;
    live->data.has_begun = streams;
    if (!streams) {
        sender_drop(&live->data.sender);
    } else if (begins && live->options->mode == MODE_REPLAY) {
        playback_begin(&live->data.playback, now_ns);
    } else if (begins) {
        scene_begin(&live->data.scene, now_ns);
    }
}

void live_darken_data(struct live *live)
{
    sender_drop_borrowed(&live->data.sender);
    scene_darken(&live->data.scene, &live->device);
}

/* --- How it leaves --- */

static size_t take(struct live *live, int64_t now_ns, lum_outgoing *out,
                   size_t max)
{
    return live->options->mode == MODE_REPLAY
               ? playback_take(&live->data.playback, now_ns, out, max)
               : scene_take(&live->data.scene, &live->device, now_ns, out, max);
}

static void note_link(struct live *live, bool is_up, int64_t now_ns)
{
    if (is_up != live->data.has_link) {
        live->data.has_link = is_up;
        live_log_text(live, now_ns, is_up ? "link up" : "link down", "reason",
                      is_up ? "" : live->data.sender.error.text);
    }
}

static void send_what_is_due(struct live *live, int64_t now_ns)
{
    const lum_endpoint to = {live->device.client.address,
                             live->device.client.port};
    const uint64_t before = live->data.sender.sent;
    const bool flows =
        sender_send(&live->data.sender, live->socket, to, now_ns);
    if (!flows) {
        note_link(live, false, now_ns);
    } else if (live->data.sender.sent > before) {
        note_link(live, true, now_ns);
    }
}

/* Whether a whole batch was due: more may be. */
static bool stream_batch(struct live *live, int64_t now_ns)
{
    lum_outgoing datagrams[LUM_SOCKET_BATCH];
    const size_t room =
        sender_is_stuck(&live->data.sender) ? 0 : LUM_SOCKET_BATCH;
    const size_t n = take(live, now_ns, datagrams, room);
    if (live->is_silent) {
        live->counts.unsent += n;
    } else if (n > 0) {
        sender_put(&live->data.sender, datagrams, n, now_ns);
    }
    send_what_is_due(live, now_ns);
    return n > 0 && n == room;
}

void live_stream(struct live *live, int64_t now_ns)
{
    if (!live->device.is_streaming) {
        return;
    }
    for (unsigned i = 0; i < ROUNDS_MAX && stream_batch(live, now_ns); i++) {
    }
    live_log_round(live, now_ns);
    if (live->data.playback.has_failed) {
        live->has_failed = true;
        live->error = live->data.playback.error;
    }
    live_log_skipped(live, now_ns);
}

/* When data is due; data that is due soon waits for the data after it. */
static int64_t data_next_ns(const struct live *live, int64_t now_ns)
{
    const int64_t out_ns = sender_next_ns(&live->data.sender, now_ns);
    if (!live->device.is_streaming || sender_is_stuck(&live->data.sender)) {
        return out_ns;
    }
    const int64_t data_ns =
        earlier(out_ns, live->options->mode == MODE_REPLAY
                            ? playback_next_ns(&live->data.playback)
                            : scene_next_ns(&live->data.scene));
    return data_ns > now_ns && data_ns - now_ns < SLICE_NS ? now_ns + SLICE_NS
                                                           : data_ns;
}

int64_t live_stream_next_ns(const struct live *live, int64_t now_ns)
{
    const int64_t data_ns = data_next_ns(live, now_ns);
    return live->options->mode == MODE_SCENE &&
                   renderer_is_busy(live->data.renderer)
               ? earlier(data_ns, now_ns + LOOK_NS)
               : data_ns;
}
