#define _POSIX_C_SOURCE 200809L
#include "page_status.h"

#include "../common/json.h"
#include "../common/profile_difference.h"
#include "base/text.h"
#include "lum/image.h"
#include "lum/laser.h"
#include "lum/pose.h"
#include "lum/smooth.h"
#include "lum/version.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Beyond it the page gets one of so many poses, between which it goes straight.
 */
#define POSES_MAX 50000u

static const char *const states[] = {
    [FEED_WAITING] = "waiting", [FEED_PLAYING] = "playing",
    [FEED_PAUSED] = "paused",   [FEED_ENDED] = "ended",
    [FEED_SILENT] = "silent",   [FEED_FAILED] = "failed",
};

/* --- Rates --- */

void status_update(struct status *status, const struct feed_status *feed,
                   int64_t now_ns, bool at_tick)
{
    status->feed = *feed;
    if (!at_tick) {
        return;
    }
    if (status->sample_count == STATUS_SAMPLES) {
        (void)memmove(status->samples, status->samples + 1,
                      (STATUS_SAMPLES - 1u) * sizeof status->samples[0]);
        status->sample_count--;
    }
    status->samples[status->sample_count++] =
        (struct status_sample){.time_ns = now_ns,
                               .points = feed->decoded.points,
                               .frames = feed->frames,
                               .frame_ns = feed->frame_ns,
                               .bytes = feed->received.bytes};
}

bool status_differs(const struct feed_status *a, const struct feed_status *b)
{
    bool differs = false;
    for (size_t i = 0; i < FEED_TEXTS; i++) {
        differs |= strcmp(a->texts[i], b->texts[i]) != 0;
    }
    return differs || a->state != b->state || a->loops != b->loops ||
           a->speed < b->speed || a->speed > b->speed ||
           a->has_range != b->has_range || a->has_laser != b->has_laser ||
           a->laser != b->laser;
}

/* --- Texts --- */

static int begin(size_t room_before, struct text *out, FILE **stream,
                 struct json *json)
{
    *out = (struct text){NULL, NULL, 0};
    *stream = open_memstream(&out->memory, &out->len);
    if (*stream == NULL) {
        return -1;
    }
    for (size_t i = 0; i < room_before; i++) {
        (void)fputc(0, *stream);
    }
    json_begin_line(json, *stream);
    return 0;
}

static int end(size_t room_before, struct text *out, FILE *stream,
               struct json *json)
{
    json_close_object(json);
    const bool is_bad = ferror(stream) != 0;
    if (fclose(stream) != 0 || is_bad) {
        free(out->memory);
        out->memory = NULL;
        return -1;
    }
    out->bytes = out->memory + room_before;
    out->len -= room_before;
    return 0;
}

/* --- The first text --- */

static void write_numbers(struct json *json, const char *key,
                          const float *numbers, size_t count)
{
    json_open_array(json, key);
    for (size_t i = 0; i < count; i++) {
        json_real(json, NULL, (double)numbers[i], 9);
    }
    json_close_array(json);
}

static void write_eyes(struct json *json, const struct feed *feed,
                       size_t sensors)
{
    static const char *const names[] = {"blue", "green"};
    json_open_array(json, "eyes");
    for (unsigned eye = 0; eye < 2u * sensors; eye++) {
        float mount[3];
        float rotation[9];
        feed_geometry(feed, eye, mount, rotation);
        json_open_object(json, NULL);
        json_text(json, "name", names[eye % 2u]);
        write_numbers(json, "mount", mount, 3);
        write_numbers(json, "rotation", rotation, 9);
        json_close_object(json);
    }
    json_close_array(json);
}

static void write_differences(struct json *json, const struct feed *feed)
{
    struct profile_difference all[LUM_KEYS_MAX];
    const size_t count = profile_differences(feed_profile(feed, false),
                                             feed_profile(feed, true), all);
    json_open_array(json, "differences");
    for (size_t i = 0; i < count; i++) {
        json_open_object(json, NULL);
        json_text(json, "key", all[i].key);
        json_text(json, "one", all[i].one);
        json_text(json, "other", all[i].other);
        json_close_object(json);
    }
    json_close_array(json);
}

/* Rotation and place, three rows of four numbers. */
static void write_pose(struct json *json, const lum_rig_sensor *sensor)
{
    double at[3];
    double matrix[12];
    for (size_t i = 0; i < 3u; i++) {
        at[i] = sensor->at_um[i] * 1e-6;
    }
    const lum_pose pose =
        lum_pose_of_angles(at, sensor->roll_udeg * 1e-6,
                           sensor->pitch_udeg * 1e-6, sensor->yaw_udeg * 1e-6);
    lum_pose_matrix(&pose, matrix);
    json_open_array(json, NULL);
    for (size_t i = 0; i < 12u; i++) {
        json_real(json, NULL, matrix[i], 12);
    }
    json_close_array(json);
}

