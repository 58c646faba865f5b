/* The summary of a run as JSON. */
#include "rig_report.h"
#include "summary.h"

#include "../common/json.h"
#include "../common/number.h"
#include "../common/source_walk.h"

/* Members of the summary, and what is in its arrays, have lines of their own;
 * those of a sensor too. */
#define LINES           2u
#define LINES_OF_SENSOR 3u

static double seconds(int64_t ns)
{
    return (double)ns * 1e-9;
}

static void put_counters(struct json *json, const lum_demux_counters *packets,
                         const lum_framer_counters *frames)
{
    struct summary_rows rows;
    summary_list(packets, frames, &rows);
    for (size_t i = 0; i < rows.count; i++) {
        json_uint(json, rows.list[i].key, rows.list[i].value);
    }
    json_real(json, "paused_s", (double)frames->paused_us * 1e-6, 6);
}

/* --- Captures --- */

static void put_source(struct json *json, const struct source_walk *w)
{
    static const char *const ends[] = {[LUM_CAPTURE_UNDER_WAY] = "not reached",
                                       [LUM_CAPTURE_WHOLE] = "whole",
                                       [LUM_CAPTURE_BROKEN] = "broken off",
                                       [LUM_CAPTURE_UNREAD] = "unread"};
    const lum_capture_source *s = &w->source;
    json_open_object(json, NULL);
    json_text(json, "name", s->name);
    json_uint(json, "records", s->records);
    json_text(json, "end", ends[s->end]);
    json_uint(json, "damaged", s->damaged);
    if (s->records > 0) {
        json_real(json, "first_s", seconds(s->first_ns), 6);
        json_real(json, "last_s", seconds(s->last_ns), 6);
    }
    if (w->has_before && s->records > 0) {
        json_real(json, "gap_s", seconds(w->gap_ns), 6);
    }
    json_close_object(json);
}

static void put_sources(struct json *json, const lum_capture *capture)
{
    struct source_walk walk = {.capture = capture,
                               .source.struct_size = sizeof walk.source};
    json_open_array(json, "sources");
    while (source_walk_step(&walk)) {
        put_source(json, &walk);
    }
    json_close_array(json);
}

/* --- Sensors --- */

/* Which sensors the capture and the rig do not have in common. */
static void put_rig(struct json *json, const struct summary *s)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    json_open_object(json, "rig");
    json_text(json, "file", s->rig->path);
    json_open_array(json, "missing");
    for (size_t k = 0; k < s->rig->count; k++) {
        if (!rig_has_data(s->rig, s->framer, k)) {
            json_text(json, NULL, s->rig->sensors[k].of->name);
        }
    }
    json_close_array(json);
    json_open_array(json, "unnamed");
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        char name[LUM_SENSOR_NAME_BYTES];
        if (rig_name_of(s->rig, s->framer, i) == NULL) {
            json_open_object(json, NULL);
            json_text(json, "address", lum_demux_name(demux, i, name));
            json_uint(json, "packets",
                      rig_others_packets(&s->others, s->framer, i));
            json_close_object(json);
        }
    }
    json_close_array(json);
    json_close_object(json);
}

static void put_clock_counts(struct json *json, const lum_clock_fit_info *clock)
{
    json_uint(json, "sensor_breaks", clock->sensor_breaks);
    json_uint(json, "host_steps", clock->host_steps);
    json_uint(json, "stamps_still", clock->still);
}

static void put_clock(struct json *json, const struct summary *s, size_t sensor)
{
    lum_clock_fit_info clock;
    if (!summary_find_clock(s, sensor, &clock)) {
        return;
    }
    json_open_object(json, "clock");
    if (clock.has_drift) {
        json_real(json, "drift_ppm", clock.drift_ppb * 1e-3, 3);
        json_real(json, "drift_error_ppm", clock.drift_error_ppb * 1e-3, 3);
    }
    if (clock.error_ns == LUM_CLOCK_ERROR_UNKNOWN) {
        json_null(json, "utc_error_us");
    } else {
        json_real(json, "utc_error_us", (double)clock.error_ns * 1e-3, 1);
    }
    json_real(json, "stamp_resolution_us", (double)clock.resolution_ns * 1e-3,
              1);
    put_clock_counts(json, &clock);
    json_close_object(json);
}

static void put_sensor(struct json *json, const struct summary *s, size_t i)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const lum_framer_counters points = summary_count_sensor(s, i);
    lum_demux_counters counters = {.struct_size = sizeof counters};
    char name[LUM_SENSOR_NAME_BYTES];
    json_open_object(json, NULL);
    json_text(json, "address",
              number_address(lum_demux_address(demux, i)).text);
    if (lum_demux_is_shared(demux, i)) {
        json_text(json, "interface", lum_demux_interface(demux, i));
        json_text(json, "name", lum_demux_name(demux, i, name));
    }
    if (s->rig != NULL) {
        json_text(json, "rig_name", rig_name_of(s->rig, s->framer, i));
    }
    put_clock(json, s, i);
    lum_demux_count(demux, i, &counters);
    put_counters(json, &counters, &points);
    json_close_object(json);
}

static void put_sensors(struct json *json, const struct summary *s)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    json->lines = LINES_OF_SENSOR;
    json_open_array(json, "sensors");
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        if (lum_demux_is_requested(demux, i)) {
            put_sensor(json, s, i);
        }
    }
    json_close_array(json);
    json->lines = LINES;
}

/* --- Outputs --- */

