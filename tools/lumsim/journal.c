#include "journal.h"

#include <errno.h>
#include <string.h>

int journal_open(struct journal *out, const char *path, lum_error *error)
{
    lum_error why = {""};
    *out = (struct journal){0};
    if (path == NULL) {
        return 0;
    }
    if (strcmp(path, "-") == 0) {
        out->out = stdout;
    } else if (journal_file_open(path, &out->file, &out->out, &why) != 0) {
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
        const int reason = journal_file_close(journal->file);
        journal->reason = journal->reason != 0 ? journal->reason : reason;
    }
    journal->out = NULL;
    journal->file = NULL;
    return journal->reason;
}