static void write_rig(struct json *json, const lum_rig *rig, size_t shown)
{
    json_open_object(json, "rig");
    json_text(json, "frame", rig->frame);
    json_open_array(json, "sensors");
    for (size_t i = 0; i < shown; i++) {
        json_text(json, NULL, rig->sensor[i].name);
    }
    json_close_array(json);
    json_open_array(json, "poses");
    for (size_t i = 0; i < shown; i++) {
        write_pose(json, &rig->sensor[i]);
    }
    json_close_array(json);
    json_close_object(json);
}

/* Of both eyes; the rows of a frame are a multiple of these. */
static void write_image(struct json *json)
{
    lum_image_view view;
    lum_image_view_default(&view, LUM_IMAGE_BOTH, 1);
    json_open_object(json, "image");
    json_real(json, "left", (double)view.left_deg, 9);
    json_real(json, "right", (double)view.right_deg, 9);
    json_real(json, "top", (double)view.top_deg, 9);
    json_real(json, "bottom", (double)view.bottom_deg, 9);
    json_uint(json, "columns", view.columns);
    json_uint(json, "rows_step", view.rows);
    json_close_object(json);
}

/* Of two that are shown side by side. */
static void write_profiles(struct json *json, const struct options *options,
                           const struct feed *feed)
{
    if (feed_profile(feed, true) == NULL) {
        json_null(json, "profiles");
        return;
    }
    json_open_object(json, "profiles");
    json_text(json, "one", options->profile);
    json_text(json, "other", options->second);
    write_differences(json, feed);
    json_close_object(json);
}

/* Seconds, x y z, and the quaternion. */
static void write_row(struct json *json, int64_t time_ns, const lum_pose *pose)
{
    json_open_array(json, NULL);
    json_real(json, NULL, (double)time_ns * 1e-9, 6);
    for (size_t i = 0; i < 3; i++) {
        json_real(json, NULL, pose->at[i], 4);
    }
    for (size_t i = 0; i < 4; i++) {
        json_real(json, NULL, pose->turn[i], 7);
    }
    json_close_array(json);
}

static void write_poses(struct json *json, const lum_poses *poses)
{
    lum_poses_info info = {.struct_size = sizeof info};
    if (lum_poses_get_info(poses, &info) != LUM_OK) {
        return;
    }
    const size_t every = (info.count + POSES_MAX - 1u) / POSES_MAX;
    json_open_object(json, "poses");
    json_bool(json, "utc", info.clock == LUM_POSES_UTC);
    json_uint(json, "every", every);
    json_open_array(json, "rows");
    for (size_t i = 0; i < info.count; i += every) {
        lum_pose pose;
        int64_t time_ns = 0;
        lum_poses_get(poses, i, &time_ns, &pose);
        write_row(json, time_ns, &pose);
    }
    json_close_array(json);
    json_close_object(json);
}

static void write_beside(struct json *json, const struct beside_options *beside)
{
    if (beside->labels != NULL) {
        json_text(json, "labels", beside->labels);
    }
    if (beside->truth != NULL) {
        json_text(json, "truth", beside->truth);
    }
    if (beside->poses != NULL) {
        write_poses(json, beside->poses);
    }
}

int status_hello(const struct options *options, const struct feed *feed,
                 size_t room_before, struct text *out)
{
    struct json json;
    FILE *stream = NULL;
    if (begin(room_before, out, &stream, &json) != 0) {
        return -1;
    }
    json_text(&json, "type", "hello");
    json_text(&json, "version", LUM_VERSION);
    json_text(&json, "source", options->source);
    json_bool(&json, "live", options->is_live);
    write_eyes(&json, feed, options->rig != NULL ? options->shown : 1u);
    if (options->rig != NULL) {
        write_rig(&json, &options->rig->rig, options->shown);
    }
    write_profiles(&json, options, feed);
    write_image(&json);
    write_beside(&json, &options->beside);
    json_uint(&json, "smooth_max", LUM_SMOOTH_WINDOW_MAX);
    return end(room_before, out, stream, &json);
}

/* --- The status --- */

/* Whole frames, from the end of one to the end of another: a part of a frame
 * more or less would be an error of a tenth of a second. */
static double frame_rate(const struct status_sample *a,
                         const struct status_sample *b)
{
    const double seconds = (double)(b->frame_ns - a->frame_ns) * 1e-9;
    return a->frames > 0 && seconds > 0
               ? (double)(b->frames - a->frames) / seconds
               : 0;
}

