#include "journal_file.h"

#include <errno.h>
#include <share.h>
#include <stdlib.h>
#include <string.h>

struct journal_file {
    FILE *stream;
};

/* The system keeps other writers away. */
int journal_file_open(const char *path, struct journal_file **out,
                      FILE **stream, lum_error *error)
{
    struct journal_file *file = calloc(1, sizeof *file);
    if (file == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    file->stream = _fsopen(path, "w", _SH_DENYWR);
    if (file->stream == NULL) {
        (void)lum_error_set(error, "%s: cannot be written: %s", path,
                            strerror(errno));
        free(file);
        return -1;
    }
    *stream = file->stream;
    *out = file;
    return 0;
}

int journal_file_close(struct journal_file *file)
{
    const int reason = fclose(file->stream) == 0 ? 0 : errno;
    free(file);
    return reason;
}
