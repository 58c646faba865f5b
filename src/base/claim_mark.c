/* The content of the mark that says who writes a file, and the names of files
 * beside it. */
#include "claim.h"

#include "base/system.h"
#include "lum/base/time.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAGIC      "lumsdk\n"
#define PROCESS    "process "
#define UNFINISHED "unfinished "
#define PART       ".part"

#define HASH_DIGITS 16u
#define UNIQUE      12u /* digits that no other run has */

static uint64_t hash_text(const char *text)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (; *text != '\0'; text++) {
        hash = (hash ^ (unsigned char)*text) * UINT64_C(0x100000001b3);
    }
    return hash;
}

lum_claim_place lum_claim_place_of(const char *path)
{
    const char *base = lum_system_base(path);
    lum_claim_place p = {.directory_len = (size_t)(base - path)};
    if (strlen(base) <= LUM_CLAIM_STEM_BYTES) {
        (void)snprintf(p.stem, sizeof p.stem, "%s", base);
    } else {
        (void)snprintf(p.stem, sizeof p.stem, "%.*s~%016" PRIx64,
                       (int)(LUM_CLAIM_STEM_BYTES - HASH_DIGITS - 1u), base,
                       hash_text(base));
    }
    return p;
}

char *lum_claim_compose(const char *path, const lum_claim_place *place,
                        const char *before, const char *after)
{
    const size_t size = place->directory_len + strlen(before) +
                        strlen(place->stem) + strlen(after) + 1u;
    char *whole = malloc(size);
    if (whole != NULL) {
        (void)snprintf(whole, size, "%.*s%s%s%s", (int)place->directory_len,
                       path, before, place->stem, after);
    }
    return whole;
}

/* Others are kept away by an exclusive creation; this need only be new most of
 * the time. */
static uint64_t make_unique(void)
{
    uint64_t x =
        (uint64_t)lum_time_utc_ns() + ((uint64_t)lum_system_process() << 40);
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

char *lum_claim_beside(const char *path)
{
    char after[UNIQUE + sizeof "." PART];
    const lum_claim_place p = lum_claim_place_of(path);
    (void)snprintf(after, sizeof after, ".%0*" PRIx64 PART, (int)UNIQUE,
                   make_unique() >> (64u - 4u * UNIQUE));
    return lum_claim_compose(path, &p, "", after);
}

bool lum_claim_is_mark(const lum_claim_mark *mark)
{
    return mark->text[0] == '\0' ||
           strncmp(mark->text, MAGIC, strlen(MAGIC)) == 0;
}

size_t lum_claim_write_mark(lum_claim_mark *out, const char *unfinished)
{
    const int n =
        unfinished == NULL
            ? snprintf(out->text, sizeof out->text, MAGIC PROCESS "%ld\n",
                       lum_system_process())
            : snprintf(out->text, sizeof out->text,
                       MAGIC PROCESS "%ld\n" UNFINISHED "%s\n",
                       lum_system_process(), lum_system_base(unfinished));
    return n > 0 && (size_t)n < sizeof out->text ? (size_t)n : 0;
}

/* The rest of the line that begins with a key, in place; NULL: there is none.
 */
static char *line_of(lum_claim_mark *mark, const char *key)
{
    char *at = strstr(mark->text, key);
    if (at == NULL || at == mark->text || at[-1] != '\n') {
        return NULL;
    }
    at += strlen(key);
    char *end = strchr(at, '\n');
    if (end == NULL) {
        return NULL;
    }
    *end = '\0';
    return at;
}

static bool is_unfinished_name(const char *name, const char *stem)
{
    const size_t len = strlen(stem);
    return strncmp(name, stem, len) == 0 && name[len] == '.' &&
           strspn(name + len + 1u, "0123456789abcdef") == UNIQUE &&
           strcmp(name + len + 1u + UNIQUE, PART) == 0;
}

char *lum_claim_unfinished(lum_claim_mark *mark, const char *path)
{
    const lum_claim_place p = lum_claim_place_of(path);
    const char *name = line_of(mark, UNFINISHED);
    return name != NULL && is_unfinished_name(name, p.stem)
               ? lum_claim_compose(path, &p, "", name + strlen(p.stem))
               : NULL;
}

int lum_claim_refuse_busy(lum_claim_mark *mark, const char *shown,
                          lum_error *error)
{
    const char *text = line_of(mark, PROCESS);
    const long process = text != NULL ? strtol(text, NULL, 10) : 0;
    if (process == lum_system_process()) {
        (void)lum_error_set(error,
                            "%s: this run is writing it already: choose "
                            "another name",
                            shown);
    } else if (process > 0) {
        (void)lum_error_set(error,
                            "%s: another run is writing it (process %ld): wait "
                            "for its end, or choose another name",
                            shown, process);
    } else {
        (void)lum_error_set(error,
                            "%s: another run is writing it: wait for its end, "
                            "or choose another name",
                            shown);
    }
    errno = EBUSY;
    return -1;
}

int lum_claim_refuse_foreign(const char *path, const char *shown,
                             lum_error *error)
{
    errno = EEXIST;
    return lum_error_set(
        error,
        "%s: cannot be written while %s exists, because that name marks it as "
        "being written: rename that one, or choose another name",
        shown, path);
}
