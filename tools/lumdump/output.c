/* One output of a run: makes what its kind needs of lines, frames, packets
 * and statuses, and puts it into the right file. */
#include "output.h"

#include "cloud/part.h"
#include "file_set.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum output_kind {
    KIND_LINES,          /* a cloud, of lines as they come */
    KIND_FRAMES,         /* a cloud, of the lines of whole frames */
    KIND_ROWS,           /* an organised cloud */
    KIND_MESSAGES,       /* one of each frame, and statuses */
    KIND_PICTURES,       /* one of each frame */
    KIND_PICTURE,        /* of all frames */
    KIND_PICTURE_OF_ONE, /* of the first whole one */
    KIND_RECORDING       /* of packets alone */
};

struct output {
    enum output_kind kind;
    unsigned sensor;    /* of a rig: 1 + whose it is alone; 0: of all */
    bool takes_packets; /* a recording; messages may */
    bool by_arrival;    /* times of messages */
    bool rehearses;     /* it writes nothing */
    struct file_set files;
    uint64_t late; /* points without a file */
    uint64_t no_place;
    struct drawn drawn; /* by a picture */
    lum_frame *spare;   /* to be drawn if no frame is whole; NULL: none */
};

/* --- Lines --- */

/* The file for points of a frame; *out is NULL if there is none any more. */
static int find_file(struct output *o, int64_t frame, uint64_t points,
                     struct output_file **out, lum_error *error)
{
    const int result = file_set_of_frame(&o->files, frame, out, error);
    o->late += result == 0 && *out == NULL ? points : 0;
    return result;
}

static int add_line(struct output *o, const lum_line_samples *line,
                    lum_error *error)
{
    struct output_file *file = NULL;
    if (line->count == 0) {
        return 0;
    }
    const int result = find_file(o, line->frame, line->count, &file, error);
    return file == NULL ? result : lum_writer_add(file->cloud, line, error);
}

int output_open_part(const struct output *output, lum_writer **out,
                     lum_error *error)
{
    return lum_writer_open_part(output_name(output),
                                &output->files.format.cloud, out, error);
}

static int add_part(struct output *o, int64_t frame, lum_writer *part,
                    lum_error *error)
{
    const uint64_t points = lum_writer_part_points(part);
    struct output_file *file = NULL;
    if (points == 0) {
        return 0;
    }
    const int result = find_file(o, frame, points, &file, error);
    return file == NULL ? result
                        : lum_writer_add_part(file->cloud, part, error);
}

/* --- Frames --- */

static int add_lines(struct output *o, struct frame_lines *frame,
                     const void *const *extra, lum_error *error)
{
    int result = 0;
    for (size_t i = 0; i < frame_lines_taken(frame)->lines && result == 0;
         i++) {
        lum_line_samples line;
        frame_lines_get(frame, i, &line);
        line.extra = extra;
        result = add_line(o, &line, error);
    }
    return result;
}

/* The file of a frame; *out is NULL also if the frame has no line. */
static int find_frame_file(struct output *o, const struct frame_lines *frame,
                           struct output_file **out, lum_error *error)
{
    *out = NULL;
    return frame_lines_taken(frame)->lines == 0
               ? 0
               : find_file(o, frame_lines_taken(frame)->number,
                           frame_lines_taken(frame)->points, out, error);
}

static int add_rows(struct output *o, struct frame_lines *frame,
                    const void *const *extra, lum_error *error)
{
    const uint32_t rows = frame_lines_rows(frame);
    struct output_file *file = NULL;
    int result = find_frame_file(o, frame, &file, error);
    if (file == NULL) {
        return result;
    }
    result = lum_writer_set_rows(file->cloud, rows, error);
    for (uint32_t i = 0; i < rows && result == 0; i++) {
        lum_line_samples row;
        frame_lines_get_row(frame, i, &row);
        row.extra = extra;
        result = lum_writer_add(file->cloud, &row, error);
    }
    o->no_place += frame_lines_taken(frame)->left_out;
    return result;
}

/* Whose the next message is. */
static int set_sensor(const struct output *o, struct output_file *file,
                      unsigned sensor, lum_error *error)
{
    return lum_writer_set_sensor(
        file->cloud, sensor != 0 && o->sensor == 0 ? sensor - 1u : 0, error);
}

static bool draws(const struct output *o)
{
    return o->kind == KIND_PICTURES || o->kind == KIND_PICTURE ||
           o->kind == KIND_PICTURE_OF_ONE;
}

/* Where packets came without times, nothing is known, whatever was fitted. */
static int64_t begin_ns_of(const struct output *o,
                           const struct frame_lines *frame)
{
    return draws(o) && frame_lines_begin_ns(frame, true) <= 0
               ? 0
               : frame_lines_begin_ns(frame, o->by_arrival);
}

static void foresee(lum_writer *cloud, const struct frame_lines *frame)
{
    for (size_t i = 0; i < frame_lines_taken(frame)->lines; i++) {
        lum_line_samples line;
        if (frame_lines_outline(frame, i, &line)) {
            lum_writer_foresee(cloud, &line);
        }
    }
}

