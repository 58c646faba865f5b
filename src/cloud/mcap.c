/* Frames as messages of ROS 2 in an MCAP file. */
#include "mcap_file.h"
#include "mcap_rig.h"
#include "part.h"
#include "ros_messages.h"
#include "ros_points.h"
#include "writer_internal.h"

#include "base/sized.h"
#include "lum/version.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CLOUD_END_BYTES 1u /* of lum_ros_end_cloud() */

/* The cloud that is being written. */
typedef struct cloud {
    bool is_begun; /* before its points came, which are foreseen */
    float first_s;
    lum_cdr cdr;
    unsigned char *to; /* where its points go, if they have come */
    lum_bytes rows;    /* else: some of them */
} cloud;

typedef struct state {
    lum_mcap_file file;
    unsigned contents;                /* of lum_mcap_content */
    unsigned channel[LUM_ROS_TOPICS]; /* of those that the file has */
    lum_ros_points points;
    cloud cloud;
    lum_mcap_rig rig;
    size_t current;       /* of its sensors: whose the frame is */
    bool owes_transforms; /* of them */
    bool is_growing;
    bool has_frame;
    bool has_line;        /* of the frame */
    int64_t frame;        /* of its lines */
    int64_t utc_ns;       /* of its begin */
    int64_t timestamp_us; /* of its first line */
} state;

bool lum_mcap_can_compress(void)
{
    return lum_mcap_pack_name != NULL;
}

/* --- The beginning --- */

static int keep_contents(const lum_writer *writer, state *s,
                         const lum_mcap_options *o, lum_error *error)
{
    const unsigned clouds = LUM_MCAP_OF_FRAMES | LUM_MCAP_OF_LINES;
    const unsigned all = clouds | LUM_MCAP_OF_DATAGRAMS;
    s->contents = o->contents != 0 ? o->contents : LUM_MCAP_OF_FRAMES;
    const bool is_known = (s->contents & ~all) == 0;
    if (is_known && (s->contents & clouds) != clouds &&
        (writer->preset == NULL || s->contents & LUM_MCAP_OF_FRAMES)) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(
        error, "%s: %s", lum_sink_name(writer->sink),
        !is_known
            ? "contents that MCAP does not have; use frames, lines or datagrams"
        : writer->preset != NULL
            ? "a preset needs whole frames: choose frames"
            : "a cloud is of a frame or of a line, not both");
}

static bool has_topic(const state *s, unsigned topic)
{
    const bool has_clouds = s->contents != LUM_MCAP_OF_DATAGRAMS;
    const bool has_datagrams = (s->contents & LUM_MCAP_OF_DATAGRAMS) != 0;
    return topic == LUM_ROS_DATAGRAMS     ? has_datagrams
           : topic == LUM_ROS_DIAGNOSTICS ? true
                                          : has_clouds;
}

/* How many channels a topic has: one for the clouds of each sensor. */
static size_t channels_of(const state *s, unsigned topic)
{
    return !has_topic(s, topic)      ? 0
           : topic == LUM_ROS_POINTS ? s->rig.count
                                     : 1u;
}

static const char *topic_name(const state *s, unsigned topic, size_t k)
{
    return topic == LUM_ROS_POINTS ? s->rig.sensors[k].topic
                                   : lum_ros_topics[topic].name;
}

static unsigned *channel_at(state *s, unsigned topic, size_t k)
{
    return topic == LUM_ROS_POINTS ? &s->rig.sensors[k].channel
                                   : &s->channel[topic];
}

static int put_channels(state *s, lum_error *error)
{
    unsigned count = 0;
    for (unsigned i = 0; i < LUM_ROS_TOPICS; i++) {
        const lum_ros_topic *t = &lum_ros_topics[i];
        for (size_t k = 0; k < channels_of(s, i); k++) {
            *channel_at(s, i, k) = count++;
            if (lum_mcap_add_channel(&s->file, topic_name(s, i, k), t->type,
                                     t->definition, t->qos, error) != 0) {
                return -1;
            }
        }
    }
    return 0;
}

