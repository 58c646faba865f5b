#include "convert.h"

#include <errno.h>
#include <stdlib.h>

static enum pass_result output_failed(void)
{
    return errno == EPIPE ? PASS_READER_LEFT : PASS_FAILED;
}

static bool is_wanted(const struct options *o, const lum_line *line)
{
    const bool is_whole =
        line->angle_count == LUM_LINE_PIXELS && line->lost_words == 0;
    return ((o->eyes >> line->eye) & 1u) != 0 &&
           line->frame >= o->frame_first && line->frame <= o->frame_last &&
           (is_whole || !o->drop_incomplete);
}

/* Counting alone needs no projection where nothing depends on it. */
static bool needs_samples(const struct pass *pass)
{
    const lum_selection *s = &pass->options->selection;
    const bool writes =
        pass->outputs != NULL && outputs_want_lines(pass->outputs);
    return writes || s->has_range || s->has_box ||
           s->returns != LUM_RETURNS_ALL;
}

static void count_line(struct pass *pass, const lum_line *line, bool wanted,
                       struct point_counts *counts)
{
    const unsigned edges = (unsigned)pass->options->selection.edges;
    lum_point_losses losses = {0, 0};
    uint64_t rising = 0;
    uint64_t falling = 0;
    lum_points_count(pass->projector, line, &rising, &falling, &losses);
    counts->no_angle += losses.no_angle;
    counts->no_range += losses.no_range;
    if (wanted) {
        counts->points += (edges & LUM_EDGES_RISING) != 0 ? rising : 0;
        counts->points += (edges & LUM_EDGES_FALLING) != 0 ? falling : 0;
    }
}

static size_t compute_samples(struct pass *pass, const lum_line *line,
                              lum_point_losses *losses)
{
    const struct options *o = pass->options;
    lum_angle angles[LUM_LINE_PIXELS];
    lum_line seen = *line;
    if (o->smooths) {
        lum_smooth_line(&o->smooth, line, angles);
        seen.angles = angles;
    }
    return lum_samples_compute(pass->projector, &seen, &o->selection,
                               &pass->workspace, pass->samples, losses);
}

static int write_line(struct pass *pass, const lum_line *line,
                      struct point_counts *counts, lum_error *error)
{
    lum_point_losses losses = {0, 0};
    const size_t n = compute_samples(pass, line, &losses);
    counts->points += n;
    counts->no_angle += losses.no_angle;
    counts->no_range += losses.no_range;
    if (pass->outputs == NULL) {
        return 0;
    }
    return outputs_add_line(
        pass->outputs,
        &(lum_line_samples){.samples = pass->samples,
                            .count = n,
                            .frame = line->frame,
                            .timestamp_us = pass->options->utc
                                                ? line->arrival / 1000
                                                : line->clock_us,
                            .line = line->number,
                            .eye = line->eye},
        error);
}

static int handle_line(struct pass *pass, lum_error *error)
{
    const lum_line *line = lum_assembler_line(lum_demux_current(pass->demux));
    struct point_counts *counts =
        &pass->summary.sensors[lum_demux_current_index(pass->demux)];
    const bool wanted = is_wanted(pass->options, line);
    counts->lines[line->eye]++;
    if (wanted && needs_samples(pass)) {
        return write_line(pass, line, counts, error);
    }
    count_line(pass, line, wanted, counts);
    return 0;
}

static enum pass_result handle_event(struct pass *pass, lum_result event,
                                     lum_error *error)
{
    if (pass->outputs != NULL && !pass->has_sensor &&
        lum_demux_sensor_count(pass->demux) > 1) {
        return PASS_SENSORS;
    }
    if (event == LUM_LINE_READY) {
        return handle_line(pass, error) == 0 ? PASS_DONE : output_failed();
    }
    if (pass->outputs != NULL &&
        outputs_end_frame(pass->outputs,
                          lum_assembler_frame(lum_demux_current(pass->demux)),
                          error) != 0) {
        return output_failed();
    }
    return PASS_DONE;
}

