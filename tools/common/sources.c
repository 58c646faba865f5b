#define _POSIX_C_SOURCE 200809L
#include "sources.h"

#include "file_look.h"
#include "source_url.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct source_identity {
    struct file_look look;
    const char *path;
};

static int order(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

static int compare(const void *a, const void *b)
{
    const struct file_look *p = &((const struct source_identity *)a)->look;
    const struct file_look *q = &((const struct source_identity *)b)->look;
    const int volumes = order(p->volume, q->volume);
    return volumes != 0 ? volumes : order(p->number, q->number);
}

static bool find(const char *path, struct source_identity *out)
{
    out->path = path;
    return file_look_input(path, &out->look) &&
           (out->look.volume | out->look.number) != 0;
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

/* --- Folders --- */

static bool is_folder(const char *path)
{
    struct file_look look;
    return strcmp(path, "-") != 0 && file_look(path, &look) &&
           look.kind == FILE_DIRECTORY;
}

/* A file in a folder; "": one by its whole name. */
static int append(struct sources *s, const char *folder, const char *name,
                  lum_error *error)
{
    const size_t len = strlen(folder);
    const size_t size = len + strlen(name) + 2u;
    const char *divider = len == 0 || folder[len - 1u] == '/' ? "" : "/";
    char **more = realloc(s->expanded, (s->count + 1u) * sizeof *more);
    char *path = malloc(size);
    s->expanded = more != NULL ? more : s->expanded;
    if (more == NULL || path == NULL) {
        free(path);
        return lum_error_set(error, "out of memory");
    }
    (void)snprintf(path, size, "%s%s%s", folder, divider, name);
    more[s->count++] = path;
    s->paths = (const char *const *)more;
    return 0;
}

static bool ends_with(const char *name, const char *end)
{
    const size_t n = strlen(name);
    const size_t m = strlen(end);
    return n > m && strcmp(name + n - m, end) == 0;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static int add_files(struct sources *s, const char *folder, DIR *directory,
                     bool *has_sqlite, lum_error *error)
{
    int result = 0;
    for (const struct dirent *e = readdir(directory); e != NULL && result == 0;
         e = readdir(directory)) {
        *has_sqlite = *has_sqlite || ends_with(e->d_name, ".db3");
        if (e->d_name[0] != '.' && ends_with(e->d_name, ".mcap")) {
            result = append(s, folder, e->d_name, error);
        }
    }
    return result;
}

static void note_folder(struct sources *s, const char *folder, bool is_open,
                        bool has_sqlite)
{
    if (s->folder_error.text[0] != '\0') {
        return;
    }
    if (!is_open) {
        (void)lum_error_set(&s->folder_error, "%s: cannot be opened: %s",
                            folder, strerror(errno));
        return;
    }
    (void)lum_error_set(
        &s->folder_error,
        has_sqlite
            ? "%s: its recording is SQLite (.db3), which is not read: ros2 bag "
              "convert makes MCAP of it"
            : "%s: is a folder without an .mcap file; a folder of rosbag2 has "
              "one",
        folder);
}

/* The files in it, in the order of their names, which does not matter where
 * captures are read by their times. metadata.yaml is not read, because a
 * recording that was killed has none. */
static int add_folder(struct sources *s, const char *folder, lum_error *error)
{
    const size_t from = s->count;
    bool has_sqlite = false;
    DIR *directory = opendir(folder);
    if (directory != NULL) {
        const int result = add_files(s, folder, directory, &has_sqlite, error);
        (void)closedir(directory);
        if (result != 0) {
            return -1;
        }
    }
    if (s->count == from) {
        note_folder(s, folder, directory != NULL, has_sqlite);
        return append(s, "", folder, error);
    }
    qsort(s->expanded + from, s->count - from, sizeof *s->expanded,
          compare_names);
    return 0;
}

/* Each folder as the files in it. */
static int expand(struct sources *s, lum_error *error)
{
    const char *const *given = s->paths;
    const size_t count = s->count;
    size_t i = 0;
    int result = 0;
    while (i < count && !is_folder(given[i])) {
        i++;
    }
    if (i == count) {
        return 0;
    }
    s->count = 0;
    for (i = 0; i < count && result == 0; i++) {
        result = is_folder(given[i]) ? add_folder(s, given[i], error)
                                     : append(s, "", given[i], error);
    }
    return result;
}

/* --- Checks --- */

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

static int check_names(const struct sources *s, lum_error *error)
{
    for (size_t i = 0; i < s->count; i++) {
        if (s->count > 1 && source_url_is_sensor(s->paths[i])) {
            return lum_error_set(error,
                                 "%s: a sensor is the only source of its run; "
                                 "several sources are captures",
                                 s->paths[i]);
        }
        if (!source_url_is_none(s->paths[i], error)) {
            return -1;
        }
    }
    return 0;
}

int sources_init(struct sources *out, const char *const *paths, size_t count,
                 lum_error *error)
{
    *out = (struct sources){.paths = paths, .count = count};
    name_them(out);
    if (check_names(out, error) != 0 || expand(out, error) != 0) {
        return -1;
    }
    /* A folder stands for one file at least. */
    const size_t room = out->count > count ? out->count : count;
    out->identities = calloc(room, sizeof *out->identities);
    if (out->identities == NULL) {
        return lum_error_set(error, "out of memory");
    }
    for (size_t i = 0; i < out->count; i++) {
        out->identity_count +=
            find(out->paths[i], &out->identities[out->identity_count]) ? 1u
                                                                       : 0u;
    }
    qsort(out->identities, out->identity_count, sizeof *out->identities,
          compare);
    return check_twice(out, error);
}

int sources_check_folders(const struct sources *sources, lum_error *error)
{
    return sources->folder_error.text[0] == '\0'
               ? 0
               : lum_error_set(error, "%s", sources->folder_error.text);
}

void sources_free(struct sources *sources)
{
    for (size_t i = 0; sources->expanded != NULL && i < sources->count; i++) {
        free(sources->expanded[i]);
    }
    free(sources->expanded);
    free(sources->identities);
    sources->expanded = NULL;
    sources->identities = NULL;
}

/* Whether a name stands for one of them. Only for regular files: other files
 * cannot be overwritten. */
static bool have(const struct sources *sources, const char *output)
{
    struct source_identity o = {.path = output};
    return sources->identity_count > 0 && file_look(output, &o.look) &&
           o.look.kind == FILE_REGULAR &&
           bsearch(&o, sources->identities, sources->identity_count,
                   sizeof *sources->identities, compare) != NULL;
}

int sources_check(const struct sources *sources,
                  const struct input_file *inputs, size_t count,
                  const char *output, lum_error *error)
{
    if (!have(sources, output)) {
        return input_files_check(inputs, count, output, error);
    }
    return strcmp(output, "-") == 0
               ? lum_error_set(error,
                               "standard output is the source itself, which "
                               "this run reads: redirect it elsewhere")
               : lum_error_set(error,
                               "%s is the source itself, which this run reads: "
                               "name another output",
                               output);
}

const char *sources_find_stdin(const struct sources *sources)
{
    for (size_t i = 0; i < sources->count; i++) {
        if (input_files_is_stdin(sources->paths[i])) {
            return sources->paths[i];
        }
    }
    return NULL;
}

bool sources_is_file(const char *path)
{
    struct file_look look;
    return strcmp(path, "-") != 0 && file_look(path, &look) &&
           look.kind == FILE_REGULAR;
}

bool sources_are_files(const struct sources *sources)
{
    for (size_t i = 0; i < sources->count; i++) {
        if (!sources_is_file(sources->paths[i])) {
            return false;
        }
    }
    return sources->count > 0;
}
