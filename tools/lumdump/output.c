#define _POSIX_C_SOURCE 200809L
#include "output.h"

#include "../common/capture_file.h"
#include "bag_folder.h"
#include "base/claim.h"
#include "base/system.h"
#include "capture/capture_writer.h"
#include "cloud/part.h"
#include "numbered.h"
#include "picture.h"
#include "retention.h"
#include "targets.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define NAME_BYTES 4096u

/* Frames whose files are open at once; the eyes are seldom two apart. */
#define OPEN_FRAMES_MAX 16u

/* A new file begins with a frame. If no frame begins for this long after it was
 * due, it begins at any packet. Longer than the duration of a frame. */
#define OVERDUE_NS INT64_C(2000000000)

struct frame_file {
    int64_t frame; /* its own; of a file that ends by rotation, its last */
    lum_writer *writer;
    size_t number;     /* in a folder */
    bool is_told_lost; /* others have removed or renamed it */
};

struct output {
    const struct options *options;
    const char *name;
    bool is_capture;
    bool takes_frames;
    bool is_organized;
    bool takes_packets;
    bool is_recording; /* and has nothing else */
    bool has_messages;
    bool is_picture;
    bool draws_one;
    struct drawn drawn;
    lum_frame *spare; /* to be drawn if no frame is whole; NULL: none */
    bool is_growing;  /* a recording that readers may look at */
    const struct provenance *about; /* a capture's; NULL: it has no room */
    bool is_pattern;
    bool is_in_place; /* read as it comes */
    bool rotates;
    struct closer *closer;       /* NULL: finished here */
    struct retention *retention; /* NULL: no file is removed */
    bool is_begun;     /* the capture's beginning is on its way to the disk */
    bool is_told_lost; /* the capture */
    lum_claim claim;   /* to the name of which others are made */
    lum_writer_options writer_options;
    lum_mcap_options mcap;
    struct frame_file files[OPEN_FRAMES_MAX]; /* the first serves a lone file */
    size_t file_count;
    bool has_ended;
    int64_t ended; /* frames up to this one are finished */
    uint64_t late; /* points without a file */
    uint64_t no_place;
    lum_capture_writer *capture; /* NULL: no capture */
    struct bag_folder *folder;   /* NULL: none is made */
    bool has_time;
    int64_t began_ns; /* when the present file was to begin */
    int64_t now_ns;
    int64_t last_ns; /* of the last data */
    bool is_due;     /* a new file is to begin */
    int64_t due_ns;
    bool has_top;    /* a line is in the present file of a cloud */
    int64_t top;     /* the highest frame there */
    unsigned number; /* of the present file */
};

/* --- Names --- */

/* The pattern's one conversion was checked; a width past two digits would only
 * pad. */
static int frame_name(const char *pattern, int64_t frame, char out[NAME_BYTES],
                      lum_error *error)
{
    const char *percent = strchr(pattern, '%');
    const char *digits = percent + 1;
    const char *rest = strchr(digits, 'd') + 1;
    const long width = strtol(digits, NULL, 10);
    if (width > 64) {
        return lum_error_set(error,
                             "%s: a frame number of %ld digits; use %%04d",
                             pattern, width);
    }
    const int n = snprintf(
        out, NAME_BYTES, *digits == '0' ? "%.*s%0*lld%s" : "%.*s%*lld%s",
        (int)(percent - pattern), pattern, (int)width, (long long)frame, rest);
    if (n < 0 || (size_t)n >= NAME_BYTES) {
        return lum_error_set(error, "%s: the name is too long", pattern);
    }
    return 0;
}

/* --- Opening --- */

static int open_named(struct output *o, const char *name, lum_error *error)
{
    if (o->is_capture) {
        o->is_begun = false;
        o->is_told_lost = false;
        return o->options->is_live
                   ? capture_file_record(name, o->about, &o->capture, error)
                   : capture_file_open(name, o->about, &o->capture, error);
    }
    o->files[0] = (struct frame_file){.number = o->number - 1u};
    if (lum_writer_open(name, &o->writer_options, &o->files[0].writer, error) !=
        0) {
        return -1;
    }
    o->file_count = 1;
    return 0;
}

