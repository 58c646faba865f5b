/* What happens to a sensor on the network becomes lines of the log. */
#include "live_sensor.h"

#include "../common/number.h"
#include "lum/wire.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(_WIN32)
#include <share.h>
#else
#include "base/outfile_io.h"
#endif

#define QUIET_NS INT64_C(100000000) /* between two lines about a flood */

static const char *const kinds[LUM_PACKET_KINDS] = {
    [LUM_PACKET_DATA] = "data",
    [LUM_PACKET_HEARTBEAT] = "heartbeat",
    [LUM_PACKET_SET_IP] = "set_ip",
    [LUM_PACKET_TIMESTAMP] = "timestamp",
    [LUM_PACKET_TLV] = "tlv",
    [LUM_PACKET_FOREIGN] = "foreign",
    [LUM_PACKET_UNKNOWN_TYPE] = "unknown_type",
    [LUM_PACKET_MALFORMED] = "malformed",
    [LUM_PACKET_UNKNOWN_TAG] = "unknown_tag"};

/* --- The file --- */

#if defined(_WIN32)
struct log_file {
    FILE *stream;
};

/* The system keeps other writers away. */
static int open_file(const char *path, struct log_file **out, FILE **stream,
                     lum_error *error)
{
    struct log_file *file = calloc(1, sizeof *file);
    if (file == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    file->stream = _fsopen(path, "w", _SH_DENYWR);
    if (file->stream == NULL) {
        (void)lum_error_set(error, "%s: cannot be written: %s", path,
                            strerror(errno));
        free(file);
        return -1;
    }
    *stream = file->stream;
    *out = file;
    return 0;
}

static int close_file(struct log_file *file)
{
    const int reason = fclose(file->stream) == 0 ? 0 : errno;
    free(file);
    return reason;
}
#else
struct log_file {
    lum_outfile out;
    FILE *stream; /* of a second descriptor */
};

static int close_file(struct log_file *file)
{
    const bool is_whole = file->stream != NULL && fclose(file->stream) == 0 &&
                          lum_outfile_finish(&file->out, NULL) == 0;
    const int reason = is_whole ? 0 : errno;
    lum_outfile_discard(&file->out);
    free(file);
    return reason;
}

static int open_file(const char *path, struct log_file **out, FILE **stream,
                     lum_error *error)
{
    struct log_file *file = calloc(1, sizeof *file);
    if (file == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    if (lum_outfile_open(path, LUM_OUTFILE_GROWS, &file->out, error) != 0) {
        free(file);
        return -1;
    }
    file->stream = lum_outfile_stream(&file->out);
    if (file->stream == NULL) {
        (void)lum_outfile_fail(&file->out, errno, "cannot be written", error);
    } else if (lum_outfile_show(&file->out, error) == 0) {
        *stream = file->stream;
        *out = file;
        return 0;
    }
    (void)close_file(file);
    return -1;
}
#endif

/* --- Its lines --- */

int live_open_log(struct live *live)
{
    const char *path = live->options->live.log;
    struct live_log *log = &live->log;
    lum_error why = {""};
    if (path == NULL) {
        return 0;
    }
    if (strcmp(path, "-") == 0) {
        log->out = stdout;
    } else if (open_file(path, &log->file, &log->out, &why) != 0) {
        return lum_error_set(&live->error, "--log: %s", why.text);
    }
    return 0;
}

struct json *live_begin_line(struct live *live, int64_t t_ns, const char *event)
{
    struct json *json = &live->log.json;
    json_begin_line(json, live->log.out);
    json_real(json, "t", (double)t_ns / 1e9, 6);
    json_text(json, "event", event);
    return json;
}

void live_end_line(struct live *live)
{
    struct live_log *log = &live->log;
    json_end_line(&log->json);
    if (log->out != NULL && (fflush(log->out) != 0 || ferror(log->out))) {
        log->reason = errno != 0 ? errno : EIO;
        log->out = NULL;
    }
}

int live_close_log(struct live *live)
{
    struct live_log *log = &live->log;
    if (log->file != NULL) {
        const int reason = close_file(log->file);
        log->reason = log->reason != 0 ? log->reason : reason;
    }
    log->out = NULL;
    log->file = NULL;
    return log->reason;
}

/* --- What happens --- */

const char *live_name(uint32_t address, uint16_t port, char out[24])
{
    (void)snprintf(out, 24, "%s:%u", number_address(address).text,
                   (unsigned)port);
    return out;
}

static void add_address(struct json *json, const char *key, uint32_t address)
{
    json_text(json, key, number_address(address).text);
}

static void add_peer(struct json *json, const char *key, uint32_t address,
                     uint16_t port)
{
    char name[24];
    json_text(json, key, live_name(address, port, name));
}

void live_log_text(struct live *live, int64_t t_ns, const char *event,
                   const char *key, const char *text)
{
    struct json *json = live_begin_line(live, t_ns, event);
    json_text(json, key, text);
    live_end_line(live);
}

void live_log_start(struct live *live)
{
    struct json *json = live_begin_line(live, live->start_ns, "start");
    add_peer(json, "address", live->self.address, live->self.port);
    json_uint(json, "clock_us",
              lum_device_clock_us(&live->device, live->start_ns));
    if (live->options->mode == MODE_REPLAY) {
        json_text(json, "replay", live->options->replay.path);
        json_uint(json, "packets", live->data.playback.facts.packets);
    } else {
        json_uint(json, "lines", live->options->render.lines);
        json_real(json, "rate_hz", live->options->render.rate_hz, 3);
    }
    live_end_line(live);
}

static bool is_ignored(lum_packet_kind kind)
{
    return kind == LUM_PACKET_DATA || kind >= LUM_PACKET_FOREIGN;
}

/* The latest of them; NULL: only how many came since the last line. */
static void log_ignored(struct live *live, int64_t t_ns, lum_packet_kind kind,
                        const lum_received *datagram)
{
    struct json *json = live_begin_line(live, t_ns, "ignored");
    if (datagram != NULL) {
        add_peer(json, "from", datagram->from.address, datagram->from.port);
        json_text(json, "kind", kinds[kind]);
        json_uint(json, "len", datagram->len);
    }
    json_uint(json, "count", live->log.ignored);
    live_end_line(live);
    live->log.ignored_ns = t_ns;
    live->log.ignored = 0;
}

/* During a flood only this many lines a second. */
static bool may_log_ignored(const struct live *live, int64_t t_ns)
{
    return live->log.ignored > 0 && t_ns - live->log.ignored_ns >= QUIET_NS;
}

void live_flush_ignored(struct live *live, int64_t now_ns)
{
    if (may_log_ignored(live, now_ns)) {
        log_ignored(live, now_ns, LUM_PACKET_FOREIGN, NULL);
    }
}

static void add_sequence(struct json *json, const void *bytes, size_t len)
{
    lum_tlv_reader reader;
    lum_timestamp stamp;
    uint32_t sequence = 0;
    if (lum_timestamp_decode(bytes, len, &stamp) == LUM_OK) {
        json_uint(json, "sequence", stamp.sequence);
        json_uint(json, "clock_us", stamp.clock_us);
    } else if (lum_tlv_open(bytes, len, &sequence, &reader) == LUM_OK) {
        json_uint(json, "sequence", sequence);
    }
}

void live_log_received(struct live *live, int64_t t_ns, lum_packet_kind kind,
                       const lum_received *datagram, const char *note)
{
    uint32_t address = 0;
    if (is_ignored(kind)) {
        live->log.ignored++;
        if (may_log_ignored(live, t_ns)) {
            log_ignored(live, t_ns, kind, datagram);
        }
        return;
    }
    struct json *json = live_begin_line(live, t_ns, kinds[kind]);
    add_peer(json, "from", datagram->from.address, datagram->from.port);
    add_sequence(json, datagram->bytes, datagram->len);
    if (lum_set_ip_decode(&live->device.layout, datagram->bytes, datagram->len,
                          &address) == LUM_OK) {
        add_address(json, "address", address);
    }
    if (note[0] != '\0' && strcmp(note, kinds[kind]) != 0) {
        json_text(json, "note", note);
    }
    live_end_line(live);
}

void live_log_reply(struct live *live, int64_t t_ns, lum_device_peer to,
                    const void *bytes, size_t len, bool is_lost)
{
    struct json *json = live_begin_line(live, t_ns, "reply");
    lum_group group;
    add_peer(json, "to", to.address, to.port);
    json_text(
        json, "kind",
        kinds[lum_packet_decode(&live->device.layout, bytes, len, &group)]);
    add_sequence(json, bytes, len);
    json_bool(json, "lost", is_lost);
    live_end_line(live);
}

static void log_stream(struct live *live, int64_t now_ns)
{
    const lum_device *d = &live->device;
    struct json *json = live_begin_line(live, now_ns, "stream");
    if (d->is_streaming) {
        add_peer(json, "to", d->client.address, d->client.port);
    } else {
        json_null(json, "to");
    }
    json_uint(json, "packets", live->data.sender.sent);
    live_end_line(live);
}

void live_log_state(struct live *live, const lum_device_effects *effects,
                    int64_t now_ns)
{
    if (effects->status_changed) {
        struct json *json = live_begin_line(live, now_ns, "status");
        json_uint(json, "status", live->device.status);
        json_laser_bits(json, "bits", live->device.status);
        live_end_line(live);
    }
    if (effects->laser_changed) {
        struct json *json = live_begin_line(live, now_ns, "laser");
        json_bool(json, "up", lum_device_laser_is_up(&live->device));
        live_end_line(live);
    }
    if (effects->streaming_changed) {
        log_stream(live, now_ns);
    }
}

void live_log_move(struct live *live, int64_t now_ns, uint32_t address,
                   const char *reason)
{
    struct json *json = live_begin_line(live, now_ns, "move");
    add_address(json, "address", address);
    json_bool(json, "done", reason == NULL);
    if (reason != NULL) {
        json_text(json, "reason", reason);
    }
    live_end_line(live);
}

void live_log_frames(struct live *live, int64_t now_ns)
{
    struct json *json = live_begin_line(live, now_ns, "frames");
    json_uint(json, "frames", lum_reel_frames(live->data.scene.reel));
    json_uint(json, "lines", lum_reel_lines(live->data.scene.reel));
    live_end_line(live);
}

/* The replay came to its end once more. */
void live_log_round(struct live *live, int64_t now_ns)
{
    if (live->data.playback.rounds == live->log.rounds) {
        return;
    }
    live->log.rounds = live->data.playback.rounds;
    struct json *json = live_begin_line(live, now_ns, "replayed");
    json_uint(json, "rounds", live->log.rounds);
    json_uint(json, "packets", live->data.sender.sent);
    live_end_line(live);
}

void live_log_skipped(struct live *live, int64_t now_ns)
{
    const uint64_t skipped = live->data.scene.lines_skipped - live->log.skipped;
    if (skipped == 0 || now_ns - live->log.skipped_ns < QUIET_NS) {
        return;
    }
    struct json *json = live_begin_line(live, now_ns, "skipped");
    json_uint(json, "lines", skipped);
    live_end_line(live);
    live->log.skipped_ns = now_ns;
    live->log.skipped = live->data.scene.lines_skipped;
}

static void add_counts(struct json *json, const struct live *live)
{
    static const char *const faults[LUM_FAULT_KINDS] = {
        "lost", "repeated", "reordered", "corrupted"};
    json_open_object(json, "heard");
    for (unsigned k = 0; k < LUM_PACKET_KINDS; k++) {
        json_uint(json, kinds[k], live->counts.heard[k]);
    }
    json_close_object(json);
    json_uint(json, "unheard", live->counts.unheard);
    json_uint(json, "answers", live->counts.answers);
    json_uint(json, "answers_lost", live->counts.answers_lost);
    json_uint(json, "packets", live->data.sender.sent);
    json_uint(json, "bytes", live->data.sender.bytes);
    json_uint(json, "lines", live->data.scene.lines_sent);
    json_uint(json, "lines_skipped", live->data.scene.lines_skipped);
    json_uint(json, "unsent", live->counts.unsent);
    json_uint(json, "given_up", live->data.sender.given_up);
    json_uint(json, "no_room", live->data.sender.no_room);
    json_uint(json, "retries", live->data.sender.retries);
    for (unsigned k = 0; k < LUM_FAULT_KINDS; k++) {
        json_uint(json, faults[k], live->data.sender.fault.count[k]);
    }
}

void live_log_stop(struct live *live, int64_t now_ns)
{
    if (live->log.ignored > 0) {
        log_ignored(live, now_ns, LUM_PACKET_FOREIGN, NULL);
    }
    struct json *json = live_begin_line(live, now_ns, "stop");
    add_counts(json, live);
    live_end_line(live);
}
