#include "text_file.h"

#include "base/outfile.h"
#include "base/outfile_io.h"

#include <errno.h>

static int write_all(lum_outfile *file, const char *text, size_t len,
                     lum_error *error)
{
    size_t done = 0;
    while (done < len) {
        size_t written = 0;
        const int failed =
            lum_outfile_put(file, text + done, len - done, &written);
        if (failed != 0) {
            return lum_outfile_fail(file, failed, "cannot be written", error);
        }
        done += written;
    }
    return 0;
}

static void discard(lum_outfile *file)
{
    const int reason = errno;
    lum_outfile_discard(file);
    errno = reason;
}

int text_file_begin(const char *path, const char *text, size_t len,
                    lum_outfile *file, lum_error *error)
{
    if (lum_outfile_open(path, LUM_OUTFILE_WHOLE, file, error) != 0) {
        return -1;
    }
    const int result = write_all(file, text, len, error);
    if (result != 0) {
        discard(file);
    }
    return result;
}

int text_file_save(const char *path, const char *text, size_t len,
                   lum_error *error)
{
    lum_outfile file;
    if (text_file_begin(path, text, len, &file, error) != 0) {
        return -1;
    }
    const int result = lum_outfile_finish(&file, error);
    discard(&file);
    return result;
}