static int name_next(struct output *o, char out[NAME_BYTES], lum_error *error)
{
    o->number++;
    if (o->retention != NULL &&
        retention_begin(o->retention, &o->number, error) != 0) {
        return -1;
    }
    if (o->folder == NULL) {
        return numbered_name(o->name, o->number, out, NAME_BYTES, error);
    }
    return bag_folder_next_name(o->folder, out, NAME_BYTES)
               ? 0
               : lum_error_set(error, "%s: the name is too long", o->name);
}

static int open_numbered(struct output *o, lum_error *error)
{
    char name[NAME_BYTES];
    if (name_next(o, name, error) != 0 ||
        targets_check_inputs(o->options, name, error) != 0) {
        return -1;
    }
    return open_named(o, name, error);
}

static bool keeps(const struct output *o)
{
    const struct rotation *keep = &o->options->files.keep;
    return o->rotates && (keep->bytes != 0 || keep->ns != 0);
}

/* Without the right to the name another run may be writing the files. */
static int require_claim(const struct output *o, lum_error *error)
{
    if (o->claim.mark != NULL && o->claim.fd >= 0) {
        return 0;
    }
    (void)lum_error_set(error,
                        "%s: --keep needs a folder that this user may write to",
                        o->name);
    errno = EACCES;
    return -1;
}

/* A run that makes several files of a name owns that name until its end. Other
 * errors of the name are reported by its first file, unless --keep was given:
 * then nothing is done without the right. */
static int claim_name(struct output *o, lum_error *error)
{
    const char *percent = strchr(o->name, '%');
    const bool in_many = percent != NULL && percent < lum_system_base(o->name);
    if ((!o->is_pattern && !o->rotates) || in_many || o->folder != NULL) {
        return 0;
    }
    if (lum_claim_take(o->name, o->name, &o->claim, error) != 0) {
        return keeps(o) || errno == EBUSY || errno == EEXIST ? -1 : 0;
    }
    return 0;
}

static int open_retention(struct output *o, lum_error *error)
{
    if (!keeps(o)) {
        return 0;
    }
    return require_claim(o, error) == 0
               ? retention_open(o->name, &o->options->files.keep, &o->retention,
                                error)
               : -1;
}

static int open_first(struct output *o, lum_error *error)
{
    if (claim_name(o, error) != 0 || open_retention(o, error) != 0) {
        return -1;
    }
    if (o->is_pattern) {
        return 0;
    }
    return o->rotates || o->folder != NULL ? open_numbered(o, error)
                                           : open_named(o, o->name, error);
}

static const struct provenance *about_of(const struct options *o, size_t i)
{
    return options_is_recording(o, i) ? o->about.packets : o->about.points;
}

/* Many readers of text do not skip comments. */
static const char *comment_of(const struct options *o, size_t i)
{
    const unsigned format = o->outputs[i].format;
    const bool is_bare = format == LUM_FORMAT_CSV || format == LUM_FORMAT_XYZ;
    if (is_bare && !o->cloud.comments) {
        return NULL;
    }
    return about_of(o, i)->text;
}

static const char *columns_of(const struct options *o, size_t i)
{
    const unsigned format = o->outputs[i].format;
    return !options_is_capture(format) &&
                   lum_format_has_columns((lum_format)format)
               ? o->cloud.columns
               : NULL;
}

static void choose_messages(struct output *o, const struct options *options,
                            const struct provenance *about)
{
    o->is_growing = options->is_live && !o->is_pattern;
    o->mcap = (lum_mcap_options){.struct_size = sizeof o->mcap,
                                 .frame_id = options->mcap.frame_id,
                                 .calibration = options->about.calibration,
                                 .calibration_yaml = about->calibration,
                                 .profile_yaml = about->profile,
                                 .is_plain = options->mcap.is_plain,
                                 .is_growing = o->is_growing,
                                 .contents = options->mcap.contents,
                                 .lines = options->mcap.lines};
}