static int put_about(const lum_writer *writer, lum_mcap_file *file,
                     const lum_mcap_options *o, lum_error *error)
{
    const bool has_comment = writer->options.comment != NULL;
    const char *const about[] = {
        "version", LUM_VERSION, has_comment ? "provenance" : NULL,
        has_comment ? writer->options.comment : NULL, NULL};
    return lum_mcap_add_metadata(file, "lumsdk", about, error) == 0
               ? lum_mcap_rig_attach(file, o, error)
               : -1;
}

static int begin(lum_writer *writer, lum_error *error)
{
    static const lum_mcap_options defaults = {.struct_size = sizeof defaults};
    const lum_mcap_options *o =
        writer->options.mcap != NULL ? writer->options.mcap : &defaults;
    state *s = lum_writer_new_state(writer, sizeof *s, error);
    if (s == NULL ||
        lum_mcap_rig_take(&s->rig, lum_sink_name(writer->sink), o, error) !=
            0 ||
        keep_contents(writer, s, o, error) != 0) {
        return -1;
    }
    s->owes_transforms =
        lum_mcap_rig_has_transforms(&s->rig) && has_topic(s, LUM_ROS_TF_STATIC);
    s->is_growing = o->is_growing;
    s->file.can_patch = !o->is_growing && lum_sink_seekable(writer->sink);
    s->points.extras = &writer->extras;
    s->points.preset = writer->preset;
    s->points.lines =
        o->lines < LUM_MCAP_LINES_MAX ? o->lines : LUM_MCAP_LINES_MAX;
    s->points.lines_are_stated = o->lines != 0;
    for (size_t i = 0; i < s->rig.count; i++) {
        s->rig.sensors[i].lines = s->points.lines;
    }
    return lum_mcap_begin(&s->file, writer->sink, "lumsdk " LUM_VERSION,
                          !o->is_plain && lum_mcap_can_compress(),
                          error) == 0 &&
                   put_about(writer, &s->file, o, error) == 0 &&
                   put_channels(s, error) == 0
               ? 0
               : -1;
}

void lum_writer_pack_by(lum_writer *writer, unsigned threads)
{
    state *s = writer->state;
    if (writer->ops == &lum_mcap_ops && threads > 0) {
        lum_mcap_set_threads(&s->file, threads < LUM_MCAP_THREADS_MAX
                                           ? threads
                                           : LUM_MCAP_THREADS_MAX);
    }
}

/* --- Messages --- */

static int begin_message(state *s, unsigned topic, int64_t time_ns,
                         lum_bytes **out, lum_error *error)
{
    const unsigned channel = topic == LUM_ROS_POINTS
                                 ? s->rig.sensors[s->current].channel
                                 : s->channel[topic];
    return lum_mcap_begin_message(&s->file, channel, time_ns, out, error);
}

/* Before the first other message, whose time they get. */
static int put_transforms(state *s, int64_t time_ns, lum_error *error)
{
    lum_bytes *out = NULL;
    if (!s->owes_transforms) {
        return 0;
    }
    s->owes_transforms = false;
    if (begin_message(s, LUM_ROS_TF_STATIC, time_ns, &out, error) != 0) {
        return -1;
    }
    lum_mcap_rig_put_transforms(&s->rig, time_ns, out);
    return lum_mcap_end_message(&s->file, error);
}

/* No sum of two of them overflows. */
static int64_t bounded_ns(int64_t ns)
{
    return ns < 0 ? 0 : ns < INT64_MAX / 2 ? ns : INT64_MAX / 2;
}

static int64_t stamp_of(const state *s, float first_s)
{
    const bool is_near = first_s > -1e6f && first_s < 1e6f; /* and a number */
    return bounded_ns(s->utc_ns +
                      (is_near ? (int64_t)((double)first_s * 1e9) : 0));
}

static const char *frame_id(const state *s)
{
    return s->rig.sensors[s->current].frame_id;
}

