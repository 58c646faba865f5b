#include "capture_file.h"

#include "file_look.h"

#include <string.h>

bool capture_file_is_in_place(const char *path)
{
    struct file_look look;
    return strcmp(path, "-") == 0 ||
           (file_look(path, &look) && look.kind != FILE_REGULAR);
}

static int open_as(const char *path, const struct provenance *about,
                   bool is_whole, struct capture_file *out, lum_error *error)
{
    lum_capture_writer_options o = {.struct_size = sizeof o,
                                    .is_whole = is_whole};
    if (about != NULL) {
        o.format = LUM_CAPTURE_PCAPNG;
        o.application = about->program;
        o.comments = about->comments;
        o.comment_count = about->comment_count;
    }
    *out = (struct capture_file){0};
    return lum_capture_writer_open_as(path, &o, &out->writer, error);
}

int capture_file_open(const char *path, const struct provenance *about,
                      struct capture_file *out, lum_error *error)
{
    return open_as(path, about, true, out, error);
}

/* A disk that cannot be written to is told at once. */
int capture_file_record(const char *path, const struct provenance *about,
                        struct capture_file *out, lum_error *error)
{
    if (open_as(path, about, false, out, error) != 0) {
        return -1;
    }
    if (capture_file_flush(out, error) != 0) {
        capture_file_abort(out);
        return -1;
    }
    return 0;
}

int capture_file_add(struct capture_file *file, const lum_datagram *datagram,
                     lum_error *error)
{
    return lum_capture_writer_add(file->writer, datagram, error);
}

int capture_file_flush(struct capture_file *file, lum_error *error)
{
    return lum_capture_writer_flush(file->writer, error);
}

uint64_t capture_file_bytes(const struct capture_file *file)
{
    return lum_capture_writer_bytes(file->writer);
}

int capture_file_close(struct capture_file *file, lum_error *error)
{
    lum_capture_writer *writer = file->writer;
    file->writer = NULL;
    return lum_capture_writer_close(writer, error);
}

void capture_file_abort(struct capture_file *file)
{
    lum_capture_writer_abort(file->writer);
    file->writer = NULL;
}