static struct output *new_output(const struct options *options, size_t i,
                                 const lum_projector *projector)
{
    struct output *o = calloc(1, sizeof *o);
    if (o == NULL) {
        return NULL;
    }
    o->claim = (lum_claim)LUM_CLAIM_NONE;
    o->options = options;
    o->name = options->outputs[i].name;
    o->is_capture = options_is_capture(options->outputs[i].format);
    o->takes_frames = options_takes_frames(options, i);
    o->is_organized = options_is_organized(options, i);
    o->is_picture = options_is_picture(options, i);
    o->draws_one = options_draws_one(options, i);
    o->about = options->outputs[i].format == FORMAT_PCAPNG
                   ? options->about.packets
                   : NULL;
    o->is_pattern = options_pattern(o->name) == 1;
    o->is_in_place = !o->is_pattern && capture_file_is_in_place(o->name);
    o->rotates = options_rotates(options, i);
    o->writer_options = (lum_writer_options){
        .struct_size = sizeof o->writer_options,
        .format = (lum_format)options->outputs[i].format,
        .ascii = options->cloud.ascii,
        .utc = options->points.time != TIME_SENSOR,
        .projector = projector,
        .picture = picture_format(),
        .comment = comment_of(options, i),
        .columns = columns_of(options, i),
        .organized = o->is_organized,
        .preset = options_has_preset(options, i) ? options->cloud.preset : NULL,
        .mcap = &o->mcap};
    o->takes_packets = options_takes_packets(options, i);
    o->is_recording = options_is_recording(options, i);
    o->has_messages = options_has_messages(options, i);
    o->mcap.struct_size = sizeof o->mcap;
    if (options->outputs[i].format == (unsigned)LUM_FORMAT_MCAP) {
        choose_messages(o, options, about_of(options, i));
    }
    return o;
}

int output_open(const struct options *options, size_t i,
                const lum_projector *projector, const struct output *rehearsal,
                struct output **out, lum_error *error)
{
    struct output *o = new_output(options, i, projector);
    if (o == NULL) {
        return lum_error_set(error, "out of memory");
    }
    if (options->outputs[i].is_folder) {
        o->folder = bag_folder_new(o->name, error);
        if (o->folder == NULL) {
            free(o);
            return -1;
        }
    }
    if (rehearsal != NULL) {
        o->writer_options.rehearsal = rehearsal->files[0].writer;
    }
    if (open_first(o, error) != 0) {
        const int code = errno;
        retention_close(o->retention);
        lum_claim_drop(&o->claim);
        bag_folder_free(o->folder);
        free(o);
        errno = code;
        return -1;
    }
    *out = o;
    return 0;
}

int output_rehearse(const struct options *options, size_t i,
                    const lum_projector *projector, struct output **out,
                    lum_error *error)
{
    struct output *o = new_output(options, i, projector);
    if (o == NULL) {
        return lum_error_set(error, "out of memory");
    }
    o->rotates = false;
    if (lum_writer_rehearse(&o->writer_options, &o->files[0].writer, error) !=
        0) {
        free(o);
        return -1;
    }
    o->file_count = 1;
    *out = o;
    return 0;
}

/* --- What is known of an output --- */

void output_finish_by(struct output *output, struct closer *closer)
{
    output->closer = closer;
}

const char *output_name(const struct output *output)
{
    return output->name;
}

const char *output_title(const char *name)
{
    return strcmp(name, "-") == 0 ? "standard output" : name;
}

static bool is_there(const struct output *o, unsigned number,
                     char name[NAME_BYTES])
{
    return numbered_name(o->name, number, name, NAME_BYTES, NULL) == 0 &&
           access(name, F_OK) == 0;
}

bool output_find_stale(const struct output *o, lum_error *out)
{
    char first[NAME_BYTES];
    char second[NAME_BYTES];
    if (!o->rotates || o->folder != NULL || o->retention != NULL ||
        !is_there(o, o->number + 1u, first)) {
        return false;
    }
    const bool has_more = is_there(o, o->number + 2u, second);
    (void)lum_error_set(out,
                        "%s%s of an earlier run: this one ended with number "
                        "%u; remove what you do not need",
                        first, has_more ? " and what follows are" : " is",
                        o->number);
    return true;
}

bool output_wants_lines(const struct output *output)
{
    return !output->is_recording && !output->takes_frames;
}

bool output_wants_frames(const struct output *output)
{
    return output->takes_frames;
}

bool output_draws_one(const struct output *output)
{
    return output->draws_one;
}

/* --- Files that end, rotation --- */

static int finish(struct output *o, struct closing file, lum_error *error)
{
    return o->closer != NULL ? closer_put(o->closer, &file, error)
                             : closing_finish(&file, error);
}

