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
                   bool is_whole, lum_capture_writer **out, lum_error *error)
{
    lum_capture_writer_options o = {.struct_size = sizeof o,
                                    .is_whole = is_whole};
    if (about != NULL) {
        o.format = LUM_CAPTURE_PCAPNG;
        o.application = about->program;
        o.comments = about->comments;
        o.comment_count = about->comment_count;
    }
    *out = NULL;
    return lum_capture_writer_open_as(path, &o, out, error);
}

int capture_file_open(const char *path, const struct provenance *about,
                      lum_capture_writer **out, lum_error *error)
{
    return open_as(path, about, true, out, error);
}

/* A disk that cannot be written to is reported at once. */
int capture_file_record(const char *path, const struct provenance *about,
                        lum_capture_writer **out, lum_error *error)
{
    if (open_as(path, about, false, out, error) != 0) {
        return -1;
    }
    if (lum_capture_writer_flush(*out, error) != 0) {
        lum_capture_writer_abort(*out);
        *out = NULL;
        return -1;
    }
    return 0;
}
