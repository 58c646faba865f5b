#include "health.h"

#include "../common/number.h"
#include "lum/base/time.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/net/sensor.h"

#include <inttypes.h>
#include <stdio.h>

#define SECOND_NS  INT64_C(1000000000)
#define SILENCE_NS (LUM_SENSOR_SILENCE_MS * INT64_C(1000000))

#define VALUES_MAX 24u

/* A status in the making; its names are those of the node for ROS 1. */
struct health {
    lum_writer_status status;
    lum_status_value values[VALUES_MAX];
    char texts[VALUES_MAX][24];
    uint64_t lost; /* data that was to be there */
};

static void begin(struct health *h, const char *name, int64_t time_ns,
                  const char *hardware)
{
    *h = (struct health){.status = {.struct_size = sizeof h->status,
                                    .time_ns = time_ns,
                                    .level = LUM_STATUS_OK,
                                    .name = name,
                                    .hardware_id = hardware}};
}

static void add(struct health *h, const char *key, uint64_t n)
{
    if (h->status.count == VALUES_MAX) {
        return;
    }
    const size_t i = h->status.count++;
    (void)snprintf(h->texts[i], sizeof h->texts[i], "%" PRIu64, n);
    h->values[i] = (lum_status_value){key, h->texts[i]};
}

static void add_text(struct health *h, const char *key, const char *text)
{
    if (h->status.count < VALUES_MAX) {
        h->values[h->status.count++] = (lum_status_value){key, text};
    }
}

static void add_loss(struct health *h, const char *key, uint64_t n)
{
    add(h, key, n);
    h->lost += n;
}

static enum pass_result tell(struct pass *pass, struct health *h,
                             lum_error *error)
{
    h->status.values = h->values;
    return outputs_act(
               pass->outputs,
               &(struct action){.kind = ADD_STATUS, .status = &h->status},
               error) == 0
               ? PASS_DONE
               : pass_failure();
}

/* Answers of the sensor are no data. */
static bool is_silent(struct pass_told *told, uint64_t packets)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (packets != told->packets) {
        told->packets = packets;
        told->packets_ns = now_ns;
    }
    return now_ns - told->packets_ns >= SILENCE_NS;
}

static enum pass_result tell_data(struct pass *pass, struct health *h,
                                  const lum_demux_counters *c,
                                  const lum_framer_counters *p, bool has_ended,
                                  lum_error *error)
{
    const bool is_live = pass->options->is_live;
    h->status.message =
        is_live || !has_ended ? "packets come" : "the capture has ended";
    if (is_live && is_silent(&pass->told, c->packets[LUM_PACKET_DATA])) {
        h->status.level = LUM_STATUS_WARN;
        h->status.message = "no data for 3 s";
    }
    add(h, "frames", c->assembly.frames);
    add(h, "points", p->points);
    add(h, "lines", c->assembly.lines);
    add(h, "packets", c->packets[LUM_PACKET_DATA]);
    return tell(pass, h, error);
}

static enum pass_result tell_losses(struct pass *pass, struct health *h,
                                    const lum_demux_counters *c,
                                    const lum_framer_counters *p,
                                    lum_error *error)
{
    const lum_assembly_counters *a = &c->assembly;
    const uint64_t joined = p->under_way.words + p->under_way.lines;
    add_loss(h, "lost_words", a->lost_words);
    add_loss(h, "lines_skipped", a->lines_skipped);
    add_loss(h, "lines_in_pauses", p->lines_in_pauses);
    add_loss(h, "pauses", p->pauses);
    add_loss(h, "lines_missing_angles", a->lines_missing_angles);
    add_loss(h, "late", a->late);
    add(h, "duplicate", a->duplicate);
    add_loss(h, "conflict", a->conflict);
    add_loss(h, "no_room", a->no_room);
    add_loss(h, "stray", a->stray);
    add(h, "stray_at_breaks", p->stray_at_breaks);
    add(h, "out_of_order", c->out_of_order);
    add_loss(h, "bad_words", a->bad_words);
    add_loss(h, "malformed", c->packets[LUM_PACKET_MALFORMED]);
    add_loss(h, "unknown_tag", c->packets[LUM_PACKET_UNKNOWN_TAG]);
    add_loss(h, "unknown_type", c->packets[LUM_PACKET_UNKNOWN_TYPE]);
    add(h, "foreign", c->packets[LUM_PACKET_FOREIGN]);
    add_loss(h, "cut_short", c->cut_short);
    add(h, "other", c->other);
    add(h, "no_angle", p->losses.no_angle);
    add(h, "no_range", p->losses.no_range);
    add_loss(h, "points_left_out", p->points_late + p->points_cut);
    if (pass->options->is_live) {
        add_loss(h, "node_drops", pass->dropped);
    }
    add(h, "under_way_when_joined", joined);
    const bool has_lost = h->lost > joined;
    h->status.level = has_lost ? LUM_STATUS_WARN : LUM_STATUS_OK;
    h->status.message = has_lost ? "data was lost" : "none";
    return tell(pass, h, error);
}