static int close_file(struct output *o, size_t i, lum_error *error)
{
    const struct closing file = {.cloud = o->files[i].writer,
                                 .retention = o->retention,
                                 .number = (unsigned)o->files[i].number + 1u,
                                 .last_ns = o->last_ns};
    if (o->folder != NULL && bag_folder_note(o->folder, o->files[i].number,
                                             file.cloud, error) != 0) {
        return -1;
    }
    if (!o->has_ended || o->files[i].frame > o->ended) {
        o->has_ended = true;
        o->ended = o->files[i].frame;
    }
    o->file_count--;
    o->files[i] = o->files[o->file_count];
    return finish(o, file, error);
}

static int close_capture(struct output *o, lum_error *error)
{
    const struct closing file = {.capture = o->capture,
                                 .retention = o->retention,
                                 .number = o->number,
                                 .last_ns = o->last_ns};
    o->capture = NULL;
    return finish(o, file, error);
}

/* The file of a cloud before the present one, which takes the last lines of its
 * frames. */
static bool has_ending(const struct output *o)
{
    return o->rotates && o->file_count == 2u;
}

static void note_rotated(struct output *o)
{
    const int64_t ns = o->options->files.rotation.ns;
    o->is_due = false;
    o->has_top = false;
    if (ns != 0) {
        const int64_t since_ns = o->now_ns - o->began_ns;
        o->began_ns += since_ns - since_ns % ns;
    }
}

static int rotate(struct output *o, lum_error *error)
{
    int result = has_ending(o) ? close_file(o, 1, error) : 0;
    if (result == 0) {
        result =
            o->is_capture ? close_capture(o, error) : close_file(o, 0, error);
    }
    note_rotated(o);
    return result == 0 ? open_numbered(o, error) : result;
}

/* Of a cloud, whose eyes do not end a frame at once. */
static int rotate_at_frame(struct output *o, lum_error *error)
{
    if (has_ending(o) && close_file(o, 1, error) != 0) {
        return -1;
    }
    o->files[1] = o->files[0];
    o->files[1].frame = o->top;
    note_rotated(o);
    if (open_numbered(o, error) != 0) {
        o->files[0] = o->files[1];
        return -1;
    }
    o->file_count = 2;
    return 0;
}

/* Whether the next file may begin. If not, the present one continues, so that
 * nothing waits for the disk. */
static bool may_rotate(const struct output *o)
{
    if (o->closer == NULL) {
        return true;
    }
    return closer_has_room(o->closer) &&
           (o->retention == NULL || retention_is_planned(o->retention) ||
            !closer_plan(o->closer, o->retention));
}

static uint64_t present_bytes(const struct output *o)
{
    return o->is_capture ? lum_capture_writer_bytes(o->capture)
                         : lum_writer_bytes(o->files[0].writer);
}

static bool is_due(const struct output *o)
{
    const struct rotation *r = &o->options->files.rotation;
    return r->bytes != 0 ? present_bytes(o) >= r->bytes
                         : o->now_ns - o->began_ns >= r->ns;
}

int output_set_time(struct output *o, int64_t time_ns, lum_error *error)
{
    if (!o->rotates) {
        return 0;
    }
    o->now_ns = time_ns;
    /* what ends a capture has no time */
    o->last_ns = time_ns != 0 ? time_ns : o->last_ns;
    if (!o->has_time) {
        o->has_time = true;
        o->began_ns = time_ns;
    }
    if (!o->is_due && is_due(o)) {
        o->is_due = true;
        o->due_ns = time_ns;
        (void)may_rotate(o); /* plan it */
    }
    return o->is_due && time_ns - o->due_ns > OVERDUE_NS && may_rotate(o)
               ? rotate(o, error)
               : 0;
}

/* --- Lines and datagrams --- */

static size_t lowest_file(const struct output *o)
{
    size_t lowest = 0;
    for (size_t i = 1; i < o->file_count; i++) {
        if (o->files[i].frame < o->files[lowest].frame) {
            lowest = i;
        }
    }
    return lowest;
}

/* The file of a frame, opened where there is none. NULL without *failed: that
 * file is finished already. */
