#define _POSIX_C_SOURCE 200809L
#include "journal.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

int journal_open(struct journal *out, const char *path, lum_error *error)
{
    *out = (struct journal){0};
    if (path == NULL) {
        return 0;
    }
    out->out = strcmp(path, "-") == 0 ? stdout : fopen(path, "w");
    if (out->out == NULL) {
        return lum_error_set(error, "--log: %s cannot be written: %s", path,
                             strerror(errno));
    }
    json_init(&out->json, out->out);
    return 0;
}

struct json *journal_begin(struct journal *journal, int64_t t_ns,
                           const char *event)
{
    if (journal->out == NULL || journal->reason != 0) {
        return NULL;
    }
    json_open_object(&journal->json, NULL);
    json_real(&journal->json, "t", (double)t_ns / 1e9, 6);
    json_text(&journal->json, "event", event);
    return &journal->json;
}

void journal_end(struct journal *journal)
{
    json_close_object(&journal->json);
    json_end(&journal->json);
    if (fflush(journal->out) != 0 || ferror(journal->out)) {
        journal->reason = errno != 0 ? errno : EIO;
    }
}

int journal_close(struct journal *journal)
{
    if (journal->out != NULL && journal->out != stdout &&
        fclose(journal->out) != 0 && journal->reason == 0) {
        journal->reason = errno;
    }
    journal->out = NULL;
    return journal->reason;
}
