/* The data of a sensor on the network: of a scene or a recording, to its
 * client, when it is due. */
#include "live_sensor.h"

#include <stdlib.h>
#include <string.h>

#define FRAMES_640 3u /* that are rendered */
#define SLICE_NS   INT64_C(500000)
#define LOOK_NS    INT64_C(10000000) /* for a reel to be done */
#define ROUNDS_MAX 2u                /* batches before the socket is served */
#define BYTES_MAX  262144u           /* of packets given at once */

/* --- A recording, sent with its timing --- */

static void playback_close(struct playback *playback)
{
    recording_close(playback->recording);
    playback->recording = NULL;
    free(playback->bytes);
    playback->bytes = NULL;
}

/* Look through the capture and open it. */
static int playback_open(struct playback *out, const struct options *o,
                         lum_error *error)
{
    *out =
        (struct playback){.speed = o->replay.speed, .loops = o->replay.loops};
    if (recording_open(o->replay.path, &o->render.layout, &o->replay.sensor,
                       &out->recording, &out->facts, error) != 0) {
        return -1;
    }
    if (!sender_is_direct(&o->delivery) &&
        out->facts.longest > LUM_PACKET_BYTES_MAX) {
        playback_close(out);
        return lum_error_set(error,
                             "%s: has packets of %zu bytes; faults and jitter "
                             "are for packets of at most %u",
                             o->replay.path, out->facts.longest,
                             LUM_PACKET_BYTES_MAX);
    }
    out->bytes = malloc(BYTES_MAX);
    if (out->bytes == NULL) {
        playback_close(out);
        return lum_error_set(error, "not enough memory");
    }
    return 0;
}

static void read_next(struct playback *p)
{
    const int result = recording_next(p->recording, &p->next, &p->error);
    p->has_next = result > 0;
    p->has_failed = result < 0;
}

static void playback_begin(struct playback *playback, int64_t begin_ns)
{
    playback->begin_ns = begin_ns;
    playback->has_ended = false;
    playback->has_next = false;
    if (recording_rewind(playback->recording, &playback->error) != 0) {
        playback->has_failed = true;
        return;
    }
    read_next(playback);
}

static int64_t after_begin_ns(const struct playback *p, int64_t time_ns)
{
    return p->begin_ns +
           (int64_t)((double)(time_ns - p->facts.first_ns) / p->speed);
}

/* The next round follows the last packet at the mean distance of packets. */
static int64_t next_round_ns(const struct playback *p)
{
    const double span_ns = (double)(p->facts.last_ns - p->facts.first_ns);
    const double step_ns =
        p->facts.packets > 1 ? span_ns / (double)(p->facts.packets - 1) : 1e9;
    return p->begin_ns + (int64_t)((span_ns + step_ns) / p->speed);
}

/* Whether there is a packet to come, of this round or the next. */
static bool look_ahead(struct playback *p)
{
    if (p->has_next) {
        return true;
    }
    if (p->has_ended || p->has_failed) {
        return false;
    }
    p->rounds++;
    if (!p->loops) {
        p->has_ended = true;
        return false;
    }
    playback_begin(p, next_round_ns(p));
    return p->has_next;
}

/* A host that was held up does not make up for it in one burst. */
static void shift_if_late(struct playback *p, int64_t now_ns)
{
    const int64_t due_ns = after_begin_ns(p, p->next.time_ns);
    if (now_ns - due_ns > FEED_LAG_MAX_NS) {
        p->delayed_ns += now_ns - due_ns;
        p->begin_ns += now_ns - due_ns;
    }
}

/* Up to max datagrams that are due. */
static size_t playback_take(struct playback *playback, int64_t now_ns,
                            lum_outgoing *out, size_t max)
{
    size_t n = 0;
    size_t used = 0;
    while (n < max && look_ahead(playback)) {
        shift_if_late(playback, now_ns);
        const struct recorded *next = &playback->next;
        if (after_begin_ns(playback, next->time_ns) > now_ns ||
            next->len > BYTES_MAX - used) {
            break;
        }
        memcpy(playback->bytes + used, next->bytes, next->len);
        out[n++] =
            (lum_outgoing){.bytes = playback->bytes + used, .len = next->len};
        used += next->len;
        read_next(playback);
    }
    return n;
}

static int64_t playback_next_ns(const struct playback *playback)
{
    return playback->has_next ? after_begin_ns(playback, playback->next.time_ns)
                              : INT64_MAX;
}

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