static lum_writer *file_of_frame(struct output *o, int64_t frame, bool *failed,
                                 lum_error *error)
{
    char name[NAME_BYTES];
    lum_writer *writer = NULL;
    for (size_t i = 0; i < o->file_count; i++) {
        if (o->files[i].frame == frame) {
            return o->files[i].writer;
        }
    }
    if (o->has_ended && frame <= o->ended) {
        return NULL;
    }
    if ((o->file_count == OPEN_FRAMES_MAX &&
         close_file(o, lowest_file(o), error) != 0) ||
        frame_name(o->name, frame, name, error) != 0 ||
        targets_check_inputs(o->options, name, error) != 0 ||
        lum_writer_open(name, &o->writer_options, &writer, error) != 0) {
        *failed = true;
        return NULL;
    }
    o->files[o->file_count++] =
        (struct frame_file){.frame = frame, .writer = writer};
    return writer;
}

/* Of a cloud that may rotate. */
static lum_writer *present_file(struct output *o, int64_t frame, bool *failed,
                                lum_error *error)
{
    if (o->is_due && o->has_top && frame > o->top && may_rotate(o) &&
        rotate_at_frame(o, error) != 0) {
        *failed = true;
        return NULL;
    }
    if (has_ending(o) && frame <= o->files[1].frame) {
        return o->files[1].writer;
    }
    o->top = o->has_top && o->top > frame ? o->top : frame;
    o->has_top = true;
    return o->files[0].writer;
}

/* The file for points of a frame. NULL without *failed: there is none any
 * more. */
static lum_writer *file_for(struct output *o, int64_t frame, uint64_t points,
                            bool *failed, lum_error *error)
{
    lum_writer *writer = o->is_pattern ? file_of_frame(o, frame, failed, error)
                                       : present_file(o, frame, failed, error);
    o->late += writer == NULL && !*failed ? points : 0;
    return writer;
}

static int add_line(struct output *o, const lum_line_samples *line,
                    lum_error *error)
{
    bool failed = false;
    if (line->count == 0) {
        return 0;
    }
    lum_writer *writer = file_for(o, line->frame, line->count, &failed, error);
    if (writer == NULL) {
        return failed ? -1 : 0;
    }
    return lum_writer_add(writer, line, error);
}

int output_open_part(const struct output *output, lum_writer **out,
                     lum_error *error)
{
    return lum_writer_open_part(output->name, &output->writer_options, out,
                                error);
}

int output_add_rows(struct output *o, int64_t frame, lum_writer *part,
                    lum_error *error)
{
    const uint64_t points = lum_writer_part_points(part);
    bool failed = false;
    if (points == 0) {
        return 0;
    }
    lum_writer *writer = file_for(o, frame, points, &failed, error);
    if (writer == NULL) {
        return failed ? -1 : 0;
    }
    return lum_writer_add_part(writer, part, error);
}

int output_add_line(struct output *o, const lum_line_samples *line,
                    lum_error *error)
{
    return output_wants_lines(o) ? add_line(o, line, error) : 0;
}

/* A frame without any line has no file. */
static int add_rows(struct output *o, struct frame_lines *frame,
                    lum_error *error)
{
    const uint32_t rows = frame_lines_rows(frame);
    bool failed = false;
    int result = 0;
    if (frame_lines_count(frame) == 0) {
        return 0;
    }
    lum_writer *writer =
        o->is_pattern
            ? file_of_frame(o, frame_lines_number(frame), &failed, error)
            : o->files[0].writer;
    if (writer == NULL || lum_writer_set_rows(writer, rows, error) != 0) {
        return failed || writer != NULL ? -1 : 0;
    }
    for (uint32_t i = 0; i < rows && result == 0; i++) {
        lum_line_samples row;
        frame_lines_get_row(frame, i, &row);
        result = lum_writer_add(writer, &row, error);
    }
    o->no_place += frame_lines_left_out(frame);
    return result;
}

