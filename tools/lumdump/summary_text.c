/* The summary of a run as text for people. */
#include "rig_report.h"
#include "summary.h"

#include "../common/number.h"
#include "../common/source_walk.h"

#include <inttypes.h>
#include <string.h>

/* Rounding below this is not worth a line. */
#define COARSE_NS 10000

/* Rows of gaps and overlaps; JSON has all. */
#define ROWS_MAX 20u

/* --- Rows --- */

static const char *plural(uint64_t n)
{
    return n == 1 ? "" : "s";
}

/* A name that says all is a noun: one frame, two frames. */
static void print_counter(const char *title, const struct summary_row *row,
                          FILE *out)
{
    const size_t len = strlen(row->key);
    const bool is_one = row->value == 1 && row->key[len - 1u] == 's';
    (void)fprintf(out, "%-10s %14" PRIu64 "  ", title, row->value);
    if (strcmp(row->key, row->meaning) != 0) {
        (void)fprintf(out, "%-21s %s\n", row->key, row->meaning);
    } else {
        (void)fprintf(out, "%.*s\n", (int)(is_one ? len - 1u : len), row->key);
    }
}

static void add_loss(struct summary_rows *rows, const char *key,
                     const char *meaning, uint64_t n)
{
    rows->list[rows->count++] =
        (struct summary_row){SUMMARY_LOSSES, key, meaning, NULL, n};
}

/* Those of a group that are not 0. False: there is none. */
static bool print_group(const char *title, enum summary_group group,
                        const struct summary_rows *rows, FILE *out)
{
    const char *next = title;
    for (size_t i = 0; i < rows->count; i++) {
        if (rows->list[i].group == group && rows->list[i].value != 0) {
            print_counter(next, &rows->list[i], out);
            next = "";
        }
    }
    return next != title;
}

/* --- Captures, sensors and a live run --- */

static void print_gap(const struct source_walk *w, FILE *out)
{
    char text[SOURCE_WALK_TEXT_BYTES];
    const double seconds = (double)w->gap_ns * 1e-9;
    (void)fprintf(out, "%-10s %14.3f  %s\n", "",
                  seconds < 0 ? -seconds : seconds,
                  source_walk_text(w, text, sizeof text));
}

static void print_stream(const lum_capture *capture, FILE *out)
{
    struct source_walk walk = {.capture = capture,
                               .source.struct_size = sizeof walk.source};
    size_t rows = 0;
    const size_t n = capture != NULL ? lum_capture_source_count(capture) : 0;
    if (n < 2) {
        return;
    }
    (void)fprintf(out, "%-10s %14zu  captures, read as one stream\n", "sources",
                  n);
    while (source_walk_step(&walk)) {
        if (!source_walk_is_gap(&walk) && !source_walk_is_overlap(&walk)) {
            continue;
        }
        if (++rows <= ROWS_MAX) {
            print_gap(&walk, out);
        }
    }
    if (rows > ROWS_MAX) {
        (void)fprintf(out, "%-10s %14zu  more gaps and overlaps: see --json\n",
                      "", rows - ROWS_MAX);
    }
}

/* What is said of a sensor behind its name. */
static const char *remark_of(const struct summary *s, size_t i)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    return lum_demux_is_requested(demux, i) ? ""
           : s->rig == NULL || rig_name_of(s->rig, s->framer, i) != NULL
               ? "  left out: another was chosen"
               : "  left out: the rig does not name it";
}

/* What would add a sensor to the rig. */
static void print_unnamed(const struct summary *s, size_t i, FILE *out)
{
    char line[RIG_TEXT_BYTES];
    if (s->rig != NULL && rig_name_of(s->rig, s->framer, i) == NULL) {
        (void)fprintf(out, "%-26s %" PRIu64 " packets; this line adds it:%s\n",
                      "", rig_others_packets(&s->others, s->framer, i),
                      rig_line_for(s->framer, i, line) + 1);
    }
}

/* NULL: no rig names it. */
static const char *name_in_rig(const struct summary *s, size_t i)
{
    return s->rig != NULL ? rig_name_of(s->rig, s->framer, i) : NULL;
}

static void print_sensor_name(const struct summary *s, size_t i,
                              const char *title, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const char *of_rig = name_in_rig(s, i);
    char name[LUM_SENSOR_NAME_BYTES];
    (void)lum_demux_name(demux, i, name);
    (void)fprintf(out, "%-10s %14s%s%s%s\n", title,
                  of_rig != NULL ? of_rig : name, of_rig != NULL ? "  " : "",
                  of_rig != NULL ? name : "", remark_of(s, i));
}

