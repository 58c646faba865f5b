#include "simulated.h"

#include "cloud/le.h"
#include "cloud/sink.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The recording begins on the first of January 2026, UTC. */
#define EPOCH_NS (INT64_C(1767225600) * 1000000000)

#define ROW_BYTES  24u
#define HEAD_BYTES 384u /* a multiple of 64, as NumPy makes them */
#define FORE_BYTES 10u  /* magic, version, length */

/* What each exact point lies on, as a structured array of NumPy: a row a point,
 * sorted by frame, line, eye, pixel and return. */
struct labels {
    lum_sink *sink;
    uint64_t count;
};

/* --- Labels --- */

/* With the count that is known only at the end. */
static void make_head(uint64_t count, char out[HEAD_BYTES])
{
    char text[HEAD_BYTES];
    const int n = snprintf(
        text, sizeof text,
        "{'descr': [('frame', '<i8'), ('line', '<u4'), ('object', '<u4'), "
        "('pixel', '<u2'), ('return_number', '<u2'), ('eye', '|u1'), "
        "('class', '|u1'), ('mixed', '|b1'), ('number_of_returns', '|u1')], "
        "'fortran_order': False, 'shape': (%" PRIu64 ",)}",
        count);
    memset(out, ' ', HEAD_BYTES);
    memcpy(out, "\x93NUMPY\x01\x00", 8);
    (void)lum_put_le16((unsigned char *)out + 8, HEAD_BYTES - FORE_BYTES);
    memcpy(out + FORE_BYTES, text, (size_t)n);
    out[HEAD_BYTES - 1] = '\n';
}

static void labels_abort(struct labels *labels)
{
    if (labels != NULL) {
        lum_sink_abort(labels->sink);
        free(labels);
    }
}

static int labels_open(const char *path, struct labels **out, lum_error *error)
{
    char head[HEAD_BYTES];
    struct labels *l = calloc(1, sizeof *l);
    if (l == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    make_head(0, head);
    if (lum_sink_open(path, &l->sink, error) != 0) {
        labels_abort(l);
        return -1;
    }
    if (!lum_sink_seekable(l->sink)) {
        (void)lum_error_set(error,
                            "--labels: %s is no regular file, and the number "
                            "of points is written into its beginning at the "
                            "end; give a file's name",
                            lum_sink_name(l->sink));
        labels_abort(l);
        return -1;
    }
    if (lum_sink_write(l->sink, head, sizeof head, error) != 0) {
        labels_abort(l);
        return -1;
    }
    *out = l;
    return 0;
}

/* The next line of an eye. */
static int labels_add(struct labels *labels, const lum_sim_line *line,
                      lum_error *error)
{
    for (size_t i = 0; i < line->truth_count; i++) {
        const lum_sample *s = &line->truth[i];
        const lum_label *is = &line->labels[i];
        char *room = lum_sink_reserve(labels->sink, ROW_BYTES, error);
        if (room == NULL) {
            return -1;
        }
        unsigned char *at = (unsigned char *)room;
        at = lum_put_le64(at, (uint64_t)line->frame);
        at = lum_put_le32(at, line->number);
        at = lum_put_le32(at, is->object);
        at = lum_put_le16(at, s->pixel);
        at = lum_put_le16(at, s->return_number);
        at = lum_put_u8(at, line->eye);
        at = lum_put_u8(at, is->thing);
        at = lum_put_u8(at, is->is_mixed);
        (void)lum_put_u8(at, (uint8_t)s->number_of_returns);
        lum_sink_commit(labels->sink, ROW_BYTES);
    }
    labels->count += line->truth_count;
    return 0;
}

/* On failure no file is left. */
static int labels_close(struct labels *labels, lum_error *error)
{
    char head[HEAD_BYTES];
    make_head(labels->count, head);
    if (lum_sink_patch(labels->sink, 0, head, sizeof head, error) != 0) {
        labels_abort(labels);
        return -1;
    }
    const int result = lum_sink_close(labels->sink, error);
    free(labels);
    return result;
}

/* --- Begin --- */

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
