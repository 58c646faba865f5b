#define _POSIX_C_SOURCE 200809L
#include "retention.h"

#include "../common/file_look.h"
#include "base/claim.h"
#include "base/outfile.h"
#include "base/text.h"
#include "ledger.h"
#include "numbered.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define NAME_BYTES 4096u

/* More is no list of ours: it would be of a million files. */
#define TEXT_BYTES_MAX ((size_t)64 << 20)

enum note {
    NOTE_STUCK,
    NOTE_CHANGED,
    NOTE_DAMAGED
};

struct retention {
    char *name;   /* of the output */
    char *ledger; /* the path of the list */
    struct rotation limit;
    pthread_mutex_t disk; /* held while the disk is waited for; guards these */
    struct ledger list;
    unsigned top;         /* the highest that the list has had */
    pthread_mutex_t lock; /* never held while anything is waited for, but taken
                             under the other one; guards what follows */
    unsigned planned;     /* listed, and not begun; 0: none */
    uint64_t removed;
    uint64_t stuck;
    bool is_told[RETENTION_NOTES];
    lum_error notes[RETENTION_NOTES];
    size_t note_count;
};

/* --- Small things --- */

static const char *name_of(const struct retention *r, unsigned number,
                           char out[NAME_BYTES])
{
    if (numbered_name(r->name, number, out, NAME_BYTES, NULL) != 0) {
        out[0] = '\0';
    }
    return out;
}

static bool is_there(const struct retention *r, unsigned number)
{
    char name[NAME_BYTES];
    struct file_look look;
    return file_look_itself(name_of(r, number, name), &look);
}

static int fail(const char *name, const char *doing, int code, lum_error *error)
{
    (void)lum_error_set(error, "%s: %s: %s", name, doing, strerror(code));
    errno = code;
    return -1;
}

/* Each kind is told once. what, why: about the file of this name. */
static void say_once(struct retention *r, enum note kind, const char *name,
                     const char *what, const char *why)
{
    (void)pthread_mutex_lock(&r->lock);
    if (!r->is_told[kind]) {
        r->is_told[kind] = true;
        (void)lum_error_set(&r->notes[r->note_count++], "%s: %s%s", name, what,
                            why);
    }
    (void)pthread_mutex_unlock(&r->lock);
}

static void count_files(struct retention *r, unsigned removed, uint64_t stuck)
{
    (void)pthread_mutex_lock(&r->lock);
    r->removed += removed;
    r->stuck = stuck;
    (void)pthread_mutex_unlock(&r->lock);
}

static unsigned planned_of(struct retention *r)
{
    (void)pthread_mutex_lock(&r->lock);
    const unsigned planned = r->planned;
    (void)pthread_mutex_unlock(&r->lock);
    return planned;
}

/* Nothing happens if another number is planned by now. */
static bool replace_planned(struct retention *r, unsigned from, unsigned to)
{
    (void)pthread_mutex_lock(&r->lock);
    const bool is_same = r->planned == from;
    r->planned = is_same ? to : r->planned;
    (void)pthread_mutex_unlock(&r->lock);
    return is_same;
}

/* --- The list on the disk --- */

/* A missing file means the folder of the output is gone. For the caller ENOENT
 * would mean that only the file it finished is. */
static int save(const struct retention *r, lum_error *error)
{
    size_t len = 0;
    char *text = ledger_write(&r->list, &len);
    if (text == NULL) {
        return fail(r->name, "cannot list its files", ENOMEM, error);
    }
    const int result = lum_outfile_save(r->ledger, text, len, error);
    const int code = errno == ENOENT ? EIO : errno;
    free(text);
    errno = code;
    return result;
}

static int refuse_foreign(const struct retention *r, lum_error *error)
{
    (void)lum_error_set(error,
                        "%s: --keep would list its files in %s, which is "
                        "another file: rename that one, or choose another name",
                        r->name, r->ledger);
    errno = EEXIST;
    return -1;
}