/* What a rig adds, or would. */
static void print_rig(const struct summary *s, FILE *out)
{
    const size_t n = lum_demux_sensor_count(lum_framer_demux(s->framer));
    for (size_t k = 0; s->rig != NULL && k < s->rig->count; k++) {
        if (!rig_has_data(s->rig, s->framer, k)) {
            (void)fprintf(out, "%-10s %14s  no data came from it\n", "",
                          s->rig->sensors[k].of->name);
        }
    }
    if (s->rig == NULL && s->live == NULL && n > 1) {
        (void)fprintf(out,
                      "%-10s %14s  --rig FILE reads all of them, each by "
                      "its own calibration and pose\n",
                      "rig", "none");
    }
}

static void print_sensors(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const size_t n = lum_demux_sensor_count(demux);
    const char *title = "sensor";
    for (size_t i = 0; i < n; i++) {
        lum_demux_counters counters = {.struct_size = sizeof counters};
        print_sensor_name(s, i, title, out);
        print_unnamed(s, i, out);
        title = "";
        if (n > 1 && lum_demux_is_requested(demux, i)) {
            lum_demux_count(demux, i, &counters);
            const lum_assembly_counters *a = &counters.assembly;
            const lum_framer_counters p = summary_count_sensor(s, i);
            char selected[40] = "";
            if (s->has_frames) {
                (void)snprintf(selected, sizeof selected,
                               " (%" PRIu64 " selected)", p.frames);
            }
            (void)fprintf(out,
                          "%-26s %" PRIu64 " line%s, %" PRIu64
                          " frame%s%s, %" PRIu64 " point%s\n",
                          "", a->lines, plural(a->lines), a->frames,
                          plural(a->frames), selected, p.points,
                          plural(p.points));
        }
    }
    if (n == 0) {
        (void)fprintf(out, "%-10s %14s\n", title, "none");
    }
    print_rig(s, out);
}

/* Those that lack something. */
static void print_outputs(const struct live_counts *c, FILE *out)
{
    const char *title = "outputs";
    for (size_t i = 0; i < c->output_count; i++) {
        const struct live_output *o = &c->outputs[i];
        if (!o->has_ended_early && o->dropped == 0) {
            continue;
        }
        (void)fprintf(out, "%-10s %14s  %s", title, o->end, o->name);
        if (o->has_ended_early) {
            (void)fprintf(out, ", ended after %.1f s", o->seconds);
        }
        (void)fprintf(out, ", %" PRIu64 " datagram%s dropped\n", o->dropped,
                      plural(o->dropped));
        title = "";
    }
}

static void print_live(const struct live_counts *c, FILE *out)
{
    (void)fprintf(out,
                  "%-10s %14.3f  seconds, %" PRIu64 " datagram%s, %" PRIu64
                  " heartbeat%s sent\n",
                  "session", c->seconds, c->received, plural(c->received),
                  c->heartbeats_sent, plural(c->heartbeats_sent));
    if (c->silent_s > 0.0) {
        (void)fprintf(out, "%-10s %14.3f  seconds without data at the end\n",
                      "", c->silent_s);
    }
    (void)fprintf(out, "%-10s %14s\n", "laser", c->laser);
    if (c->dark_s >= 1.0) {
        (void)fprintf(out, "%-10s %14.3f  seconds of data without the laser\n",
                      "", c->dark_s);
    }
    print_outputs(c, out);
}

/* --- Clocks and rates --- */

static void print_clock(const char *title, const lum_clock_fit_info *clock,
                        FILE *out)
{
    struct summary_rows rows = {.count = 0};
    const bool is_known = clock->error_ns != LUM_CLOCK_ERROR_UNKNOWN;
    if (clock->has_drift) {
        (void)fprintf(
            out, "%-10s %+14.3f  ppm: host's clock minus sensor's, +- %.3f\n",
            title, clock->drift_ppb * 1e-3, clock->drift_error_ppb * 1e-3);
        title = "";
    }
    if (clock->has_drift && is_known) {
        (void)fprintf(out,
                      "%-10s %14.1f  microseconds that UTC may be off by "
                      "--time utc\n",
                      "", (double)clock->error_ns * 1e-3);
    }
    if (!is_known) {
        (void)fprintf(out, "%-10s %14s  how far UTC may be off by --time utc\n",
                      title, "unknown");
        title = "";
    }
    if (clock->resolution_ns >= COARSE_NS) {
        (void)fprintf(out,
                      "%-10s %14.1f  microseconds that arrival times are "
                      "rounded to\n",
                      title, (double)clock->resolution_ns * 1e-3);
        title = "";
    }
    add_loss(&rows, "sensor_breaks", "times the sensor's clock started again",
             clock->sensor_breaks);
    add_loss(&rows, "host_steps", "times the host's clock was stepped",
             clock->host_steps);
    add_loss(&rows, "stamps_still", "lines whose arrival times stood still",
             clock->still);
    (void)print_group(title, SUMMARY_LOSSES, &rows, out);
}