/* A second and a half at most: the displayed rate should neither jump nor
 * lag. */
static void write_rates(struct json *json, const struct status *status)
{
    double points = 0;
    double frames = 0;
    double bytes = 0;
    if (status->sample_count > 1) {
        const struct status_sample *a = &status->samples[0];
        const struct status_sample *b =
            &status->samples[status->sample_count - 1u];
        const double seconds = (double)(b->time_ns - a->time_ns) * 1e-9;
        if (seconds > 0) {
            points = (double)(b->points - a->points) / seconds;
            frames = frame_rate(a, b);
            bytes = (double)(b->bytes - a->bytes) / seconds;
        }
    }
    json_real(json, "points_per_second", points, 1);
    json_real(json, "frames_per_second", frames, 3);
    json_real(json, "bytes_per_second", bytes, 1);
}

static void write_laser(struct json *json, const struct feed_status *f)
{
    if (!f->has_laser) {
        json_null(json, "laser");
        return;
    }
    json_open_object(json, "laser");
    json_uint(json, "status", f->laser);
    json_bool(json, "up", !lum_laser_is_down(f->laser));
    json_bool(json, "on", lum_laser_is_on(f->laser));
    json_laser_bits(json, "bits", f->laser);
    json_laser_bits(json, "hazards", f->laser & LUM_LASER_HAZARDS);
    json_close_object(json);
}

static void write_losses(struct json *json, const struct feed_status *f)
{
    json_open_object(json, "losses");
    json_uint(json, "wire_words", f->decoded.lost_words);
    json_uint(json, "wire_lines", f->decoded.lost_lines);
    json_uint(json, "joined_words", f->decoded.joined_words);
    json_uint(json, "joined_lines", f->decoded.joined_lines);
    json_uint(json, "pauses", f->decoded.pauses);
    json_uint(json, "kernel", f->dropped.kernel);
    json_uint(json, "ring", f->dropped.ring);
    json_uint(json, "refused", f->decoded.refused);
    json_close_object(json);
}

static void write_message(struct json *json, const struct feed_status *f)
{
    char text[sizeof f->texts + 8u] = "";
    for (size_t i = 0; i < FEED_TEXTS; i++) {
        if (f->texts[i][0] != '\0') {
            lum_text_list(text, sizeof text, "; ", f->texts[i]);
        }
    }
    json_text(json, "message", text);
}

static void write_place(struct json *json, const struct feed_status *f)
{
    json_int(json, "frame", f->frame);
    if (f->has_range) {
        json_int(json, "first_frame", f->first_frame);
        json_int(json, "last_frame", f->last_frame);
    } else {
        json_null(json, "first_frame");
        json_null(json, "last_frame");
    }
    json_real(json, "scanned", f->scanned, 3);
    json_real(json, "speed", f->speed, 6);
    json_bool(json, "loop", f->loops);
}

/* How many frames each is of, and [frame, words, pauses, lines]. */
static void write_marks(struct json *json, const struct feed_marks *marks)
{
    json_int(json, "mark_frames", marks->frames);
    json_open_array(json, "marks");
    for (size_t i = 0; i < marks->count; i++) {
        const struct feed_mark *mark = &marks->at[i];
        json_open_array(json, NULL);
        json_int(json, NULL, mark->frame);
        json_uint(json, NULL, mark->loss.words);
        json_uint(json, NULL, mark->loss.pauses);
        json_uint(json, NULL, mark->loss.lines);
        json_close_array(json);
    }
    json_close_array(json);
}

int status_text(const struct status *status, uint64_t skipped, bool has_marks,
                size_t room_before, struct text *out)
{
    const struct feed_status *f = &status->feed;
    struct json json;
    FILE *stream = NULL;
    if (begin(room_before, out, &stream, &json) != 0) {
        return -1;
    }
    json_text(&json, "type", "status");
    json_text(&json, "state", states[f->state]);
    json_bool(&json, "live", f->is_live);
    write_message(&json, f);
    write_place(&json, f);
    json_uint(&json, "packets", f->received.packets);
    json_uint(&json, "packets_joined", f->received.joined);
    json_uint(&json, "bytes", f->received.bytes);
    json_uint(&json, "points", f->decoded.points);
    json_uint(&json, "frames", f->frames);
    write_rates(&json, status);
    write_losses(&json, f);
    write_laser(&json, f);
    json_uint(&json, "browsers", status->browsers);
    json_uint(&json, "skipped", skipped);
    if (!has_marks) {
        write_marks(&json, &status->marks);
    }
    return end(room_before, out, stream, &json);
}
