#define _POSIX_C_SOURCE 200809L
#include "journal_file.h"

#include "base/outfile.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

struct journal_file {
    lum_outfile out;
    FILE *stream; /* of a second descriptor */
};

static FILE *open_stream(int fd)
{
    const int second = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    FILE *stream = second >= 0 ? fdopen(second, "w") : NULL;
    if (stream == NULL && second >= 0) {
        (void)close(second);
    }
    return stream;
}

int journal_file_open(const char *path, struct journal_file **out,
                      FILE **stream, lum_error *error)
{
    struct journal_file *file = calloc(1, sizeof *file);
    if (file == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    if (lum_outfile_open(path, LUM_OUTFILE_GROWS, &file->out, error) != 0) {
        free(file);
        return -1;
    }
    file->stream = open_stream(file->out.fd);
    if (file->stream == NULL) {
        (void)lum_outfile_fail(&file->out, errno, "cannot be written", error);
    } else if (lum_outfile_show(&file->out, error) == 0) {
        *stream = file->stream;
        *out = file;
        return 0;
    }
    (void)journal_file_close(file);
    return -1;
}

int journal_file_close(struct journal_file *file)
{
    const bool is_whole = file->stream != NULL && fclose(file->stream) == 0 &&
                          lum_outfile_finish(&file->out, NULL) == 0;
    const int reason = is_whole ? 0 : errno;
    lum_outfile_discard(&file->out);
    free(file);
    return reason;
}
