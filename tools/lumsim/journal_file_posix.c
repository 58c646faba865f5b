#include "journal_file.h"

#include "base/outfile_io.h"

#include <errno.h>
#include <stdlib.h>

struct journal_file {
    lum_outfile out;
    FILE *stream; /* of a second descriptor */
};

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
    file->stream = lum_outfile_stream(&file->out);
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