static int begin_cloud(lum_writer *writer, size_t n, float first_s,
                       lum_error *error)
{
    state *s = writer->state;
    const lum_preset *preset = writer->preset;
    const int64_t stamp_ns = stamp_of(s, first_s);
    const size_t bytes = lum_ros_points_bytes(&s->points);
    lum_bytes *out = NULL;
    if (put_transforms(s, stamp_ns, error) != 0 ||
        begin_message(s, LUM_ROS_POINTS, stamp_ns, &out, error) != 0) {
        return -1;
    }
    s->cloud.first_s = first_s;
    s->cloud.cdr = preset != NULL
                       ? lum_ros_begin_preset(out, stamp_ns, frame_id(s),
                                              (uint32_t)n, preset)
                       : lum_ros_begin_cloud(out, stamp_ns, frame_id(s),
                                             (uint32_t)n, s->points.extras);
    if (s->cloud.is_begun) {
        return lum_mcap_expect(&s->file, n * bytes + CLOUD_END_BYTES, error);
    }
    s->cloud.to = lum_bytes_extend(out, n * bytes);
    /* Without memory, the message's end fails, and says so. */
    return s->cloud.to != NULL ? 0 : lum_mcap_end_message(&s->file, error);
}

static int end_cloud(state *s, lum_error *error)
{
    lum_ros_end_cloud(&s->cloud.cdr);
    return lum_mcap_end_message(&s->file, error);
}

static int put_cloud(lum_writer *writer, float first_s, lum_error *error)
{
    state *s = writer->state;
    const size_t n = lum_ros_points_count(&s->points);
    if (begin_cloud(writer, n, first_s, error) != 0) {
        return -1;
    }
    lum_ros_points_take(&s->points, first_s, s->cloud.to);
    return end_cloud(s, error);
}

static int put_line(lum_writer *writer, const lum_ros_line *line,
                    lum_error *error)
{
    state *s = writer->state;
    if (begin_cloud(writer, line->count, line->first_s, error) != 0) {
        return -1;
    }
    lum_ros_points_take_line(&s->points, line, s->cloud.to);
    return end_cloud(s, error);
}

static int put_lines(lum_writer *writer, lum_error *error)
{
    state *s = writer->state;
    lum_ros_line line = lum_ros_points_next_line(&s->points);
    int result = 0;
    while (result == 0 && line.count > 0) {
        result = put_line(writer, &line, error);
        line = lum_ros_points_next_line(&s->points);
    }
    return result;
}

static int no_memory(const lum_writer *writer, lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error, "%s: no memory for the points of a frame",
                         lum_sink_name(writer->sink));
}

/* --- Clouds whose points are foreseen --- */

void lum_writer_foresee(lum_writer *writer, const lum_line_samples *line)
{
    state *s = writer->state;
    if (writer->ops == &lum_mcap_ops && writer->preset == NULL &&
        s->has_frame && (s->contents & LUM_MCAP_OF_FRAMES) != 0) {
        lum_ros_points_foresee(&s->points, line);
    }
}

static int not_foreseen(const lum_writer *writer, lum_error *error)
{
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: the points differ from those announced; add the "
                         "lines that were, in their order",
                         lum_sink_name(writer->sink));
}

/* With the first line of a frame. */
static int begin_foreseen(lum_writer *writer, lum_error *error)
{
    state *s = writer->state;
    size_t n = 0;
    float first_s = 0.0f;
    s->cloud.is_begun = lum_ros_points_can_merge(&s->points, &n, &first_s);
    return s->cloud.is_begun ? begin_cloud(writer, n, first_s, error) : 0;
}

static int add_foreseen(lum_writer *writer, const lum_line_samples *line,
                        lum_error *error)
{
    state *s = writer->state;
    if (line->count > lum_ros_points_to_come(&s->points, line->eye)) {
        return not_foreseen(writer, error);
    }
    if (lum_ros_points_add(&s->points, line, 0.0f) != 0) {
        return no_memory(writer, error);
    }
    lum_bytes *rows = &s->cloud.rows;
    rows->len = 0;
    unsigned char *to =
        lum_bytes_extend(rows, lum_ros_points_count(&s->points) *
                                   lum_ros_points_bytes(&s->points));
    if (to == NULL) {
        return no_memory(writer, error);
    }
    const unsigned char *end =
        lum_ros_points_merge(&s->points, s->cloud.first_s, to);
    return lum_mcap_put_expected(&s->file, to, (size_t)(end - to), error);
}

