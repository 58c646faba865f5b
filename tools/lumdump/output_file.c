/* One file of an output, a cloud or a capture: its format by the options; it is
 * opened, given packets, flushed and finished. */
#include "output_file.h"

#include "../common/capture_file.h"
#include "base/system.h"
#include "cloud/part.h"
#include "rig_run.h"

#include <stdio.h>
#include <string.h>

/* --- Its format --- */

/* A rig's sensors have a topic and a frame each; where points are in the
 * vehicle's frame, or in the world, that is the frame of all. */
static void add_sensors(const struct options *o, size_t i, const char *frame_id,
                        struct file_format *out)
{
    const struct rig *rig = o->rig;
    const unsigned only = o->outputs[i].sensor;
    out->mcap.sensor_count = only != 0 ? 1u : rig->count;
    for (size_t k = 0; k < out->mcap.sensor_count; k++) {
        out->sensors[k] = rig->messages[only != 0 ? only - 1u : k];
        if (rig->is_placed) {
            out->sensors[k].frame_id = frame_id;
            out->sensors[k].pose = NULL;
            out->sensors[k].calibration = NULL;
        }
    }
    out->mcap.frame_id = frame_id;
    out->mcap.calibration_yaml = NULL;
    out->mcap.profile_yaml = NULL;
    out->mcap.sensors = out->sensors;
}

/* Each thread has chunks of its own in memory, and a third one would hardly
 * help. What a recording has received, and what decides on a new file, is
 * written without them. */
static unsigned packing_threads(const struct options *o)
{
    const unsigned threads = options_threads(o);
    if (threads == 1u || o->is_live ||
        options_is_rotation(&o->files.rotation)) {
        return 0;
    }
    return o->points.threads != 0 ? threads : 2u;
}

/* Points in the world are in another frame than those of the sensor, whose
 * mounts then tell nothing. */
static lum_mcap_options mcap_of(const struct options *o,
                                const struct provenance *about, bool is_growing)
{
    const bool is_in_world = options_is_in_world(o);
    return (lum_mcap_options){
        .struct_size = sizeof(lum_mcap_options),
        .frame_id =
            is_in_world && o->mcap.frame_id == NULL ? "map" : o->mcap.frame_id,
        .calibration = is_in_world ? NULL : o->about.calibration,
        .calibration_yaml = about->calibration,
        .profile_yaml = about->profile,
        .is_plain = o->mcap.is_plain,
        .is_growing = is_growing,
        .contents = o->mcap.contents,
        .lines = o->mcap.lines};
}

/* What the i-th output says of itself. */
static const struct provenance *about_of(const struct options *o, size_t i)
{
    const unsigned sensor = o->outputs[i].sensor;
    const bool of_packets = options_is_recording(o, i);
    if (o->rig == NULL || (sensor == 0 && !o->rig->is_one)) {
        return of_packets ? o->about.packets : o->about.points;
    }
    const struct rig_sensor *s =
        &o->rig->sensors[sensor != 0 ? sensor - 1u : 0];
    return of_packets ? &s->packets : &s->points;
}

/* --- What a picture says of itself --- */

static const char *source_of(const struct options *o)
{
    return o->is_live                    ? o->source
           : strcmp(o->source, "-") == 0 ? "standard input"
                                         : lum_system_base(o->source);
}

/* One's own, the capture's or the built-in one. */
static const char *calibration_of(const struct options *o, unsigned sensor,
                                  const struct provenance *about)
{
    const char *path = o->config.calibration;
    if (o->rig != NULL) {
        const size_t k = sensor != 0 ? sensor - 1u : 0;
        path = o->rig->files.sensor[o->rig->sensors[k].place].calibration_path;
        path = path[0] != '\0' ? path : NULL;
    }
    return path != NULL                    ? lum_system_base(path)
           : about->calibration[0] == '\0' ? "typical"
           : set_keys_first(&o->config.set, false) != NULL ? "by --set"
                                                           : "the capture's";
}

static void put_return(char out[40], const lum_selection *s)
{
    static const char *const names[] = {[LUM_RETURNS_ALL] = "all returns",
                                        [LUM_RETURNS_FIRST] = "first return",
                                        [LUM_RETURNS_LAST] = "last return",
                                        [LUM_RETURNS_STRONGEST] =
                                            "strongest return"};
    if (s->returns == LUM_RETURNS_NUMBER) {
        (void)snprintf(out, 40, "return %u", (unsigned)s->return_number);
    } else {
        (void)snprintf(out, 40, "%s", names[s->returns]);
    }
}