static void print_clocks(const struct summary *s, FILE *out)
{
    const lum_demux *demux = lum_framer_demux(s->framer);
    const size_t n = lum_demux_sensor_count(demux);
    for (size_t i = 0; i < n; i++) {
        lum_clock_fit_info clock;
        char name[LUM_SENSOR_NAME_BYTES];
        if (lum_demux_is_requested(demux, i) &&
            summary_find_clock(s, i, &clock)) {
            if (n > 1) {
                const char *of_rig = name_in_rig(s, i);
                (void)fprintf(out, "%-10s %14s\n", "clock",
                              of_rig != NULL ? of_rig
                                             : lum_demux_name(demux, i, name));
            }
            print_clock(n > 1 ? "" : "clock", &clock, out);
        }
    }
}

static void print_rates(const struct summary *s,
                        const lum_framer_counters *points, FILE *out)
{
    const double seconds = summary_seconds(s);
    const double frames = points->frames_per_second;
    if (!(seconds > 0.0)) {
        return;
    }
    (void)fprintf(out, "%-10s %14.3f  seconds of capture\n", "rates", seconds);
    if (frames > 0.0) {
        (void)fprintf(out, "%-10s %14.2f  frames a second, of whole frames\n",
                      "", frames);
    }
    (void)fprintf(out, "%-10s %14.0f  points a second\n", "",
                  (double)points->points / seconds);
}

/* --- Losses --- */

static struct summary_row *find(struct summary_rows *rows, const char *key)
{
    size_t i = 0;
    while (strcmp(rows->list[i].key, key) != 0) {
        i++;
    }
    return &rows->list[i];
}

/* A loss is left out where all of it is one part, and that part where it is a
 * loss itself. */
static void leave_out_parts(struct summary_rows *rows)
{
    for (size_t i = 0; i < rows->count; i++) {
        struct summary_row *part = &rows->list[i];
        if (part->of != NULL) {
            struct summary_row *loss = find(rows, part->of);
            const bool is_all = part->value == loss->value;
            if (part->group == SUMMARY_LOSSES && part->value >= loss->value) {
                part->value = 0;
            }
            loss->value = is_all ? 0 : loss->value;
        }
    }
}

static void add_live_losses(struct summary_rows *rows,
                            const struct live_counts *c)
{
    add_loss(rows, "kernel_drops",
             c->kernel_drops_at_least
                 ? "datagrams at least: this program was too slow, or they "
                   "came damaged"
                 : "datagrams: this program was too slow, or they came damaged",
             c->kernel_drops);
    add_loss(rows, "ring_drops",
             "datagrams: this machine was too busy to decode them",
             c->ring_drops);
    add_loss(rows, "recording_drops",
             "datagrams: a recording's disk was too slow", c->recording_drops);
    add_loss(rows, "foreign_source", "datagrams of others, not taken",
             c->foreign_source);
}

static void print_losses(const struct summary *s,
                         const struct summary_rows *all, double paused_s,
                         FILE *out)
{
    struct summary_rows rows = *all;
    char paused[64];
    (void)snprintf(paused, sizeof paused,
                   "times that no lines came, %.3f s in all", paused_s);
    find(&rows, "pauses")->meaning = paused;
    leave_out_parts(&rows);
    if (s->live != NULL) {
        add_live_losses(&rows, s->live);
    }
    add_loss(&rows, "damaged", "parts of the capture that could not be read",
             summary_damaged(s, NULL));
    if (!print_group("losses", SUMMARY_LOSSES, &rows, out)) {
        (void)fprintf(out, "%-10s %14s\n", "losses", "none");
    }
}

/* --- What outputs have --- */