static int end_foreseen(lum_writer *writer, lum_error *error)
{
    state *s = writer->state;
    lum_bytes *rows = &s->cloud.rows;
    lum_cdr end = {.out = rows};
    s->cloud.is_begun = false;
    if (lum_ros_points_to_come(&s->points, 0) > 0 ||
        lum_ros_points_to_come(&s->points, 1) > 0) {
        return not_foreseen(writer, error);
    }
    lum_ros_points_end_merge(&s->points);
    rows->len = 0;
    lum_ros_end_cloud(&end);
    return lum_mcap_put_expected(&s->file, rows->at, rows->len, error) == 0
               ? lum_mcap_end_message(&s->file, error)
               : -1;
}

/* --- Frames --- */

static int end_frame(lum_writer *writer, lum_error *error)
{
    state *s = writer->state;
    float first_s = 0.0f;
    if (!s->has_frame) {
        return 0;
    }
    s->has_frame = false;
    if (s->cloud.is_begun) {
        return end_foreseen(writer, error);
    }
    if (lum_ros_points_sort(&s->points, &first_s) != 0) {
        return no_memory(writer, error);
    }
    return (s->contents & LUM_MCAP_OF_LINES) != 0
               ? put_lines(writer, error)
               : put_cloud(writer, first_s, error);
}

static int begin_frame(lum_writer *writer, int64_t utc_ns, lum_error *error)
{
    state *s = writer->state;
    if (end_frame(writer, error) != 0) {
        return -1;
    }
    s->has_frame = s->contents != LUM_MCAP_OF_DATAGRAMS;
    s->has_line = false;
    s->utc_ns = bounded_ns(utc_ns);
    return 0;
}

/* Each has its number of lines for rings. */
static int set_sensor(lum_writer *writer, size_t i, lum_error *error)
{
    state *s = writer->state;
    if (i >= s->rig.count) {
        errno = EINVAL;
        return lum_error_set(error, "%s: sensor %zu of %zu",
                             lum_sink_name(writer->sink), i, s->rig.count);
    }
    if (i == s->current) {
        return 0;
    }
    if (end_frame(writer, error) != 0) {
        return -1;
    }
    s->has_line = false;
    s->rig.sensors[s->current].lines = s->points.lines;
    s->current = i;
    s->points.lines = s->rig.sensors[i].lines;
    return 0;
}

/* Timestamps that are unknown, or of no clock, are those of 1970. */
static int64_t ns_of(int64_t us)
{
    return us > 0 && us < INT64_MAX / 1000 ? us * 1000 : 0;
}

/* The frame of a line, which begins with it if the caller did not begin it. */
static int enter_frame(lum_writer *writer, const lum_line_samples *line,
                       lum_error *error)
{
    state *s = writer->state;
    const bool is_other = s->has_line && line->frame != s->frame;
    if ((!s->has_frame || is_other) &&
        begin_frame(writer, ns_of(line->timestamp_us), error) != 0) {
        return -1;
    }
    if (!s->has_line) {
        s->has_line = true;
        s->frame = line->frame;
        s->timestamp_us = line->timestamp_us;
        return begin_foreseen(writer, error);
    }
    return 0;
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    state *s = writer->state;
    if (s->contents == LUM_MCAP_OF_DATAGRAMS) {
        return 0;
    }
    if (enter_frame(writer, line, error) != 0) {
        return -1;
    }
    if (s->cloud.is_begun) {
        return add_foreseen(writer, line, error);
    }
    if (line->count >
        lum_ros_points_max(&s->points) - lum_ros_points_count(&s->points)) {
        errno = EOVERFLOW;
        return lum_error_set(error, "%s: a frame of more than %zu points",
                             lum_sink_name(writer->sink),
                             lum_ros_points_max(&s->points));
    }
    const double from_us = (double)line->timestamp_us - (double)s->timestamp_us;
    const float from_s = (float)(from_us * 1e-6);
    return lum_ros_points_add(&s->points, line, from_s) == 0
               ? 0
               : no_memory(writer, error);
}

