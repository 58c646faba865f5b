#include "playback.h"

#include "sender.h"

#include <stdlib.h>
#include <string.h>

#define BYTES_MAX 262144u /* of packets given at once */

int playback_open(struct playback *out, const struct options *o,
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

void playback_close(struct playback *playback)
{
    recording_close(playback->recording);
    playback->recording = NULL;
    free(playback->bytes);
    playback->bytes = NULL;
}

static void read_next(struct playback *p)
{
    const int result = recording_next(p->recording, &p->next, &p->error);
    p->has_next = result > 0;
    p->has_failed = result < 0;
}

void playback_begin(struct playback *playback, int64_t begin_ns)
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

size_t playback_take(struct playback *playback, int64_t now_ns,
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

int64_t playback_next_ns(const struct playback *playback)
{
    return playback->has_next ? after_begin_ns(playback, playback->next.time_ns)
                              : INT64_MAX;
}