static void put_output(struct json *json, const struct live_output *o)
{
    json_open_object(json, NULL);
    json_text(json, "name", o->name);
    json_text(json, "end", o->end);
    json_uint(json, "datagrams", o->datagrams);
    json_uint(json, "dropped", o->dropped);
    if (o->has_ended_early) {
        json_real(json, "ended_s", o->seconds, 3);
    }
    if (*o->error != '\0') {
        json_text(json, "error", o->error);
    }
    json_close_object(json);
}

static void put_live(struct json *json, const struct live_counts *c)
{
    json_uint(json, "received", c->received);
    json_uint(json, "kernel_drops", c->kernel_drops);
    json_uint(json, "ring_drops", c->ring_drops);
    json_uint(json, "recording_drops", c->recording_drops);
    json_uint(json, "foreign_source", c->foreign_source);
    json_uint(json, "heartbeats_sent", c->heartbeats_sent);
    json_bool(json, "kernel_drops_at_least", c->kernel_drops_at_least);
    json_real(json, "silent_s", c->silent_s, 3);
    json_real(json, "seconds", c->seconds, 6);
    json_text(json, "laser", c->laser);
    json_real(json, "dark_s", c->dark_s, 3);
    json_open_array(json, "outputs");
    for (size_t i = 0; i < c->output_count; i++) {
        put_output(json, &c->outputs[i]);
    }
    json_close_array(json);
}

static void put_left_out(struct json *json, const struct summary *s)
{
    json_open_array(json, "left_out");
    for (size_t i = 0; i < s->outputs.left_out_count; i++) {
        const struct left_out *l = &s->outputs.left_out[i];
        json_open_object(json, NULL);
        json_text(json, "output", output_title(l->name));
        json_uint(json, "late", l->late);
        json_uint(json, "cut", l->cut);
        json_uint(json, "no_place", l->no_place);
        json_close_object(json);
    }
    json_close_array(json);
}

static void put_moved(struct json *json, const lum_move_counts *c,
                      const double origin[3])
{
    json_open_object(json, "poses");
    json_uint(json, "points", c->points);
    json_uint(json, "without", lum_move_counts_without(c));
    json_uint(json, "before", c->before);
    json_uint(json, "after", c->after);
    json_uint(json, "in_gap", c->in_gap);
    json_uint(json, "no_start", c->no_start);
    json_uint(json, "no_time", c->no_time);
    json_open_array(json, "origin_m");
    for (unsigned i = 0; i < 3u; i++) {
        json_real(json, NULL, origin[i], 0);
    }
    json_close_array(json);
    json_close_object(json);
}

static void put_drawn(struct json *json, const struct drawn *d)
{
    json_open_object(json, NULL);
    json_text(json, "output", output_title(d->name));
    json_uint(json, "frames", d->frames);
    json_uint(json, "files", d->files);
    json_uint(json, "points", d->points);
    if (d->frames > 0) {
        json_int(json, "first", d->first);
        json_int(json, "last", d->last);
    }
    if (d->frames == 1) {
        json_bool(json, "is_whole", d->is_whole);
    }
    json_uint(json, "others", d->others);
    json_close_object(json);
}

static void put_voxels(struct json *json, const struct voxel_counts *v)
{
    json_open_object(json, "voxels");
    json_real(json, "size_m", v->size, 6);
    json_uint(json, "points", v->points);
    json_uint(json, "voxels", v->voxels);
    json_uint(json, "without_pose", v->without_pose);
    json_uint(json, "not_finite", v->not_finite);
    json_uint(json, "out_of_range", v->out_of_range);
    json_uint(json, "spooled_bytes", v->spooled);
    json_close_object(json);
}

static void put_outputs(struct json *json, const struct summary *s)
{
    const struct summary_outputs *o = &s->outputs;
    if (s->moved != NULL) {
        put_moved(json, s->moved, s->origin);
    }
    put_left_out(json, s);
    if (o->drawn_count > 0) {
        json_open_array(json, "pictures");
        for (size_t i = 0; i < o->drawn_count; i++) {
            put_drawn(json, &o->drawn[i]);
        }
        json_close_array(json);
    }
    if (s->voxels.size > 0) {
        put_voxels(json, &s->voxels);
    }
    if (o->retention.is_used) {
        json_uint(json, "kept_removed", o->retention.removed);
        json_uint(json, "kept_stuck", o->retention.stuck);
    }
}

/* --- The summary --- */

void summary_json_print(const struct summary *s, FILE *out)
{
    const lum_framer_counters points = summary_count(s);
    const lum_clock_fit_info clocks = summary_count_clocks(s);
    const double lasts_s = summary_seconds(s);
    const lum_demux_counters total = summary_count_packets(s);
    struct json json = {.out = out, .keeps_bytes = true, .lines = LINES};
    json_open_object(&json, NULL);
    json_text(&json, "source", s->source);
    json_bool(&json, "truncated", s->truncated);
    json_uint(&json, "damaged", summary_damaged(s, NULL));
    json_uint(&json, "records", s->records);
    json_real(&json, "duration_s", lasts_s, 6);
    if (s->capture != NULL) {
        put_sources(&json, s->capture);
    }
    if (lasts_s > 0.0) {
        json_real(&json, "points_per_second", (double)points.points / lasts_s,
                  1);
    }
    if (points.frames_per_second > 0.0) {
        json_real(&json, "frames_per_second", points.frames_per_second, 3);
    }
    if (s->live != NULL) {
        put_live(&json, s->live);
    }
    put_outputs(&json, s);
    if (s->rig != NULL) {
        put_rig(&json, s);
    }
    put_sensors(&json, s);
    put_clock_counts(&json, &clocks);
    put_counters(&json, &total, &points);
    json_end_line(&json);
}
