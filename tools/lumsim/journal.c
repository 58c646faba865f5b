#include "journal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#if defined(_WIN32)
#include <share.h>
#else
#include "base/outfile_io.h"
#endif

/* --- The file --- */

#if defined(_WIN32)
struct journal_file {
    FILE *stream;
};

/* The system keeps other writers away. */
static int open_file(const char *path, struct journal_file **out, FILE **stream,
                     lum_error *error)
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

static int close_file(struct journal_file *file)
{
    const int reason = fclose(file->stream) == 0 ? 0 : errno;
    free(file);
    return reason;
}
#else
struct journal_file {
    lum_outfile out;
    FILE *stream; /* of a second descriptor */
};

static int close_file(struct journal_file *file)
{
    const bool is_whole = file->stream != NULL && fclose(file->stream) == 0 &&
                          lum_outfile_finish(&file->out, NULL) == 0;
    const int reason = is_whole ? 0 : errno;
    lum_outfile_discard(&file->out);
    free(file);
    return reason;
}

static int open_file(const char *path, struct journal_file **out, FILE **stream,
                     lum_error *error)
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
    (void)close_file(file);
    return -1;
}
#endif

/* --- Its lines --- */

int journal_open(struct journal *out, const char *path, lum_error *error)
{
    lum_error why = {""};
    *out = (struct journal){0};
    if (path == NULL) {
        return 0;
    }
    if (strcmp(path, "-") == 0) {
        out->out = stdout;
    } else if (open_file(path, &out->file, &out->out, &why) != 0) {
        return lum_error_set(error, "--log: %s", why.text);
    }
    return 0;
}

struct json *journal_begin(struct journal *journal, int64_t t_ns,
                           const char *event)
{
    json_begin_line(&journal->json, journal->out);
    json_real(&journal->json, "t", (double)t_ns / 1e9, 6);
    json_text(&journal->json, "event", event);
    return &journal->json;
}

void journal_end(struct journal *journal)
{
    json_end_line(&journal->json);
    if (journal->out != NULL &&
        (fflush(journal->out) != 0 || ferror(journal->out))) {
        journal->reason = errno != 0 ? errno : EIO;
        journal->out = NULL;
    }
}

int journal_close(struct journal *journal)
{
    if (journal->file != NULL) {
        const int reason = close_file(journal->file);
        journal->reason = journal->reason != 0 ? journal->reason : reason;
    }
    journal->out = NULL;
    journal->file = NULL;
    return journal->reason;
}