static enum pass_result tell_status(struct pass *pass, struct health *h,
                                    lum_error *error)
{
    const uint16_t status = pass->laser.status;
    const char *state = lum_laser_status_name(status);
    char names[256];
    char message[sizeof names + 32];
    char hex[8];
    (void)lum_laser_bits_name(status & LUM_LASER_HAZARDS, " ", names,
                              sizeof names);
    (void)snprintf(message, sizeof message, "%s%s%s", state,
                   lum_laser_has_hazard(status) ? ", hazard: " : "",
                   lum_laser_has_hazard(status) ? names : "");
    (void)snprintf(hex, sizeof hex, "0x%04x", (unsigned)status);
    h->status.message = message;
    h->status.level =
        lum_laser_has_hazard(status) ? LUM_STATUS_ERROR : LUM_STATUS_OK;
    add_text(h, "status", hex);
    add_text(h, "laser", state);
    add_text(h, "hazards", names);
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        add_text(h, lum_laser_bit_name(bit),
                 (status >> bit & 1u) != 0 ? "true" : "false");
    }
    return tell(pass, h, error);
}

/* What the sensor told of its laser last: it is asked once a second. */
static enum pass_result tell_laser(struct pass *pass, struct health *h,
                                   lum_error *error)
{
    const bool is_old =
        pass->options->is_live &&
        lum_time_monotonic_ns() - pass->laser.at_ns >= SILENCE_NS;
    if (pass->laser.is_known && !is_old) {
        return tell_status(pass, h, error);
    }
    if (!pass->options->is_live) {
        return PASS_DONE;
    }
    h->status.level = LUM_STATUS_STALE;
    h->status.message = pass->laser.is_known
                            ? "the sensor has sent no status for 3 s"
                            : "the sensor has sent no status";
    return tell(pass, h, error);
}

/* The sensor that is written: the one that was asked for, or the only one. */
static void name_sensor(const struct pass *pass, char *out)
{
    const lum_demux *demux = lum_framer_demux(pass->framer);
    size_t i = lum_demux_sensor_count(demux) - 1u;
    while (i > 0 && !lum_demux_is_requested(demux, i)) {
        i--;
    }
    if (lum_demux_is_requested(demux, i)) {
        (void)lum_demux_name(demux, i, out);
    } else {
        (void)number_format_address(pass->options->sensor.address, out);
    }
}

static enum pass_result tell_all(struct pass *pass, bool has_ended,
                                 lum_error *error)
{
    const struct summary *s = &pass->summary;
    struct health h;
    char name[LUM_SENSOR_NAME_BYTES];
    const lum_demux *demux = lum_framer_demux(pass->framer);
    if (pass->outputs == NULL || !s->span.is_known ||
        !options_any(pass->options, options_has_messages) ||
        lum_demux_sensor_count(demux) == 0) {
        return PASS_DONE;
    }
    const int64_t now_ns =
        pass->options->is_live ? lum_time_utc_ns() : s->span.last_ns;
    const lum_framer_counters p = summary_count(s);
    const lum_demux_counters c = summary_count_packets(s);
    name_sensor(pass, name);
    begin(&h, "lumdump: data", now_ns, name);
    enum pass_result result = tell_data(pass, &h, &c, &p, has_ended, error);
    if (result == PASS_DONE) {
        begin(&h, "lumdump: losses", now_ns, name);
        result = tell_losses(pass, &h, &c, &p, error);
    }
    if (result == PASS_DONE) {
        begin(&h, "lumdump: laser", now_ns, name);
        result = tell_laser(pass, &h, error);
    }
    return result;
}

enum pass_result health_tell(struct pass *pass, lum_error *error)
{
    return tell_all(pass, true, error);
}

enum pass_result health_tell_on_the_way(struct pass *pass, lum_error *error)
{
    const struct summary *s = &pass->summary;
    if (!s->span.is_known ||
        !options_any(pass->options, options_is_standard_output)) {
        return PASS_DONE;
    }
    if (pass->told.capture_ns == 0) {
        pass->told.capture_ns = s->span.last_ns;
    }
    if (s->span.last_ns - pass->told.capture_ns < SECOND_NS) {
        return PASS_DONE;
    }
    pass->told.capture_ns = s->span.last_ns;
    return tell_all(pass, false, error);
}
