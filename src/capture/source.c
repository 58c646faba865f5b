/* Bytes of a file, of memory or of a caller's function, through a window. */
#include "source_internal.h"

#include "base/sized.h"
#include "base/text.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Fits in second-level caches, so that the bytes read are still there when they
 * are used. */
#define HALF_BYTES ((size_t)256 * 1024)

/* The kernel copies to a page's start several times as fast as to 16 bytes
 * behind it, where malloc() begins. */
#define ALIGN ((size_t)4096)

static lum_source *new_source(const char *name)
{
    lum_source *s = calloc(1, sizeof *s);
    char *copy = lum_text_copy(name);
    if (s == NULL || copy == NULL) {
        free(s);
        free(copy);
        return NULL;
    }
    s->name = copy;
    return s;
}

static bool fail(lum_source *s)
{
    s->has_ended = true;
    s->has_failed = true;
    return false;
}

/* Bytes that are left over go to the end of the first half, so that new bytes
 * begin at the start of a page. */
static void move_left_over(lum_source *s, uint8_t *buffer, size_t half)
{
    uint8_t *to = buffer + half - s->left;
    if (s->left != 0) {
        memmove(to, s->at, s->left);
    }
    s->at = to;
}

static bool make_room(lum_source *s, size_t bytes)
{
    size_t half = s->half != 0 ? s->half : HALF_BYTES;
    while (half < bytes) {
        half *= 2u;
    }
    if (half == s->half) {
        move_left_over(s, s->buffer, half);
        return true;
    }
    uint8_t *memory = malloc(2u * half + ALIGN);
    if (memory == NULL) {
        (void)lum_error_set(&s->error, "not enough memory to read %zu bytes",
                            bytes);
        return fail(s);
    }
    uint8_t *buffer = memory + (ALIGN - (uintptr_t)memory % ALIGN) % ALIGN;
    move_left_over(s, buffer, half);
    free(s->memory);
    s->memory = memory;
    s->buffer = buffer;
    s->half = half;
    return true;
}

lum_source *lum_source_from_memory(const char *name, const void *bytes,
                                   size_t len)
{
    lum_source *s = new_source(name);
    if (s != NULL) {
        s->at = bytes;
        s->left = len;
        s->end = len;
        s->functions.total = len;
        s->has_ended = true;
    }
    return s;
}

lum_source *lum_source_from_functions(const char *name,
                                      const lum_source_functions *functions,
                                      lum_error *error)
{
    lum_source_functions known;
    if (lum_sized_take(&known, sizeof known, functions,
                       "the source's functions", "lum_source_functions",
                       error) != 0) {
        return NULL;
    }
    if (known.read == NULL) {
        errno = EINVAL;
        (void)lum_error_set(error, "a source needs a function that reads");
        return NULL;
    }
    lum_source *s = new_source(name);
    if (s == NULL || !make_room(s, HALF_BYTES)) {
        lum_source_close(s);
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    s->functions = known;
    return s;
}

/* Whoever is asked is asked during a wait too. */
static bool may_read(lum_source *s)
{
    bool is_ready = s->go_on == NULL;
    while (!is_ready && lum_go_on_ask(s->go_on)) {
        is_ready =
            s->wait == NULL || s->wait(s->functions.context, LUM_GO_ON_WAIT_MS);
    }
    return is_ready;
}

static void read_more(lum_source *s)
{
    if (!may_read(s)) {
        (void)lum_go_on_fail(&s->error);
        (void)fail(s);
        return;
    }
    uint8_t *to = s->buffer + (s->at - s->buffer) + s->left;
    const size_t room = (size_t)(s->buffer + 2u * s->half - to);
    const int64_t got =
        s->functions.read(s->functions.context, to, room, &s->error);
    if (got < 0 || (uint64_t)got > room) {
        if (got >= 0) {
            (void)lum_error_set(&s->error, "its function gave more bytes than "
                                           "there is room for");
        }
        (void)fail(s);
    } else if (got == 0) {
        s->has_ended = true;
    } else {
        s->left += (size_t)got;
        s->end += (uint64_t)got;
    }
}

bool lum_source_fill(lum_source *source, size_t bytes)
{
    if (source->has_ended || bytes > LUM_SOURCE_WINDOW_MAX ||
        !make_room(source, bytes)) {
        return source->left >= bytes;
    }
    while (source->left < bytes && !source->has_ended) {
        read_more(source);
    }
    return source->left >= bytes;
}

bool lum_source_skip(lum_source *source, uint64_t bytes)
{
    while (bytes > source->left) {
        bytes -= source->left;
        lum_source_take(source, source->left);
        if (!lum_source_fill(source, 1)) {
            return false;
        }
    }
    lum_source_take(source, (size_t)bytes);
    return true;
}

bool lum_source_can_seek(const lum_source *source)
{
    return source->packed == NULL &&
           (source->functions.read == NULL || source->functions.seek != NULL);
}

static int seek_memory(lum_source *s, uint64_t offset, lum_error *error)
{
    if (offset > s->end) {
        return lum_error_set(error, "it has only %llu bytes",
                             (unsigned long long)s->end);
    }
    s->at = s->at - lum_source_offset(s) + offset;
    s->left = (size_t)(s->end - offset);
    return 0;
}

int lum_source_seek(lum_source *source, uint64_t offset, lum_error *error)
{
    lum_source *s = source;
    if (s->functions.read == NULL) {
        return seek_memory(s, offset, error);
    }
    if (s->functions.seek(s->functions.context, offset, error) != 0) {
        return -1;
    }
    s->at = s->buffer + s->half;
    s->left = 0;
    s->end = offset;
    s->has_ended = false;
    s->has_failed = false;
    return 0;
}

void lum_source_progress(const lum_source *source, uint64_t *done,
                         uint64_t *total)
{
    const lum_source *s = source->packed != NULL ? source->packed : source;
    *done = lum_source_offset(s);
    *total = s->functions.total;
}

void lum_source_close(lum_source *source)
{
    if (source == NULL) {
        return;
    }
    if (source->functions.close != NULL) {
        source->functions.close(source->functions.context);
    }
    lum_source_close(source->packed);
    free(source->memory);
    free(source->name);
    free(source);
}
