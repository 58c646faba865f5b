/* An output's open files: names and opens them, rotates by size or time,
 * chooses the file for each frame or packet, finishes them. */
#define _POSIX_C_SOURCE 200809L
#include "file_set.h"

#include "../common/capture_file.h"
#include "numbered.h"
#include "targets.h"

#include "base/system.h"
#include "capture/capture_internal.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

/* A new file begins with a frame. If no frame begins for this long after it was
 * due, it begins at any packet. Longer than the duration of a frame. */
#define OVERDUE_NS INT64_C(2000000000)

/* Below each number of a frame. */
#define NO_FRAME INT64_MIN

/* --- Their names --- */

/* Those of the i-th output, without any right to them. */
static struct file_names names_of(const struct options *options, size_t i)
{
    const struct output_options *output = &options->outputs[i];
    struct file_names names = {
        .options = options, .name = output->name, .claim = LUM_CLAIM_NONE};
    if (output->is_folder) {
        names.kind = FILE_NAMES_IN_FOLDER;
    } else if (options_rotates(options, i)) {
        names.kind = FILE_NAMES_NUMBERED;
    } else if (options_pattern(output->name) == 1) {
        names.kind = FILE_NAMES_OF_FRAMES;
    }
    return names;
}

/* Without the right to the name another run may be writing the files. */
static int open_retention(struct file_names *n, lum_error *error)
{
    if (n->claim.mark == NULL || n->claim.fd < 0) {
        (void)lum_error_set(
            error, "%s: --keep needs a folder that this user may write to",
            n->name);
        errno = EACCES;
        return -1;
    }
    return retention_open(n->name, &n->options->files.keep, &n->retention,
                          error);
}

static bool has_folder_for_each(const struct file_names *n)
{
    const char *percent = strchr(n->name, '%');
    return percent != NULL && percent < lum_system_base(n->name);
}

/* Takes the right to all names, if there may be several files; makes the
 * folder. A run that makes several files of a name owns that name until its
 * end. Other errors of the name are reported by its first file, unless --keep
 * was given: then nothing is done without the right. */
static int take_names(struct file_names *n, lum_error *error)
{
    const bool keeps = n->kind == FILE_NAMES_NUMBERED &&
                       options_is_rotation(&n->options->files.keep);
    if (n->kind == FILE_NAMES_IN_FOLDER) {
        n->folder = bag_folder_new(n->name, error);
        return n->folder != NULL ? 0 : -1;
    }
    if (n->kind != FILE_NAMES_ONE && !has_folder_for_each(n) &&
        lum_claim_take(n->name, n->name, &n->claim, error) != 0 &&
        (keeps || errno == EBUSY || errno == EEXIST)) {
        return -1;
    }
    return keeps ? open_retention(n, error) : 0;
}

static int make_next(struct file_names *n, int64_t frame,
                     char out[FILE_NAME_BYTES], lum_error *error)
{
    if (n->kind == FILE_NAMES_OF_FRAMES) {
        return numbered_name(n->name, frame, out, FILE_NAME_BYTES, error);
    }
    n->number++;
    if (n->kind == FILE_NAMES_IN_FOLDER) {
        return bag_folder_next_name(n->folder, out, FILE_NAME_BYTES)
                   ? 0
                   : lum_error_set(error, "%s: the name is too long", n->name);
    }
    return n->retention == NULL ||
                   retention_begin(n->retention, &n->number, error) == 0
               ? numbered_name(n->name, n->number, out, FILE_NAME_BYTES, error)
               : -1;
}

/* The name of the next file, or of that of a frame; it may be made in room. One
 * of the run's inputs is refused. NULL with the reason in error and errno. */
static const char *next_name(struct file_names *names, int64_t frame,
                             char room[FILE_NAME_BYTES], lum_error *error)
{
    if (names->kind == FILE_NAMES_ONE) {
        return names->name;
    }
    return make_next(names, frame, room, error) == 0 &&
                   targets_check_inputs(names->options, room, error) == 0
               ? room
               : NULL;
}

static bool is_there(const struct file_names *n, unsigned number,
                     char name[FILE_NAME_BYTES])
{
    return numbered_name(n->name, number, name, FILE_NAME_BYTES, NULL) == 0 &&
           access(name, F_OK) == 0;
}

bool file_names_find_stale(const struct file_names *n, lum_error *out)
{
    char first[FILE_NAME_BYTES];
    char second[FILE_NAME_BYTES];
    if (n->kind != FILE_NAMES_NUMBERED || n->retention != NULL ||
        !is_there(n, n->number + 1u, first)) {
        return false;
    }
    const bool has_more = is_there(n, n->number + 2u, second);
    (void)lum_error_set(out,
                        "%s%s of an earlier run: this one ended with number "
                        "%u; remove what you do not need",
                        first, has_more ? " and what follows are" : " is",
                        n->number);
    return true;
}

static void give_names_back(struct file_names *names)
{
    const int code = errno;
    retention_close(names->retention);
    lum_claim_drop(&names->claim);
    bag_folder_free(names->folder);
    errno = code;
}

/* --- Files that begin and end --- */

