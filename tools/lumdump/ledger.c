#include "ledger.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD "lumdump keep 1\n"
#define TAIL "end\n"

/* Bytes of the longest line: a number, a size, a time. */
#define LINE_BYTES 64u

/* --- Files --- */

bool ledger_add(struct ledger *ledger, const struct ledger_file *file)
{
    if (file->number <= ledger_top(ledger) ||
        file->number > LEDGER_NUMBER_MAX) {
        return false;
    }
    if (ledger->count == ledger->room) {
        const size_t room = 2u * ledger->room + 16u;
        struct ledger_file *more =
            realloc(ledger->files, room * sizeof ledger->files[0]);
        if (more == NULL) {
            return false;
        }
        ledger->files = more;
        ledger->room = room;
    }
    ledger->files[ledger->count++] = *file;
    return true;
}

struct ledger_file *ledger_find(const struct ledger *ledger, unsigned number)
{
    for (size_t i = ledger->count; i > 0; i--) {
        if (ledger->files[i - 1u].number == number) {
            return &ledger->files[i - 1u];
        }
    }
    return NULL;
}

void ledger_forget(struct ledger *ledger, unsigned number)
{
    struct ledger_file *file = ledger_find(ledger, number);
    if (file != NULL) {
        const size_t i = (size_t)(file - ledger->files);
        ledger->count--;
        memmove(file, file + 1, (ledger->count - i) * sizeof *file);
    }
}

unsigned ledger_top(const struct ledger *ledger)
{
    return ledger->count > 0 ? ledger->files[ledger->count - 1u].number : 0;
}

void ledger_free(struct ledger *ledger)
{
    free(ledger->files);
    *ledger = (struct ledger){0};
}

/* --- Text --- */

struct reader {
    const char *at;
    const char *end;
};

static bool take_word(struct reader *r, const char *word)
{
    const size_t n = strlen(word);
    if ((size_t)(r->end - r->at) < n || memcmp(r->at, word, n) != 0) {
        return false;
    }
    r->at += n;
    return true;
}

/* Digits, without leading zeros. */
static bool take_number(struct reader *r, uint64_t max, uint64_t *out)
{
    const char *begin = r->at;
    uint64_t value = 0;
    while (r->at < r->end && *r->at >= '0' && *r->at <= '9') {
        const uint64_t digit = (uint64_t)(*r->at - '0');
        if (value > (max - digit) / 10u) {
            return false;
        }
        value = 10u * value + digit;
        r->at++;
    }
    *out = value;
    return r->at > begin && (*begin != '0' || r->at == begin + 1);
}

static bool take_file(struct reader *r, struct ledger_file *out)
{
    uint64_t number = 0;
    uint64_t last_ns = 0;
    *out = (struct ledger_file){0};
    if (!take_number(r, LEDGER_NUMBER_MAX, &number) || number == 0 ||
        !take_word(r, " ")) {
        return false;
    }
    out->number = (unsigned)number;
    if (take_word(r, "begun\n")) {
        return true;
    }
    out->is_whole = take_number(r, UINT64_MAX, &out->bytes) &&
                    take_word(r, " ") && take_number(r, INT64_MAX, &last_ns) &&
                    take_word(r, "\n");
    out->last_ns = (int64_t)last_ns;
    return out->is_whole;
}

static enum ledger_text read_files(struct ledger *ledger, struct reader *r)
{
    while (!take_word(r, TAIL)) {
        struct ledger_file file;
        if (!take_file(r, &file) || file.number <= ledger_top(ledger)) {
            return LEDGER_DAMAGED;
        }
        if (!ledger_add(ledger, &file)) {
            return LEDGER_NO_MEMORY;
        }
    }
    return r->at == r->end ? LEDGER_WHOLE : LEDGER_DAMAGED;
}

enum ledger_text ledger_read(struct ledger *ledger, const char *text,
                             size_t len)
{
    struct reader r = {text, text + len};
    if (take_word(&r, HEAD)) {
        return read_files(ledger, &r);
    }
    return len < strlen(HEAD) && memcmp(text, HEAD, len) == 0 ? LEDGER_DAMAGED
                                                              : LEDGER_FOREIGN;
}

char *ledger_write(const struct ledger *ledger, size_t *len)
{
    const size_t room = sizeof HEAD + sizeof TAIL + ledger->count * LINE_BYTES;
    char *text = malloc(room);
    if (text == NULL) {
        return NULL;
    }
    size_t n = (size_t)snprintf(text, room, HEAD);
    for (size_t i = 0; i < ledger->count; i++) {
        const struct ledger_file *f = &ledger->files[i];
        n += (size_t)(f->is_whole ? snprintf(text + n, room - n,
                                             "%u %" PRIu64 " %" PRId64 "\n",
                                             f->number, f->bytes, f->last_ns)
                                  : snprintf(text + n, room - n, "%u begun\n",
                                             f->number));
    }
    n += (size_t)snprintf(text + n, room - n, TAIL);
    *len = n;
    return text;
}