/* All of a frame becomes one message; one without any line, none. */
static int add_message(struct output *o, struct frame_lines *frame,
                       lum_error *error)
{
    const int64_t number = frame_lines_number(frame);
    bool failed = false;
    int result = 0;
    if (frame_lines_count(frame) == 0) {
        return 0;
    }
    lum_writer *writer = o->is_pattern
                             ? file_of_frame(o, number, &failed, error)
                             : present_file(o, number, &failed, error);
    if (writer == NULL) {
        o->late += failed ? 0 : frame_lines_points(frame);
        return failed ? -1 : 0;
    }
    result = lum_writer_begin_frame(
        writer,
        frame_lines_begin_ns(frame, o->options->points.time == TIME_ARRIVAL),
        error);
    for (size_t i = 0; i < frame_lines_count(frame) && result == 0; i++) {
        lum_line_samples line;
        frame_lines_get(frame, i, &line);
        result = lum_writer_add(writer, &line, error);
    }
    return result == 0 ? lum_writer_end_frame(writer, error) : -1;
}

static int add_lines(struct output *o, struct frame_lines *frame,
                     lum_error *error)
{
    int result = 0;
    for (size_t i = 0; i < frame_lines_count(frame) && result == 0; i++) {
        lum_line_samples line;
        frame_lines_get(frame, i, &line);
        result = add_line(o, &line, error);
    }
    return result;
}

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
static void keep_spare(struct output *o, const struct frame_lines *lines)
{
    const lum_frame *frame = frame_lines_frame(lines);
    if (o->spare == NULL ||
        (has_nothing_missing(frame) && !has_nothing_missing(o->spare))) {
        lum_frame_release(o->spare);
        o->spare = lum_frame_keep(frame);
    }
}

/* If frames were chosen, draw each; else the first whole one, and keep another
 * as a spare. Each of a rotation, too. */
static int add_to_picture(struct output *o, struct frame_lines *frame,
                          lum_error *error)
{
    const bool is_whole = frame_lines_is_whole(frame);
    const bool is_drawn = !o->draws_one || (is_whole && o->drawn.frames == 0);
    const uint64_t points = frame_lines_points(frame);
    if (points == 0) {
        return 0;
    }
    if (is_drawn) {
        const int result = add_lines(o, frame, error);
        note_drawn(&o->drawn, frame_lines_number(frame), points, is_whole,
                   o->number);
        return result;
    }
    o->drawn.others++;
    if (o->drawn.frames == 0) {
        keep_spare(o, frame);
    }
    return 0;
}

/* Pictures have no times. */
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
        return lum_error_set(error, "%s: out of memory", o->name);
    }
    const int result = add_lines(o, frame, error);
    const int code = errno;
    frame_lines_free(frame);
    errno = code;
    return result;
}

int output_add_frame(struct output *o, struct frame_lines *frame,
                     lum_error *error)
{
    if (!o->takes_frames) {
        return 0;
    }
    if (o->is_picture) {
        return add_to_picture(o, frame, error);
    }
    if (o->has_messages) {
        return add_message(o, frame, error);
    }
    return o->is_organized ? add_rows(o, frame, error)
                           : add_lines(o, frame, error);
}

/* Its name is there, and stays if the power fails: so should be what a reader
 * needs first. Nothing waits for that. */
static int secure_beginning(struct output *o, lum_error *error)
{
    if (lum_capture_writer_flush(o->capture, error) != 0) {
        return -1;
    }
    closer_sync(o->closer, lum_capture_writer_copy(o->capture),
                lum_capture_writer_name(o->capture));
    return 0;
}

/* In a file of one frame it would be that of others. */
int output_add_status(struct output *o, const lum_writer_status *status,
                      lum_error *error)
{
    return o->has_messages && !o->is_pattern
               ? lum_writer_add_status(o->files[0].writer, status, error)
               : 0;
}

static int add_packet(struct output *o, const lum_record *record,
                      lum_error *error)
{
    return lum_writer_add_datagram(
        o->files[0].writer,
        &(lum_writer_datagram){.time_ns = record->time_ns,
                               .payload = record->payload,
                               .len = record->len,
                               .source = record->source,
                               .destination = record->destination,
                               .source_port = record->source_port,
                               .destination_port = record->destination_port},
        error);
}

