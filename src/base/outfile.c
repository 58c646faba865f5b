/* Outputs opened and discarded, on every system: a path comes in; what goes out
 * is an output that bytes can be written to. */
#include "outfile_io.h"
#include "outfile_parts.h"

#include "base/text.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

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
