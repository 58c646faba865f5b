#define _POSIX_C_SOURCE 200809L
#include "sources.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct source_identity {
    dev_t device;
    ino_t inode;
    mode_t mode;
    const char *path;
};

static bool find(const char *path, int standard, struct source_identity *out)
{
    struct stat s;
    if ((strcmp(path, "-") == 0 ? fstat(standard, &s) : stat(path, &s)) != 0) {
        return false;
    }
    *out = (struct source_identity){
        .device = s.st_dev, .inode = s.st_ino, .mode = s.st_mode, .path = path};
    return true;
}

static int compare(const void *a, const void *b)
{
    const struct source_identity *p = a;
    const struct source_identity *q = b;
    if (p->device != q->device) {
        return p->device < q->device ? -1 : 1;
    }
    if (p->inode != q->inode) {
        return p->inode < q->inode ? -1 : 1;
    }
    return 0;
}

static void name_them(struct sources *s)
{
    const int more = s->count > 1 ? (int)(s->count - 1u) : 0;
    if (more == 0) {
        (void)snprintf(s->name, sizeof s->name, "%s", s->paths[0]);
        return;
    }
    (void)snprintf(s->name, sizeof s->name, "%.*s and %d more",
                   (int)sizeof s->name - 32, s->paths[0], more);
}

static int check_twice(const struct sources *s, lum_error *error)
{
    for (size_t i = 1; i < s->identity_count; i++) {
        const struct source_identity *one = &s->identities[i - 1u];
        const struct source_identity *other = &s->identities[i];
        if (compare(one, other) == 0) {
            return lum_error_set(error,
                                 "%s and %s are one file: name each source "
                                 "once",
                                 one->path, other->path);
        }
    }
    return 0;
}

int sources_init(struct sources *out, const char *const *paths, size_t count,
                 lum_error *error)
{
    *out = (struct sources){.paths = paths, .count = count};
    name_them(out);
    out->identities = calloc(count, sizeof *out->identities);
    if (out->identities == NULL) {
        return lum_error_set(error, "out of memory");
    }
    for (size_t i = 0; i < count; i++) {
        out->identity_count +=
            find(paths[i], STDIN_FILENO, &out->identities[out->identity_count])
                ? 1u
                : 0u;
    }
    qsort(out->identities, out->identity_count, sizeof *out->identities,
          compare);
    return check_twice(out, error);
}

void sources_free(struct sources *sources)
{
    free(sources->identities);
    sources->identities = NULL;
}

bool sources_have(const struct sources *sources, const char *output)
{
    struct source_identity o;
    return sources->identity_count > 0 && find(output, STDOUT_FILENO, &o) &&
           S_ISREG(o.mode) &&
           bsearch(&o, sources->identities, sources->identity_count,
                   sizeof *sources->identities, compare) != NULL;
}

bool sources_are_files(const struct sources *sources)
{
    for (size_t i = 0; i < sources->count; i++) {
        struct stat s;
        if (strcmp(sources->paths[i], "-") == 0 ||
            stat(sources->paths[i], &s) != 0 || !S_ISREG(s.st_mode)) {
            return false;
        }
    }
    return sources->count > 0;
}