/* All of a frame becomes one message; one without any line, none. */
static int add_message(struct output *o, struct frame_lines *frame,
                       unsigned sensor, lum_error *error)
{
    struct output_file *file = NULL;
    int result = find_frame_file(o, frame, &file, error);
    if (file == NULL) {
        return result;
    }
    result = set_sensor(o, file, sensor, error);
    if (result == 0) {
        result =
            lum_writer_begin_frame(file->cloud, begin_ns_of(o, frame), error);
        foresee(file->cloud, frame);
    }
    for (size_t i = 0; i < frame_lines_taken(frame)->lines && result == 0;
         i++) {
        lum_line_samples line;
        frame_lines_get(frame, i, &line);
        result = lum_writer_add(file->cloud, &line, error);
    }
    return result == 0 ? lum_writer_end_frame(file->cloud, error) : -1;
}

/* --- Pictures --- */

/* file: the number of the picture that it is in. */
static void note_drawn(struct drawn *drawn, int64_t number, uint64_t points,
                       bool is_whole, unsigned file)
{
    drawn->files += drawn->frames == 0 || drawn->file != file ? 1u : 0u;
    drawn->file = file;
    drawn->points += points;
    drawn->first = drawn->frames == 0 ? number : drawn->first;
    drawn->last = number;
    drawn->is_whole = is_whole && drawn->frames == 0;
    drawn->frames++;
}

static bool has_nothing_missing(const lum_frame *frame)
{
    lum_frame_info info = {.struct_size = sizeof info};
    (void)lum_frame_get_info(frame, &info);
    return info.is_complete;
}

/* The first that nothing is known to be missing in, else the first. */
static void keep_spare(struct output *o, const struct frame_lines *frame_lines)
{
    const lum_frame *frame = frame_lines_taken(frame_lines)->frame;
    if (o->spare == NULL ||
        (has_nothing_missing(frame) && !has_nothing_missing(o->spare))) {
        lum_frame_release(o->spare);
        o->spare = lum_frame_keep(frame);
    }
}

static int draw(struct output *o, struct frame_lines *frame, lum_error *error)
{
    const uint64_t points = frame_lines_taken(frame)->points;
    if (points == 0) {
        return 0;
    }
    const int result = add_message(o, frame, 0, error);
    note_drawn(&o->drawn, frame_lines_taken(frame)->number, points,
               frame_lines_taken(frame)->is_whole, o->files.names.number);
    return result;
}

/* The first whole one; another is kept as a spare. */
static int draw_first_whole(struct output *o, struct frame_lines *frame,
                            lum_error *error)
{
    if (frame_lines_taken(frame)->is_whole && o->drawn.frames == 0) {
        return draw(o, frame, error);
    }
    if (frame_lines_taken(frame)->points == 0) {
        return 0;
    }
    o->drawn.others++;
    if (o->drawn.frames == 0) {
        keep_spare(o, frame);
    }
    return 0;
}

/* Pictures have no times of lines. */
static int64_t no_clock(const void *context, const lum_frame_line *line)
{
    (void)context;
    (void)line;
    return 0;
}

static int draw_spare(struct output *o, lum_error *error)
{
    if (o->spare == NULL || o->drawn.frames > 0) {
        return 0;
    }
    struct frame_lines *frame = frame_lines_new(3u, no_clock, NULL);
    if (frame == NULL || frame_lines_take(frame, o->spare, false) != 0) {
        frame_lines_free(frame);
        errno = ENOMEM;
        return lum_error_set(error, "%s: out of memory", output_name(o));
    }
    const int result = add_message(o, frame, 0, error);
    const int code = errno;
    frame_lines_free(frame);
    errno = code;
    return result;
}

/* --- What it is given --- */

static int add_frame(struct output *o, const struct action *action,
                     lum_error *error)
{
    struct frame_lines *frame = action->frame;
    switch (o->kind) {
    case KIND_FRAMES:
        return add_lines(o, frame, action->extra, error);
    case KIND_ROWS:
        return add_rows(o, frame, action->extra, error);
    case KIND_MESSAGES:
        return add_message(o, frame, action->sensor, error);
    case KIND_PICTURES:
        return frame_lines_taken(frame)->points > 0
                   ? add_message(o, frame, 0, error)
                   : 0;
    case KIND_PICTURE:
        return draw(o, frame, error);
    case KIND_PICTURE_OF_ONE:
        return draw_first_whole(o, frame, error);
    case KIND_LINES:
    case KIND_RECORDING:
    default:
        return 0;
    }
}

/* Of other sensors it takes nothing. */
static bool is_for(const struct output *o, const struct action *action)
{
    return o->sensor == 0 || action->sensor == 0 || o->sensor == action->sensor;
}