static int read_text(struct retention *r, FILE *file, size_t room,
                     lum_error *error)
{
    char *text = malloc(room);
    errno = ENOMEM;
    const size_t len = text != NULL ? fread(text, 1, room, file) : 0;
    if (text == NULL || ferror(file) != 0) {
        const int code = errno;
        free(text);
        return fail(r->ledger, "cannot be read", code, error);
    }
    const enum ledger_text result = ledger_read(&r->list, text, len);
    free(text);
    switch (result) {
    case LEDGER_FOREIGN:
        return refuse_foreign(r, error);
    case LEDGER_NO_MEMORY:
        return fail(r->ledger, "cannot be read", ENOMEM, error);
    case LEDGER_DAMAGED:
        say_once(r, NOTE_DAMAGED, r->ledger, "is damaged",
                 ": --keep has lost track of some files and leaves them; "
                 "remove those that you do not need");
        return 0;
    case LEDGER_WHOLE:
    default:
        return 0;
    }
}

static int load(struct retention *r, lum_error *error)
{
    struct file_look look;
    if (!file_look_itself(r->ledger, &look)) {
        return 0;
    }
    if (look.kind != FILE_REGULAR || look.bytes > TEXT_BYTES_MAX) {
        return refuse_foreign(r, error);
    }
    FILE *file = fopen(r->ledger, "rb");
    if (file == NULL) {
        return fail(r->ledger, "cannot be read", errno, error);
    }
    const int result = read_text(r, file, (size_t)look.bytes + 1u, error);
    const int code = errno;
    (void)fclose(file);
    errno = code;
    return result;
}

/* --- What earlier runs have left --- */

/* Whether the file of this name has not got its name: it is still the
 * unfinished one that its mark names. */
static bool has_unfinished(const char *name)
{
    lum_claim_mark mark = {""};
    const lum_claim_place place = lum_claim_place_of(name);
    char *path = lum_claim_compose(name, &place, ".", ".lumsdk");
    FILE *file = path != NULL ? fopen(path, "rb") : NULL;
    free(path);
    if (file == NULL) {
        return false;
    }
    mark.text[fread(mark.text, 1, sizeof mark.text - 1u, file)] = '\0';
    (void)fclose(file);
    struct file_look look;
    char *part =
        lum_claim_is_mark(&mark) ? lum_claim_unfinished(&mark, name) : NULL;
    const bool is_there = part != NULL && file_look_itself(part, &look);
    free(part);
    return is_there;
}

/* A file that a killed run had begun. If it has its name, it is ours; if not,
 * it is removed, as by every run that takes the name, and what has the name now
 * is another's. */
static bool adopt(const struct retention *r, struct ledger_file *file)
{
    char name[NAME_BYTES];
    struct file_look look;
    lum_claim claim;
    (void)name_of(r, file->number, name);
    const bool is_unfinished = has_unfinished(name);
    const int result = lum_claim_take(name, name, &claim, NULL);
    const bool is_busy = result != 0 && errno == EBUSY;
    if (result == 0) {
        lum_claim_drop(&claim);
    }
    if (is_unfinished || is_busy || !file_look_itself(name, &look) ||
        look.kind != FILE_REGULAR) {
        return false;
    }
    file->is_whole = true;
    file->bytes = look.bytes;
    file->last_ns =
        look.modified_s > 0 ? (look.modified_s + 1) * INT64_C(1000000000) : 0;
    return true;
}

static void adopt_all(struct retention *r)
{
    size_t n = 0;
    for (size_t i = 0; i < r->list.count; i++) {
        struct ledger_file file = r->list.files[i];
        if (file.is_whole || adopt(r, &file)) {
            r->list.files[n++] = file;
        }
    }
    r->list.count = n;
}

/* --- What is over the limit --- */

/* What the list has. Of bytes there has to be room for one more as large as the
 * largest: the one that is being written. */
struct tally {
    unsigned newest;   /* the number of the newest whole file; 0: none */
    int64_t newest_ns; /* its time */
    uint64_t bytes;
    uint64_t largest;
};

