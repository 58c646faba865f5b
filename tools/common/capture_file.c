#include "capture_file.h"

#include "file_look.h"

#include <string.h>

bool capture_file_is_in_place(const char *path)
{
    struct file_look look;
    return strcmp(path, "-") == 0 ||
           (file_look(path, &look) && look.kind != FILE_REGULAR);
}

bool capture_file_is_pcapng(const char *path)
{
    const size_t n = strlen(path);
    return n > 7 && strcmp(path + n - 7, ".pcapng") == 0;
}

static lum_capture_writer_options options_of(const struct provenance *about)
{
    lum_capture_writer_options o = {.struct_size = sizeof o};
    if (about != NULL) {
        o.format = LUM_CAPTURE_PCAPNG;
        o.application = about->program;
        o.comments = about->comments;
        o.comment_count = about->comment_count;
    }
    return o;
}

int capture_file_open(const char *path, const struct provenance *about,
                      lum_capture_writer **out, lum_error *error)
{
    return capture_file_open_from(path, about, NULL, 0, out, error);
}

int capture_file_open_from(const char *path, const struct provenance *about,
                           const char *const *interfaces, size_t count,
                           lum_capture_writer **out, lum_error *error)
{
    lum_capture_writer_options o = options_of(about);
    o.is_whole = true;
    o.interfaces = interfaces;
    o.interface_count = count;
    *out = NULL;
    return lum_capture_writer_open_as(path, &o, out, error);
}

/* A disk that cannot be written to is reported at once. */
int capture_file_record(const char *path, const struct provenance *about,
                        lum_capture_writer **out, lum_error *error)
{
    const lum_capture_writer_options o = options_of(about);
    *out = NULL;
    if (lum_capture_writer_open_as(path, &o, out, error) != 0) {
        return -1;
    }
    if (lum_capture_writer_flush(*out, error) != 0) {
        lum_capture_writer_abort(*out);
        *out = NULL;
        return -1;
    }
    return 0;
}
