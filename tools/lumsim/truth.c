#include "truth.h"

#include "base/text.h"
#include "lum/assembler.h"
#include "lum/cloud/writer.h"
#include "lum/host/keys.h"
#include "sim/packets.h"
#include "standing.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define POSE_BYTES  512
#define SECOND_NS   INT64_C(1000000000)
#define SAMPLES_MAX (LUM_RENDER_RETURNS_MAX * LUM_LINE_PIXELS)

/* A line that a decoder still holds open. */
struct held {
    lum_line_samples line;
    lum_sample samples[SAMPLES_MAX];
};

struct truth {
    lum_writer *writer;
    const struct options *options;
    unsigned open_lines; /* of each eye: one more closes the oldest */
    unsigned first[LUM_EYES];
    unsigned count[LUM_EYES];
    struct held held[LUM_EYES][LUM_OPEN_LINES_MAX];
};

int truth_open(const struct options *o, struct truth **out, lum_error *error)
{
    const char *path = o->truth.points;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_CSV,
                                        .utc = o->truth.is_utc};
    lum_assembler_config config;
    struct truth *t = calloc(1, sizeof *t);
    if (t == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    if (lum_writer_open(path, &options, &t->writer, error) != 0) {
        free(t);
        return -1;
    }
    lum_assembler_config_default(&config);
    t->open_lines = config.open_lines;
    t->options = o;
    *out = t;
    return 0;
}

static int write_oldest(struct truth *t, unsigned eye, lum_error *error)
{
    struct held *h = &t->held[eye][t->first[eye]];
    t->first[eye] = (t->first[eye] + 1) % t->open_lines;
    t->count[eye]--;
    return lum_writer_add(t->writer, &h->line, error);
}

static void place(const lum_pose *pose, lum_sample *samples, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        lum_sample *s = &samples[i];
        double at[3] = {(double)s->x, (double)s->y, (double)s->z};
        lum_pose_apply(pose, at, at);
        s->x = (float)at[0];
        s->y = (float)at[1];
        s->z = (float)at[2];
    }
}

int truth_add(struct truth *truth, const lum_sim_line *line, int64_t utc_us,
              lum_error *error)
{
    const unsigned eye = line->eye;
    if (truth->count[eye] == truth->open_lines &&
        write_oldest(truth, eye, error) != 0) {
        return -1;
    }
    struct held *h = &truth->held[eye][(truth->first[eye] + truth->count[eye]) %
                                       truth->open_lines];
    truth->count[eye]++;
    const lum_render_options *r = &truth->options->render;
    const int64_t clock_us = lum_packets_clock_us(&r->layout, line);
    const bool is_utc = truth->options->truth.is_utc;
    h->line = (lum_line_samples){.struct_size = sizeof h->line,
                                 .samples = h->samples,
                                 .count = line->truth_count,
                                 .frame = line->frame,
                                 .timestamp_us = is_utc ? utc_us : clock_us,
                                 .line = line->number,
                                 .eye = line->eye};
    memcpy(h->samples, line->truth, line->truth_count * sizeof h->samples[0]);
    if (r->place.is_on_vehicle) {
        place(&r->place.on_vehicle, h->samples, line->truth_count);
    }
    return 0;
}

int truth_close(struct truth *truth, lum_error *error)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        while (truth->count[eye] > 0) {
            if (write_oldest(truth, eye, error) != 0) {
                truth_abort(truth);
                return -1;
            }
        }
    }
    const int result = lum_writer_close(truth->writer, error);
    free(truth);
    return result;
}

void truth_abort(struct truth *truth)
{
    if (truth != NULL) {
        lum_writer_abort(truth->writer);
        free(truth);
    }
}

/* --- Poses --- */

#define WHERE   "# Where the "
#define COLUMNS "# seconds x y z qx qy qz qw\n"

int truth_poses_open(const struct options *o, lum_sink **out, lum_error *error)
{
    static const char alone[] =
        WHERE "sensor is in the frame of the scene when each line begins, at "
              "the end, and a line later.\n" COLUMNS;
    static const char rig[] = WHERE
        "vehicle is in the frame of the scene when each line of its first "
        "sensor begins, and on to a line after the last sensor's "
        "end.\n" COLUMNS;
    const char *head = o->rig.path != NULL ? rig : alone;
    if (lum_sink_open(o->moving.poses, out, error) != 0) {
        return -1;
    }
    if (lum_sink_write(*out, head, strlen(head), error) != 0) {
        lum_sink_abort(*out);
        *out = NULL;
        return -1;
    }
    return 0;
}

int truth_poses_add(lum_sink *poses, int64_t time_ns, const lum_pose *pose,
                    lum_error *error)
{
    char text[POSE_BYTES];
    const double *at = pose->at;
    const double *turn = pose->turn;
    const int n = snprintf(text, sizeof text,
                           "%" PRId64 ".%09" PRId64
                           " %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                           time_ns / SECOND_NS, time_ns % SECOND_NS, at[0],
                           at[1], at[2], turn[0], turn[1], turn[2], turn[3]);
    return lum_sink_write(poses, text, (size_t)n, error);
}

/* --- The calibration --- */

#define TEXT_BYTES 4096

/* What the recording was made of stands above the values. */
static size_t make_text(const struct options *o, char out[TEXT_BYTES])
{
    const lum_place_options *place = &o->render.place;
    lum_keys keys;
    (void)snprintf(out, TEXT_BYTES,
                   "# The true calibration of a simulated sensor, written by "
                   "lumsim.\n# Scene: %s, seed %" PRIu64 "\n",
                   standing_scene(o), o->render.seed);
    if (place->path.kind != LUM_PATH_NONE) {
        lum_text_add(out, TEXT_BYTES, "# Path: %.200s\n", o->moving.path);
    } else if (place->has_pose || place->kind != LUM_PLACE_STREET) {
        const lum_stance pose = place->has_pose || place->is_on_vehicle
                                    ? place->pose
                                    : lum_place_usual_pose(place->kind);
        lum_text_add(out, TEXT_BYTES,
                     "# Pose%s: %.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                     place->is_on_vehicle ? " of its vehicle" : "", pose.at[0],
                     pose.at[1], pose.at[2], pose.roll_deg, pose.pitch_deg,
                     pose.yaw_deg);
    }
    lum_keys_of_calibration(&keys, &o->render.calibration);
    const size_t n = strlen(out);
    return n + lum_keys_write(&keys, out + n, TEXT_BYTES - n);
}

int truth_yaml_begin(const struct options *o, lum_outfile *out,
                     lum_error *error)
{
    char text[TEXT_BYTES];
    lum_outfile file;
    const size_t len = make_text(o, text);
    if (lum_outfile_begin(o->truth.calibration, text, len, &file, error) != 0) {
        return -1;
    }
    *out = file;
    return 0;
}