/* A size that a list gives may be anything. */
static uint64_t add(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

static struct tally tally_of(const struct ledger *list)
{
    struct tally t = {0};
    for (size_t i = 0; i < list->count; i++) {
        const struct ledger_file *f = &list->files[i];
        if (f->is_whole) {
            t.newest = f->number;
            t.newest_ns = f->last_ns;
            t.bytes = add(t.bytes, f->bytes);
            t.largest = f->bytes > t.largest ? f->bytes : t.largest;
        }
    }
    return t;
}

static bool is_over(const struct retention *r, const struct tally *t,
                    const struct ledger_file *file)
{
    if (!file->is_whole || file->number == t->newest) {
        return false;
    }
    return r->limit.bytes != 0 ? add(t->bytes, t->largest) > r->limit.bytes
                               : t->newest_ns - file->last_ns > r->limit.ns;
}

enum removal {
    REMOVED,
    FORGOTTEN, /* others have removed or changed it */
    STUCK
};

static enum removal remove_file(struct retention *r,
                                const struct ledger_file *file)
{
    char name[NAME_BYTES];
    struct file_look look;
    (void)name_of(r, file->number, name);
    if (!file_look_itself(name, &look)) {
        return FORGOTTEN;
    }
    if (look.kind != FILE_REGULAR || look.bytes != file->bytes) {
        say_once(r, NOTE_CHANGED, name, "others have changed it",
                 ": --keep leaves it, and no longer counts it");
        return FORGOTTEN;
    }
    if (unlink(name) == 0) {
        return REMOVED;
    }
    say_once(r, NOTE_STUCK, name,
             "--keep cannot remove it, and tries again at each new file: ",
             strerror(errno));
    return STUCK;
}

/* The newest whole file stays whatever its size. */
static void remove_old(struct retention *r)
{
    struct tally t = tally_of(&r->list);
    unsigned count[] = {[REMOVED] = 0, [FORGOTTEN] = 0, [STUCK] = 0};
    size_t i = 0;
    while (i < r->list.count) {
        const struct ledger_file file = r->list.files[i];
        if (!is_over(r, &t, &file)) {
            i++;
            continue;
        }
        const enum removal result = remove_file(r, &file);
        count[result]++;
        if (result == STUCK) {
            i++;
            continue;
        }
        ledger_forget(&r->list, file.number);
        t.bytes -= file.bytes;
        if (file.bytes == t.largest) {
            t = tally_of(&r->list);
        }
    }
    count_files(r, count[REMOVED], count[STUCK]);
}

/* --- Numbers --- */

/* The disk is held. What others have put under a planned name is theirs; what
 * is there because its number was begun meanwhile is not. */
static void drop_taken(struct retention *r)
{
    const unsigned planned = planned_of(r);
    if (planned != 0 && is_there(r, planned) &&
        replace_planned(r, planned, 0)) {
        ledger_forget(&r->list, planned);
    }
}

/* The disk is held. Names that exist are stepped over, one after another: many
 * only without a list. */
static int plan(struct retention *r, lum_error *error)
{
    struct ledger_file next = {.number = r->top};
    drop_taken(r);
    if (planned_of(r) != 0) {
        return 0;
    }
    do {
        next.number++;
    } while (next.number <= LEDGER_NUMBER_MAX && is_there(r, next.number));
    if (next.number > LEDGER_NUMBER_MAX) {
        return fail(r->name, "its numbers are used up: choose another name",
                    ERANGE, error);
    }
    if (!ledger_add(&r->list, &next)) {
        return fail(r->name, "cannot list its files", ENOMEM, error);
    }
    r->top = next.number;
    if (save(r, error) != 0) {
        ledger_forget(&r->list, next.number);
        return -1;
    }
    (void)replace_planned(r, 0, next.number);
    return 0;
}

int retention_plan(struct retention *r, lum_error *error)
{
    (void)pthread_mutex_lock(&r->disk);
    const int result = plan(r, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&r->disk);
    errno = code;
    return result;
}

bool retention_is_planned(struct retention *r)
{
    const unsigned planned = planned_of(r);
    return planned != 0 && !is_there(r, planned);
}

/* One thread begins files: what it finds planned is taken by nobody else. */
int retention_begin(struct retention *r, unsigned *number, lum_error *error)
{
    *number = planned_of(r);
    while (*number == 0 || is_there(r, *number) ||
           !replace_planned(r, *number, 0)) {
        if (retention_plan(r, error) != 0) {
            return -1;
        }
        *number = planned_of(r);
    }
    return 0;
}

/* --- From the beginning to the end --- */

static struct retention *new_retention(const char *name,
                                       const struct rotation *limit)
{
    struct retention *r = calloc(1, sizeof *r);
    if (r == NULL) {
        return NULL;
    }
    const lum_claim_place place = lum_claim_place_of(name);
    r->limit = *limit;
    r->name = lum_text_copy(name);
    r->ledger = lum_claim_compose(name, &place, ".", ".kept.lumsdk");
    if (r->name == NULL || r->ledger == NULL) {
        free(r->name);
        free(r->ledger);
        free(r);
        return NULL;
    }
    (void)pthread_mutex_init(&r->disk, NULL);
    (void)pthread_mutex_init(&r->lock, NULL);
    return r;
}

static void free_retention(struct retention *r)
{
    ledger_free(&r->list);
    (void)pthread_mutex_destroy(&r->disk);
    (void)pthread_mutex_destroy(&r->lock);
    free(r->name);
    free(r->ledger);
    free(r);
}

/* Old files go first, so that a full disk has room for the list. */
static int begin(struct retention *r, lum_error *error)
{
    char longest[NAME_BYTES];
    if (numbered_name(r->name, LEDGER_NUMBER_MAX, longest, sizeof longest,
                      error) != 0 ||
        load(r, error) != 0) {
        return -1;
    }
    r->top = ledger_top(&r->list);
    adopt_all(r);
    remove_old(r);
    return plan(r, error);
}

int retention_open(const char *name, const struct rotation *limit,
                   struct retention **out, lum_error *error)
{
    struct retention *r = new_retention(name, limit);
    if (r == NULL) {
        return fail(name, "cannot list its files", ENOMEM, error);
    }
    if (begin(r, error) != 0) {
        const int code = errno;
        free_retention(r);
        errno = code;
        return -1;
    }
    *out = r;
    return 0;
}

/* The disk is held. */
static int finish(struct retention *r, unsigned number, int64_t last_ns,
                  lum_error *error)
{
    char name[NAME_BYTES];
    struct file_look look;
    struct ledger_file *file = ledger_find(&r->list, number);
    if (file != NULL && file_look_itself(name_of(r, number, name), &look) &&
        look.kind == FILE_REGULAR) {
        file->is_whole = true;
        file->bytes = look.bytes;
        file->last_ns = last_ns > 0 ? last_ns : 0;
    } else {
        ledger_forget(&r->list, number);
    }
    remove_old(r);
    return save(r, error);
}

int retention_finish(struct retention *r, unsigned number, int64_t last_ns,
                     lum_error *error)
{
    (void)pthread_mutex_lock(&r->disk);
    const int result = finish(r, number, last_ns, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&r->disk);
    errno = code;
    return result;
}

bool retention_take_note(struct retention *r, lum_error *out)
{
    (void)pthread_mutex_lock(&r->lock);
    const bool is_taken = r->note_count > 0;
    if (is_taken) {
        *out = r->notes[0];
        r->note_count--;
        memmove(r->notes, r->notes + 1, r->note_count * sizeof r->notes[0]);
    }
    (void)pthread_mutex_unlock(&r->lock);
    return is_taken;
}

void retention_count(struct retention *r, struct retention_counts *out)
{
    (void)pthread_mutex_lock(&r->lock);
    *out = (struct retention_counts){
        .is_used = true, .removed = r->removed, .stuck = r->stuck};
    (void)pthread_mutex_unlock(&r->lock);
}

/* A number without a file could otherwise be given to a file of others. */
static void forget_unused(struct retention *r)
{
    const size_t before = r->list.count;
    size_t n = 0;
    for (size_t i = 0; i < before; i++) {
        const struct ledger_file file = r->list.files[i];
        if (file.is_whole ||
            (file.number != r->planned && is_there(r, file.number))) {
            r->list.files[n++] = file;
        }
    }
    r->list.count = n;
    if (n != before) {
        (void)!save(r, NULL);
    }
}

void retention_close(struct retention *r)
{
    if (r != NULL) {
        forget_unused(r);
        free_retention(r);
    }
}