static const char *what_one_is(const struct drawn *d)
{
    if (d->is_whole) {
        return d->others > 0 ? ", the first whole one" : "";
    }
    return d->others > 0 ? ", the first with points, as none is whole"
                         : ", which is not whole";
}

const char *summary_text_drawn(const struct drawn *d, char *out, size_t room)
{
    char others[80] = "";
    if (d->others > 0) {
        (void)snprintf(others, sizeof others,
                       "; %" PRIu64 " other%s not drawn, see --frames",
                       d->others, d->others == 1 ? " is" : "s are");
    }
    if (d->frames == 0) {
        (void)snprintf(out, room, "no frame with points");
    } else if (d->frames == 1) {
        (void)snprintf(out, room, "frame %" PRId64 "%s%s", d->first,
                       what_one_is(d), others);
    } else {
        char where[40] = "over each other";
        if (d->files > 1) {
            (void)snprintf(where, sizeof where, "in %" PRIu64 " pictures",
                           d->files);
        }
        (void)snprintf(out, room,
                       "%" PRIu64 " frames %s, %" PRId64 " to %" PRId64,
                       d->frames, where, d->first, d->last);
    }
    return out;
}

static void print_drawn(const struct summary *s, FILE *out)
{
    char text[200];
    for (size_t i = 0; i < s->outputs.drawn_count; i++) {
        (void)fprintf(
            out, "%-10s %s shows %s\n", i > 0 ? "" : "picture",
            output_title(s->outputs.drawn[i].name),
            summary_text_drawn(&s->outputs.drawn[i], text, sizeof text));
    }
}

static void print_moved(const lum_move_counts *c, FILE *out)
{
    if (c != NULL) {
        const uint64_t without = lum_move_counts_without(c);
        (void)fprintf(out, "%-10s %14" PRIu64 "  points moved\n", "poses",
                      c->points - without);
        (void)fprintf(out, "%-10s %14" PRIu64 "  points without a pose\n", "",
                      without);
    }
}

static void print_retention(const struct retention_counts *counts, FILE *out)
{
    if (counts->is_used) {
        (void)fprintf(out, "%-10s %14" PRIu64 "  old files were removed\n",
                      "keep", counts->removed);
    }
    if (counts->stuck > 0) {
        (void)fprintf(out, "%-10s %14" PRIu64 "  could not be removed\n", "",
                      counts->stuck);
    }
}

/* --- Voxels --- */

static void print_left_out(uint64_t n, const char *why, FILE *out)
{
    if (n > 0) {
        (void)fprintf(out, "%-10s %14" PRIu64 "  points left out: %s\n", "", n,
                      why);
    }
}

static void print_voxels(const struct voxel_counts *v, FILE *out)
{
    if (v->size == 0) {
        return;
    }
    (void)fprintf(out, "%-10s %14" PRIu64 "  of %g m, of %" PRIu64 " points\n",
                  "voxels", v->voxels, v->size, v->points);
    print_left_out(v->not_finite, "a coordinate is no number", out);
    print_left_out(v->out_of_range, "too far away for voxels of this size",
                   out);
    if (v->spooled > 0) {
        (void)fprintf(out, "%-10s %14" PRIu64 "  bytes were on the disk\n", "",
                      v->spooled);
    }
}

/* --- The summary --- */

void summary_text_print(const struct summary *s, FILE *out)
{
    const lum_framer_counters frames = summary_count(s);
    const lum_demux_counters packets = summary_count_packets(s);
    struct summary_rows rows;
    summary_list(&packets, &frames, &rows);
    if (!s->has_frames) {
        find(&rows, "frames_selected")->value = 0; /* all of them */
    }
    (void)fprintf(out, "%s%s\n", s->source,
                  s->truncated ? " (broken off: see the warning)" : "");
    print_stream(s->capture, out);
    print_sensors(s, out);
    if (s->live != NULL) {
        print_live(s->live, out);
    }
    (void)print_group("packets", SUMMARY_PACKETS, &rows, out);
    (void)print_group("content", SUMMARY_CONTENT, &rows, out);
    print_rates(s, &frames, out);
    print_clocks(s, out);
    (void)print_group("under way", SUMMARY_UNDER_WAY, &rows, out);
    print_losses(s, &rows, (double)frames.paused_us * 1e-6, out);
    print_moved(s->moved, out);
    print_drawn(s, out);
    print_voxels(&s->voxels, out);
    print_retention(&s->outputs.retention, out);
}