static void add_drawing(const struct options *o, size_t i,
                        const struct provenance *about, struct file_format *out)
{
    static const char *const edges[] = {[LUM_EDGES_RISING] = "rising edge",
                                        [LUM_EDGES_FALLING] = "falling edge",
                                        [LUM_EDGES_BOTH] = "both edges"};
    const unsigned sensor = o->outputs[i].sensor;
    const bool is_named = o->rig != NULL && sensor != 0;
    const bool is_placed = o->rig != NULL && o->rig->is_placed;
    char returns[40];
    put_return(returns, &o->choice.points);
    (void)snprintf(out->title, sizeof out->title, "%.100s%s%s", source_of(o),
                   is_named ? ", " : "",
                   is_named ? o->rig->sensors[sensor - 1u].of->name : "");
    (void)snprintf(out->note, sizeof out->note, "%s, %s, calibration: %s",
                   edges[o->choice.points.edges], returns,
                   calibration_of(o, sensor, about));
    out->drawing = (lum_picture_options){
        .struct_size = sizeof out->drawing,
        .colour = (lum_picture_colour)o->cloud.picture.colour,
        .width = o->cloud.picture.width,
        .height = o->cloud.picture.height,
        .title = out->title,
        .note = out->note,
        .pose = is_placed ? &o->rig->sensors[sensor != 0 ? sensor - 1u : 0].pose
                          : NULL};
    out->cloud.drawing = &out->drawing;
}

void file_format_choose(const struct options *o, size_t i,
                        struct file_format *out)
{
    const unsigned format = o->outputs[i].format;
    const bool is_mcap = format == (unsigned)LUM_FORMAT_MCAP;
    const struct provenance *about = about_of(o, i);
    *out = (struct file_format){.is_capture = options_is_capture(format)};
    out->is_growing = o->is_live && options_pattern(o->outputs[i].name) != 1 &&
                      (out->is_capture || is_mcap);
    if (out->is_capture) {
        out->about = format == FORMAT_PCAPNG ? about : NULL;
        return;
    }
    out->cloud = (lum_writer_options){
        .struct_size = sizeof out->cloud,
        .format = (lum_format)format,
        .ascii = o->cloud.ascii,
        .utc = o->points.time != TIME_SENSOR,
        .picture = lum_picture_format(),
        .comment = options_has_comment(o, format) ? about->text : NULL,
        .columns = lum_format_has_columns((lum_format)format) ? o->cloud.columns
                                                              : NULL,
        .voxels = o->cloud.voxel > 0,
        .organized = options_is_organized(o, i),
        .origin = {o->about.origin[0], o->about.origin[1], o->about.origin[2]},
        .preset = options_has_preset(o, i) ? o->cloud.preset : NULL};
    if (format == (unsigned)LUM_FORMAT_PNG) {
        add_drawing(o, i, about, out);
    }
    if (is_mcap) {
        out->mcap = mcap_of(o, about, out->is_growing);
        out->cloud.mcap = &out->mcap;
        out->packing_threads = packing_threads(o);
    }
    if (is_mcap && o->rig != NULL) {
        add_sensors(o, i,
                    options_is_in_world(o) ? "map" : o->rig->files.rig.frame,
                    out);
    }
    if (rig_has_column(o, i)) {
        static const lum_writer_extra column = {RIG_COLUMN, LUM_NUMBER_U8};
        out->cloud.extra = &column;
        out->cloud.extra_count = 1;
    }
}

/* --- From the beginning to the end --- */

int output_file_open(const struct file_format *format, const char *name,
                     struct output_file *out, lum_error *error)
{
    *out = (struct output_file){.number = 0};
    if (!format->is_capture) {
        const int result =
            lum_writer_open(name, &format->cloud, &out->cloud, error);
        if (result == 0) {
            lum_writer_pack_by(out->cloud, format->packing_threads);
        }
        return result;
    }
    return format->is_growing
               ? capture_file_record(name, format->about, &out->capture, error)
               : capture_file_open(name, format->about, &out->capture, error);
}

uint64_t output_file_bytes(const struct output_file *file)
{
    return file->cloud != NULL ? lum_writer_bytes(file->cloud)
                               : lum_capture_writer_bytes(file->capture);
}

int output_file_add_datagram(struct output_file *file, const lum_record *record,
                             lum_error *error)
{
    if (file->cloud != NULL) {
        return lum_writer_add_datagram(
            file->cloud,
            &(lum_writer_datagram){.time_ns = record->time_ns,
                                   .payload = record->payload,
                                   .len = record->len,
                                   .source = record->source,
                                   .destination = record->destination,
                                   .source_port = record->source_port,
                                   .destination_port =
                                       record->destination_port},
            error);
    }
    return lum_capture_writer_add(
        file->capture,
        &(lum_datagram){.time_ns = record->time_ns,
                        .payload = record->payload,
                        .len = record->len,
                        .source = record->source,
                        .destination = record->destination,
                        .source_port = record->source_port,
                        .destination_port = record->destination_port},
        error);
}

int output_file_flush(struct output_file *file, lum_error *error)
{
    return file->cloud != NULL ? lum_writer_flush(file->cloud, error)
                               : lum_capture_writer_flush(file->capture, error);
}

bool output_file_find_lost(struct output_file *file, lum_error *out)
{
    if (file->is_told_lost) {
        return false;
    }
    const int result = file->cloud != NULL
                           ? lum_writer_check(file->cloud, out)
                           : lum_capture_writer_check(file->capture, out);
    file->is_told_lost = result != 0;
    return file->is_told_lost;
}

int output_file_close(const struct output_file *file, lum_error *error)
{
    return file->cloud != NULL ? lum_writer_close(file->cloud, error)
                               : lum_capture_writer_close(file->capture, error);
}