static int finish(struct file_set *set, size_t i, lum_error *error)
{
    const struct closing closing = {.file = set->open[i],
                                    .retention = set->names.retention,
                                    .last_ns = set->series.last_ns};
    if (set->names.folder != NULL &&
        bag_folder_note(set->names.folder, closing.file.number - 1u,
                        closing.file.cloud, error) != 0) {
        return -1;
    }
    set->count--;
    set->open[i] = set->open[set->count];
    return set->closer != NULL ? closer_put(set->closer, &closing, error)
                               : closing_finish(&closing, error);
}

static size_t find_lowest(const struct file_set *set)
{
    size_t lowest = 0;
    for (size_t i = 1; i < set->count; i++) {
        lowest = set->open[i].frame < set->open[lowest].frame ? i : lowest;
    }
    return lowest;
}

static int open_file(struct file_set *set, int64_t frame,
                     struct output_file *out, lum_error *error)
{
    char room[FILE_NAME_BYTES];
    const char *name = next_name(&set->names, frame, room, error);
    if (name == NULL || output_file_open(&set->format, name, out, error) != 0) {
        return -1;
    }
    out->frame = frame;
    out->number = set->names.number;
    return 0;
}

/* --- A file for each frame --- */

static int64_t later(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int open_of_frame(struct file_set *set, int64_t frame, lum_error *error)
{
    if (set->count == FILE_SET_OPEN_MAX) {
        const size_t lowest = find_lowest(set);
        set->ended = later(set->ended, set->open[lowest].frame);
        if (finish(set, lowest, error) != 0) {
            return -1;
        }
    }
    return open_file(set, frame, &set->open[set->count], error);
}

static int get_of_frame(struct file_set *set, int64_t frame,
                        struct output_file **out, lum_error *error)
{
    size_t i = 0;
    *out = NULL;
    while (i < set->count && set->open[i].frame != frame) {
        i++;
    }
    if (i == set->count) {
        if (frame <= set->ended) {
            return 0;
        }
        if (open_of_frame(set, frame, error) != 0) {
            return -1;
        }
        i = set->count++;
    }
    *out = &set->open[i];
    return 0;
}

/* --- One file, or one after another --- */

static int open_present(struct file_set *set, lum_error *error)
{
    const int result = open_file(set, 0, &set->open[0], error);
    set->count = result == 0 ? 1u : 0;
    return result;
}

/* Whether the next file may begin. If not, the present one continues, so that
 * nothing waits for the disk. */
static bool may_rotate(const struct file_set *set)
{
    struct retention *retention = set->names.retention;
    return set->closer == NULL ||
           (closer_has_room(set->closer) &&
            (retention == NULL || retention_is_planned(retention) ||
             !closer_plan(set->closer, retention)));
}

static void note_rotated(struct series *series)
{
    const int64_t ns = series->limit->ns;
    series->state = SERIES_FILLS;
    series->top = NO_FRAME;
    if (ns != 0) {
        const int64_t since_ns = series->now_ns - series->began_ns;
        series->began_ns += since_ns - since_ns % ns;
    }
}

static int rotate(struct file_set *set, lum_error *error)
{
    int result = 0;
    while (result == 0 && set->count > 0) {
        result = finish(set, set->count - 1u, error);
    }
    note_rotated(&set->series);
    return result == 0 ? open_present(set, error) : result;
}

/* Of a cloud, whose eyes do not end a frame at once. */
static int rotate_at_frame(struct file_set *set, lum_error *error)
{
    struct output_file next;
    if (set->count == 2u && finish(set, 1, error) != 0) {
        return -1;
    }
    set->open[0].frame = set->series.top;
    note_rotated(&set->series);
    if (open_file(set, 0, &next, error) != 0) {
        return -1;
    }
    set->open[1] = set->open[0];
    set->open[0] = next;
    set->count = 2;
    return 0;
}

static int get_present(struct file_set *set, int64_t frame,
                       struct output_file **out, lum_error *error)
{
    struct series *series = &set->series;
    if (series->state == SERIES_DUE && series->top != NO_FRAME &&
        frame > series->top && may_rotate(set) &&
        rotate_at_frame(set, error) != 0) {
        return -1;
    }
    if (set->count == 2u && frame <= set->open[1].frame) {
        *out = &set->open[1];
        return 0;
    }
    series->top = later(series->top, frame);
    *out = &set->open[0];
    return 0;
}

static bool is_full(const struct file_set *set)
{
    const struct series *s = &set->series;
    return s->limit->bytes != 0
               ? output_file_bytes(&set->open[0]) >= s->limit->bytes
               : s->now_ns - s->began_ns >= s->limit->ns;
}

int file_set_set_time(struct file_set *set, int64_t time_ns, lum_error *error)
{
    struct series *s = &set->series;
    if (s->limit == NULL) {
        return 0;
    }
    s->now_ns = time_ns;
    /* what ends a capture has no time */
    s->last_ns = time_ns != 0 ? time_ns : s->last_ns;
    if (s->state == SERIES_NO_TIME) {
        s->state = SERIES_FILLS;
        s->began_ns = time_ns;
    }
    if (s->state == SERIES_FILLS && is_full(set)) {
        s->state = SERIES_DUE;
        s->due_ns = time_ns;
        (void)may_rotate(set); /* plan it */
    }
    return s->state == SERIES_DUE && time_ns - s->due_ns > OVERDUE_NS &&
                   may_rotate(set)
               ? rotate(set, error)
               : 0;
}

/* --- From the beginning to the end --- */

void file_set_prepare(const struct options *options, size_t i,
                      struct file_set *out)
{
    *out = (struct file_set){.names = names_of(options, i), .ended = NO_FRAME};
    out->series.top = NO_FRAME;
    out->series.limit =
        options_rotates(options, i) ? &options->files.rotation : NULL;
    out->is_in_place = out->names.kind != FILE_NAMES_OF_FRAMES &&
                       capture_file_is_in_place(out->names.name);
    file_format_choose(options, i, &out->format);
}

int file_set_open(struct file_set *set, const struct file_set *rehearsal,
                  lum_error *error)
{
    set->format.cloud.rehearsal =
        rehearsal != NULL ? rehearsal->open[0].cloud : NULL;
    if (take_names(&set->names, error) != 0) {
        return -1;
    }
    return set->names.kind != FILE_NAMES_OF_FRAMES ? open_present(set, error)
                                                   : 0;
}

int file_set_rehearse(struct file_set *set, lum_error *error)
{
    set->names.kind = FILE_NAMES_ONE;
    set->series.limit = NULL;
    set->count = 1;
    return lum_writer_rehearse(&set->format.cloud, &set->open[0].cloud, error);
}

int file_set_close(struct file_set *set, lum_error *error)
{
    int result = 0;
    while (result == 0 && set->count > 0) {
        result = finish(set, find_lowest(set), error);
    }
    if (result == 0 && set->closer != NULL) {
        result = closer_wait(set->closer, error);
    }
    if (set->names.folder == NULL || (result != 0 && errno != ENOENT)) {
        return result;
    }
    /* it has its metadata though files of it were lost */
    const int finished =
        bag_folder_finish(set->names.folder, result == 0 ? error : NULL);
    errno = result == 0 ? errno : ENOENT;
    return result == 0 ? finished : result;
}

void file_set_abort(struct file_set *set)
{
    if (set->closer != NULL) {
        (void)closer_wait(set->closer, NULL);
    }
    for (size_t i = 0; i < set->count; i++) {
        lum_writer_abort(set->open[i].cloud);
        lum_capture_writer_abort(set->open[i].capture);
    }
    give_names_back(&set->names);
}

/* --- What they are given --- */

int file_set_of_frame(struct file_set *set, int64_t frame,
                      struct output_file **out, lum_error *error)
{
    return set->names.kind == FILE_NAMES_OF_FRAMES
               ? get_of_frame(set, frame, out, error)
               : get_present(set, frame, out, error);
}

int file_set_add_status(struct file_set *set, const lum_writer_status *status,
                        lum_error *error)
{
    return set->names.kind != FILE_NAMES_OF_FRAMES
               ? lum_writer_add_status(set->open[0].cloud, status, error)
               : 0;
}

/* Its name is there, and stays if the power fails: so should be what a reader
 * needs first. Nothing waits for that. */
static int secure_beginning(struct output_file *capture, struct closer *closer,
                            lum_error *error)
{
    capture->is_begun = true;
    if (output_file_flush(capture, error) != 0) {
        return -1;
    }
    closer_sync(closer, lum_capture_writer_copy(capture->capture),
                lum_capture_writer_name(capture->capture));
    return 0;
}

int file_set_add_datagram(struct file_set *set, const lum_record *record,
                          bool begins_frame, lum_error *error)
{
    struct output_file *file = &set->open[0];
    if ((begins_frame && set->series.state == SERIES_DUE && may_rotate(set) &&
         rotate(set, error) != 0) ||
        output_file_add_datagram(file, record, error) != 0) {
        return -1;
    }
    return file->capture == NULL || file->is_begun || set->closer == NULL
               ? 0
               : secure_beginning(file, set->closer, error);
}

int file_set_end_frame(struct file_set *set, int64_t frame, lum_error *error)
{
    /* the present file stays */
    size_t i = set->names.kind == FILE_NAMES_OF_FRAMES ? 0 : 1;
    set->ended = later(set->ended, frame);
    while (i < set->count) {
        if (set->open[i].frame > frame) {
            i++;
        } else if (finish(set, i, error) != 0) {
            return -1;
        }
    }
    return 0;
}

int file_set_flush(struct file_set *set, bool files, lum_error *error)
{
    if (set->closer != NULL && closer_check(set->closer, error) != 0) {
        return -1;
    }
    return set->is_in_place || (set->format.is_growing && files)
               ? output_file_flush(&set->open[0], error)
               : 0;
}

bool file_set_find_lost(struct file_set *set, lum_error *out)
{
    struct retention *retention = set->names.retention;
    for (size_t i = 0; i < set->count; i++) {
        if (output_file_find_lost(&set->open[i], out)) {
            return true;
        }
    }
    return retention != NULL && retention_take_note(retention, out);
}
