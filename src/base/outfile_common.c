/* What an output does alike on every system: it says what failed, and writes
 * all of some bytes. */
#include "outfile_io.h"
#include "outfile_parts.h"

#include <errno.h>
#include <string.h>

/* Between two looks whether a slow reader takes more. */
#define PATIENCE_MS 100

int lum_outfile_refuse(int code, const char *name, const char *why,
                       lum_error *error)
{
    errno = code;
    return lum_error_set(error, "%s: %s", name, why);
}

int lum_outfile_refuse_directory(const lum_outfile *file, lum_error *error)
{
    return lum_outfile_refuse(
        ENOENT, file->name,
        "cannot create it: the directory does not exist; create it or write "
        "elsewhere",
        error);
}

int lum_outfile_fail(const lum_outfile *file, int code, const char *doing,
                     lum_error *error)
{
    (void)lum_error_set(
        error, "%s: %s: %s%s", file->name, doing, strerror(code),
        code == ENOSPC ? "; free some space or write elsewhere" : "");
    errno = code;
    return -1;
}

int lum_outfile_put_all(lum_outfile *file, const void *bytes, size_t n,
                        lum_error *error)
{
    const char *from = bytes;
    while (n > 0) {
        size_t written = 0;
        const int code = lum_outfile_put(file, from, n, &written);
        if (code != 0) {
            return lum_outfile_fail(file, code, "cannot be written", error);
        }
        lum_outfile_wrote(file, written);
        from += written;
        n -= written;
        if (n > 0 && written == 0) {
            (void)lum_outfile_wait(file, PATIENCE_MS);
        }
    }
    return 0;
}