static int add_status(lum_writer *writer, const lum_writer_status *status,
                      lum_error *error)
{
    state *s = writer->state;
    lum_bytes *out = NULL;
    const int64_t time_ns = bounded_ns(status->time_ns);
    if (put_transforms(s, time_ns, error) != 0 ||
        begin_message(s, LUM_ROS_DIAGNOSTICS, time_ns, &out, error) != 0) {
        return -1;
    }
    lum_ros_put_status(out, status);
    return lum_mcap_end_message(&s->file, error);
}

static int add_datagram(lum_writer *writer, const lum_writer_datagram *datagram,
                        lum_error *error)
{
    state *s = writer->state;
    lum_bytes *out = NULL;
    if ((s->contents & LUM_MCAP_OF_DATAGRAMS) == 0) {
        return 0;
    }
    if (datagram->len > LUM_WRITER_DATAGRAM_BYTES_MAX) {
        errno = EINVAL;
        return lum_error_set(error, "%s: a datagram of %zu bytes; at most %u",
                             lum_sink_name(writer->sink), datagram->len,
                             LUM_WRITER_DATAGRAM_BYTES_MAX);
    }
    if (begin_message(s, LUM_ROS_DATAGRAMS, bounded_ns(datagram->time_ns), &out,
                      error) != 0) {
        return -1;
    }
    lum_ros_put_datagram(out, datagram);
    return lum_mcap_end_message(&s->file, error);
}

/* --- What it has --- */

static void add_topic(lum_mcap_info *info, const state *s, unsigned topic,
                      size_t k)
{
    const unsigned channel =
        topic == LUM_ROS_POINTS ? s->rig.sensors[k].channel : s->channel[topic];
    const uint64_t n = s->file.messages[channel];
    info->topics[info->topic_count++] =
        (lum_mcap_topic){topic_name(s, topic, k), lum_ros_topics[topic].type,
                         lum_ros_topics[topic].qos, n};
    info->messages += n;
}

int lum_writer_mcap_info(const lum_writer *writer, lum_mcap_info *out)
{
    lum_mcap_info info = {.struct_size = sizeof info};
    const state *s = writer->state;
    if (writer->ops != &lum_mcap_ops || s == NULL) {
        return -1;
    }
    for (unsigned i = 0; i < LUM_ROS_TOPICS; i++) {
        for (size_t k = 0; k < channels_of(s, i); k++) {
            add_topic(&info, s, i, k);
        }
    }
    info.begin_ns = info.messages > 0 ? s->file.begin_ns : 0;
    info.end_ns = info.messages > 0 ? s->file.end_ns : 0;
    return lum_sized_fill(out, &info, sizeof info) ? 0 : -1;
}

/* --- The end --- */

/* A recording without a chunk has no name yet; a pipe has a reader that may
 * have left. */
static int flush(lum_writer *writer, lum_error *error)
{
    state *s = writer->state;
    if (lum_mcap_end_chunk(&s->file, error) != 0) {
        return -1;
    }
    const bool has_chunk = s->file.counts[LUM_MCAP_CHUNKS] > 0;
    return s->is_growing && !has_chunk && lum_sink_seekable(writer->sink)
               ? 0
               : lum_sink_flush(writer->sink, error);
}

static int finish(lum_writer *writer, lum_error *error)
{
    state *s = writer->state;
    return end_frame(writer, error) == 0 ? lum_mcap_end(&s->file, error) : -1;
}

static void release(lum_writer *writer)
{
    state *s = writer->state;
    lum_mcap_free(&s->file);
    lum_ros_points_free(&s->points);
    lum_bytes_free(&s->cloud.rows);
}

const lum_format_ops lum_mcap_ops = {.name = "MCAP",
                                     .ending = ".mcap",
                                     .begin = begin,
                                     .add = add,
                                     .begin_frame = begin_frame,
                                     .end_frame = end_frame,
                                     .set_sensor = set_sensor,
                                     .add_status = add_status,
                                     .add_datagram = add_datagram,
                                     .flush = flush,
                                     .finish = finish,
                                     .release = release};
