/* Outputs opened and discarded, on every system: a path comes in; what goes out
 * is an output that bytes can be written to. Also what failed, and all of some
 * bytes. */
#include "outfile_io.h"
#include "outfile_parts.h"

#include "base/text.h"

#include <errno.h>
#include <stdlib.h>
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

int lum_outfile_open(const char *path, lum_outfile_kind kind, lum_outfile *out,
                     lum_error *error)
{
    lum_outfile file = {.fd = -1, .claim = LUM_CLAIM_NONE};
    file.name =
        lum_text_copy(strcmp(path, "-") == 0 ? "standard output" : path);
    if (file.name == NULL) {
        return lum_outfile_refuse(ENOMEM, path, "no memory to open it", error);
    }
    if (lum_outfile_system_open(&file, kind, path, error) != 0) {
        lum_outfile_discard(&file);
        return -1;
    }
    lum_outfile_system_learn(&file);
    *out = file;
    return 0;
}

void lum_outfile_discard(lum_outfile *file)
{
    const int code = errno;
    lum_outfile_part_drop(file);
    lum_claim_drop(&file->claim);
    free(file->name);
    free(file->path);
    errno = code;
}

int lum_outfile_begin(const char *path, const void *bytes, size_t n,
                      lum_outfile *out, lum_error *error)
{
    if (lum_outfile_open(path, LUM_OUTFILE_WHOLE, out, error) != 0) {
        return -1;
    }
    const int result = lum_outfile_put_all(out, bytes, n, error);
    if (result != 0) {
        lum_outfile_discard(out);
    }
    return result;
}

int lum_outfile_save(const char *path, const void *bytes, size_t n,
                     lum_error *error)
{
    lum_outfile file;
    if (lum_outfile_begin(path, bytes, n, &file, error) != 0) {
        return -1;
    }
    const int result = lum_outfile_finish(&file, error);
    lum_outfile_discard(&file);
    return result;
}
