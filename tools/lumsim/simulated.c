#include "simulated.h"

/* The recording begins on the first of January 2026, UTC. */
#define EPOCH_NS (INT64_C(1767225600) * 1000000000)

int simulated_init(struct simulated *out, const struct options *o)
{
    out->options = o;
    out->frame = 1;
    out->true_calibration = (lum_outfile){.fd = -1, .claim = LUM_CLAIM_NONE};
    return lum_render_init(&out->render, &o->render) == LUM_OK ? 0 : 1;
}

int simulated_open(struct simulated *s, lum_error *error)
{
    const struct options *o = s->options;
    if (o->truth.points != NULL && truth_open(o, &s->truth, error) != 0) {
        return -1;
    }
    if (o->moving.labels != NULL &&
        labels_open(o->moving.labels, &s->labels, error) != 0) {
        return -1;
    }
    return o->truth.calibration != NULL
               ? truth_yaml_begin(o, &s->true_calibration, error)
               : 0;
}

int64_t simulated_time_ns(const struct simulated *s, int64_t clock_ns)
{
    return LUM_RENDER_CLOCK_US * 1000 +
           lum_render_drive_ns(&s->render, clock_ns);
}

int64_t simulated_utc(const struct options *o, int64_t time_ns)
{
    return EPOCH_NS + time_ns +
           (int64_t)((double)time_ns * o->capture.drift_ppm * 1e-6);
}

/* --- Rendering --- */

static int render_eye(struct simulated *s, unsigned eye, lum_error *error)
{
    const struct options *o = s->options;
    lum_sim_line *line = &s->line;
    if (lum_render_line(&s->render, s->frame, s->number, eye, line) != LUM_OK) {
        return lum_error_set(error, "not enough memory for the scene");
    }
    s->points += line->truth_count;
    if (lum_packets_build(&o->render.layout, line, &s->batches[eye]) !=
        LUM_OK) {
        return lum_error_set(error,
                             "a line does not fit the profile's packets");
    }
    if (s->labels != NULL && labels_add(s->labels, line, error) != 0) {
        return -1;
    }
    const int64_t utc_us =
        simulated_utc(o, simulated_time_ns(s, line->clock_us * 1000)) / 1000;
    return s->truth != NULL ? truth_add(s->truth, line, utc_us, error) : 0;
}

int simulated_render(struct simulated *s, unsigned sender, lum_error *error)
{
    const lum_render_options *r = &s->options->render;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (render_eye(s, eye, error) != 0) {
            return -1;
        }
    }
    s->count =
        lum_packets_spread(s->batches, 1e9 / r->rate_hz / r->lines, s->order);
    s->next = 0;
    for (size_t i = 0; i < s->count; i++) {
        s->order[i]->time_ns = simulated_time_ns(s, s->order[i]->time_ns);
        s->order[i]->sender = sender;
    }
    s->number = (s->number + 1) % r->lines;
    s->frame += s->number == 0 ? 1 : 0;
    return 0;
}

/* --- Ends --- */

int simulated_close(struct simulated *s, lum_error *error)
{
    struct truth *truth = s->truth;
    struct labels *labels = s->labels;
    s->truth = NULL;
    if (truth != NULL && truth_close(truth, error) != 0) {
        return -1;
    }
    s->labels = NULL;
    if (labels != NULL && labels_close(labels, error) != 0) {
        return -1;
    }
    return s->options->truth.calibration != NULL
               ? lum_outfile_finish(&s->true_calibration, error)
               : 0;
}

void simulated_abort(struct simulated *s)
{
    truth_abort(s->truth);
    labels_abort(s->labels);
    s->truth = NULL;
    s->labels = NULL;
}

void simulated_free(struct simulated *s)
{
    lum_outfile_discard(&s->true_calibration);
    lum_render_free(&s->render);
}