static void note_time(struct summary *s, int64_t time_ns)
{
    if (!s->has_time) {
        s->has_time = true;
        s->first_ns = time_ns;
        s->last_ns = time_ns;
    }
    if (time_ns > s->last_ns) {
        s->last_ns = time_ns;
    }
}

/* A record of port 5517 that was counted as `kind`. */
static enum pass_result note_ours(struct pass *pass, const lum_record *record,
                                  lum_packet_kind kind, lum_error *error)
{
    const bool is_foreign = kind == LUM_PACKET_FOREIGN;
    if (!is_foreign) {
        note_time(&pass->summary, record->time_ns);
    }
    if (!is_foreign && kind != LUM_PACKET_DATA) {
        diagnosis_note(&pass->diagnosis, record->payload, record->len, kind);
    }
    if (pass->outputs != NULL && !is_foreign &&
        outputs_add_datagram(pass->outputs, record, error) != 0) {
        return output_failed();
    }
    return PASS_DONE;
}

static bool is_of_asked_sensor(const struct pass *pass,
                               const lum_record *record)
{
    return !pass->has_sensor || record->source == pass->sensor ||
           record->destination == pass->sensor;
}

enum pass_result pass_take(struct pass *pass, const lum_record *record,
                           lum_error *error)
{
    lum_packet_kind kind = LUM_PACKET_KINDS;
    lum_result r = LUM_OK;
    enum pass_result result = PASS_DONE;
    if (pass->outputs != NULL &&
        outputs_set_time(pass->outputs, record->time_ns, error) != 0) {
        return output_failed();
    }
    while ((r = lum_demux_push(pass->demux, record, &kind)) > 0) {
        result = handle_event(pass, r, error);
        if (result != PASS_DONE) {
            return result;
        }
    }
    if (r != LUM_OK) {
        (void)lum_error_set(error, "out of memory");
        return PASS_FAILED;
    }
    if (kind != LUM_PACKET_KINDS && is_of_asked_sensor(pass, record)) {
        return note_ours(pass, record, kind, error);
    }
    return PASS_DONE;
}

/* A recording holds all that came from the sensor, so that it tells what the
 * run itself told. */
enum pass_result pass_record(struct pass *pass, const lum_record *record,
                             lum_error *error)
{
    if (record->kind != LUM_RECORD_DATAGRAM) {
        return PASS_DONE;
    }
    return outputs_set_time(pass->outputs, record->time_ns, error) == 0 &&
                   outputs_add_datagram(pass->outputs, record, error) == 0
               ? PASS_DONE
               : output_failed();
}

enum pass_result pass_flush(struct pass *pass, lum_error *error)
{
    lum_result r = LUM_OK;
    while ((r = lum_demux_flush(pass->demux)) > 0) {
        const enum pass_result result = handle_event(pass, r, error);
        if (result != PASS_DONE) {
            return result;
        }
    }
    return PASS_DONE;
}

enum pass_result pass_prepare(struct pass *pass, lum_error *error)
{
    const struct options *o = pass->options;
    pass->has_sensor = o->is_live || o->has_sensor;
    pass->sensor = o->is_live ? o->address.address : o->sensor;
    lum_demux_options options = {.layout = *pass->layout,
                                 .has_sensor = pass->has_sensor,
                                 .sensor = pass->sensor};
    lum_assembler_config_default(&options.config);
    const size_t words = options.config.words_per_line;
    pass->demux = lum_demux_new(&options);
    pass->samples = malloc(words * sizeof *pass->samples);
    pass->workspace.returns = malloc(words * sizeof *pass->workspace.returns);
    if (pass->demux == NULL || pass->samples == NULL ||
        pass->workspace.returns == NULL) {
        (void)lum_error_set(error, "out of memory");
        return PASS_FAILED;
    }
    pass->summary.source = o->source;
    pass->summary.demux = pass->demux;
    pass->summary.has_sensor = pass->has_sensor;
    pass->summary.sensor = pass->sensor;
    return PASS_DONE;
}

void pass_free(struct pass *pass)
{
    lum_demux_free(pass->demux);
    free(pass->samples);
    free(pass->workspace.returns);
}