int output_act(struct output *o, const struct action *action, lum_error *error)
{
    const int64_t number = action->number;
    if (!is_for(o, action)) {
        return 0;
    }
    switch (action->kind) {
    case SET_TIME:
        return file_set_set_time(&o->files, number, error);
    case ADD_LINE:
        return o->kind == KIND_LINES ? add_line(o, action->line, error) : 0;
    case ADD_ROWS:
        return add_part(o, number, action->part, error);
    case ADD_FRAME:
        return add_frame(o, action, error);
    case ADD_STATUS:
        return o->kind == KIND_MESSAGES
                   ? file_set_add_status(&o->files, action->status, error)
                   : 0;
    case ADD_DATAGRAM:
        /* beside clouds a new file begins with a frame of theirs */
        return o->takes_packets
                   ? file_set_add_datagram(
                         &o->files, action->record,
                         o->kind == KIND_RECORDING && number != 0, error)
                   : 0;
    case END_FRAME:
        return file_set_end_frame(&o->files, number, error);
    case FLUSH:
    default:
        return file_set_flush(&o->files, number != 0, error);
    }
}

/* --- From the beginning to the end --- */

static enum output_kind kind_of(const struct options *o, size_t i)
{
    if (options_is_recording(o, i)) {
        return KIND_RECORDING;
    }
    if (o->outputs[i].format == (unsigned)LUM_FORMAT_PNG) {
        return !options_is_picture(o, i) ? KIND_PICTURES
               : options_draws_one(o, i) ? KIND_PICTURE_OF_ONE
                                         : KIND_PICTURE;
    }
    if (options_has_messages(o, i)) {
        return KIND_MESSAGES;
    }
    if (options_is_organized(o, i)) {
        return KIND_ROWS;
    }
    if (o->cloud.voxel > 0) {
        return KIND_LINES;
    }
    return options_takes_frames(o, i) ? KIND_FRAMES : KIND_LINES;
}

int output_open(const struct options *options, size_t i, bool rehearses,
                const struct output *rehearsal, struct output **out,
                lum_error *error)
{
    struct output *o = calloc(1, sizeof *o);
    *out = o;
    if (o == NULL) {
        return lum_error_set(error, "out of memory");
    }
    o->kind = kind_of(options, i);
    o->rehearses = rehearses;
    o->sensor = options->outputs[i].sensor;
    o->takes_packets = options_takes_packets(options, i);
    o->by_arrival = options->points.time == TIME_ARRIVAL;
    file_set_prepare(options, i, &o->files);
    return rehearses
               ? file_set_rehearse(&o->files, error)
               : file_set_open(&o->files,
                               rehearsal != NULL ? &rehearsal->files : NULL,
                               error);
}

void output_finish_by(struct output *output, struct closer *closer)
{
    output->files.closer = closer;
}

static void note_retention(struct retention *retention, struct output_end *end)
{
    retention_count(retention, &end->retention);
    while (end->note_count < RETENTION_NOTES &&
           retention_take_note(retention, &end->notes[end->note_count])) {
        end->note_count++;
    }
}

int output_close(struct output *o, struct output_end *end, lum_error *error)
{
    const struct file_names *names = &o->files.names;
    *end = (struct output_end){.note_count = 0};
    end->note_count = file_names_find_stale(names, &end->notes[0]) ? 1u : 0;
    int result = draw_spare(o, error);
    if (result == 0) {
        result = file_set_close(&o->files, error);
    }
    const int code = errno;
    if (names->retention != NULL && result == 0) {
        note_retention(names->retention, end);
    }
    output_abort(o);
    errno = code;
    return result;
}

void output_abort(struct output *o)
{
    if (o != NULL) {
        file_set_abort(&o->files);
        lum_frame_release(o->spare);
        free(o);
    }
}

/* --- What is known of it --- */

const char *output_name(const struct output *output)
{
    return output->files.names.name;
}

const char *output_title(const char *name)
{
    return strcmp(name, "-") == 0 ? "standard output" : name;
}

bool output_wants_lines(const struct output *output)
{
    return output->kind == KIND_LINES;
}

bool output_wants_frames(const struct output *output)
{
    return output->kind != KIND_LINES && output->kind != KIND_RECORDING;
}

bool output_wants_points(const struct output *output)
{
    return output_wants_lines(output) &&
           !(output->rehearses &&
             lum_format_has_parts(output->files.format.cloud.format));
}

bool output_draws_one(const struct output *output)
{
    return output->kind == KIND_PICTURE_OF_ONE;
}

bool output_find_lost(struct output *output, lum_error *out)
{
    return file_set_find_lost(&output->files, out);
}

void output_left_out(const struct output *o, struct left_out *out)
{
    *out = (struct left_out){
        .name = output_name(o), .late = o->late, .no_place = o->no_place};
}

bool output_drawn(const struct output *o, struct drawn *out)
{
    *out = o->drawn;
    out->name = output_name(o);
    if (o->drawn.frames == 0 && o->spare != NULL) {
        lum_frame_info info = {.struct_size = sizeof info};
        (void)lum_frame_get_info(o->spare, &info);
        note_drawn(out, info.number, info.points, info.is_complete,
                   o->files.names.number);
        out->others--;
    }
    return o->kind == KIND_PICTURE || o->kind == KIND_PICTURE_OF_ONE;
}