int output_add_datagram(struct output *o, const lum_record *record,
                        bool begins_frame, lum_error *error)
{
    if (!o->takes_packets) {
        return 0;
    }
    if (o->is_recording && o->is_due && begins_frame && may_rotate(o) &&
        rotate(o, error) != 0) {
        return -1;
    }
    if (!o->is_capture) {
        return add_packet(o, record, error);
    }
    const lum_datagram datagram = {.time_ns = record->time_ns,
                                   .payload = record->payload,
                                   .len = record->len,
                                   .source = record->source,
                                   .destination = record->destination,
                                   .source_port = record->source_port,
                                   .destination_port =
                                       record->destination_port};
    if (lum_capture_writer_add(o->capture, &datagram, error) != 0) {
        return -1;
    }
    if (o->is_begun || o->closer == NULL) {
        return 0;
    }
    o->is_begun = true;
    return secure_beginning(o, error);
}

int output_end_frame(struct output *o, int64_t frame, lum_error *error)
{
    size_t i = 0;
    if (has_ending(o) && o->files[1].frame <= frame) {
        return close_file(o, 1, error);
    }
    if (!o->is_pattern) {
        return 0;
    }
    while (i < o->file_count) {
        if (o->files[i].frame > frame) {
            i++;
        } else if (close_file(o, i, error) != 0) {
            return -1;
        }
    }
    if (!o->has_ended || frame > o->ended) {
        o->has_ended = true;
        o->ended = frame;
    }
    return 0;
}

/* --- The end --- */

int output_flush(struct output *o, bool files, lum_error *error)
{
    if (o->closer != NULL && closer_check(o->closer, error) != 0) {
        return -1;
    }
    if (o->is_capture) {
        return o->is_in_place || files
                   ? lum_capture_writer_flush(o->capture, error)
                   : 0;
    }
    return o->is_in_place || (o->is_growing && files)
               ? lum_writer_flush(o->files[0].writer, error)
               : 0;
}

bool output_find_lost(struct output *o, lum_error *out)
{
    bool is_found = o->capture != NULL && !o->is_told_lost &&
                    lum_capture_writer_check(o->capture, out) != 0;
    o->is_told_lost |= is_found;
    for (size_t i = 0; i < o->file_count && !is_found; i++) {
        struct frame_file *file = &o->files[i];
        is_found =
            !file->is_told_lost && lum_writer_check(file->writer, out) != 0;
        file->is_told_lost |= is_found;
    }
    return is_found ||
           (o->retention != NULL && retention_take_note(o->retention, out));
}

/* A folder has its metadata though files of it were lost.
 * result: that of the files. */
static int finish_folder(struct output *o, int result, lum_error *error)
{
    const int code = errno;
    if (result == 0) {
        return bag_folder_finish(o->folder, error);
    }
    (void)!bag_folder_finish(o->folder, NULL);
    errno = code;
    return result;
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
    int result = 0;
    *end = (struct output_end){.note_count = 0};
    if (o->capture != NULL) {
        result = close_capture(o, error);
    }
    if (result == 0) {
        result = draw_spare(o, error);
    }
    while (result == 0 && o->file_count > 0) {
        result = close_file(o, lowest_file(o), error);
    }
    if (result == 0 && o->closer != NULL) {
        result = closer_wait(o->closer, error);
    }
    if (o->folder != NULL && (result == 0 || errno == ENOENT)) {
        result = finish_folder(o, result, error);
    }
    const int code = errno;
    if (o->retention != NULL && result == 0) {
        note_retention(o->retention, end);
    }
    output_abort(o);
    errno = code;
    return result;
}

void output_abort(struct output *o)
{
    if (o == NULL) {
        return;
    }
    if (o->closer != NULL) {
        (void)closer_wait(o->closer, NULL);
    }
    for (size_t i = 0; i < o->file_count; i++) {
        lum_writer_abort(o->files[i].writer);
    }
    lum_capture_writer_abort(o->capture);
    retention_close(o->retention);
    lum_claim_drop(&o->claim);
    bag_folder_free(o->folder);
    lum_frame_release(o->spare);
    free(o);
}

void output_left_out(const struct output *o, struct left_out *out)
{
    *out = (struct left_out){
        .name = o->name, .late = o->late, .no_place = o->no_place};
}

bool output_drawn(const struct output *o, struct drawn *out)
{
    *out = o->drawn;
    out->name = o->name;
    if (o->drawn.frames == 0 && o->spare != NULL) {
        lum_frame_info info = {.struct_size = sizeof info};
        (void)lum_frame_get_info(o->spare, &info);
        note_drawn(out, info.number, info.points, info.is_complete, o->number);
        out->others--;
    }
    return o->is_picture;
}
