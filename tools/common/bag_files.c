#define _POSIX_C_SOURCE 200809L
#include "bag_files.h"

#include <dirent.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Names one after the other, each with its NUL. */
struct names {
    char *at;
    size_t len;
    size_t room;
    size_t count;
    bool has_sqlite;
};

static bool ends_with(const char *name, const char *end)
{
    const size_t n = strlen(name);
    const size_t m = strlen(end);
    return n > m && strcmp(name + n - m, end) == 0;
}

static bool add(struct names *names, const char *name)
{
    const size_t n = strlen(name) + 1u;
    if (names->len + n > names->room) {
        const size_t room = 2u * (names->room + n);
        char *more = realloc(names->at, room);
        if (more == NULL) {
            return false;
        }
        names->at = more;
        names->room = room;
    }
    (void)memcpy(names->at + names->len, name, n);
    names->len += n;
    names->count++;
    return true;
}

static int compare(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* The paths, sorted: a list, and the texts behind it. */
static char **make_list(const char *folder, const struct names *names)
{
    const size_t len = strlen(folder);
    const bool has_end = len > 0 && folder[len - 1u] == '/';
    char **list = malloc(names->count * (sizeof *list + len + 1u) + names->len);
    if (list == NULL) {
        return NULL;
    }
    char *out = (char *)(list + names->count);
    const char *name = names->at;
    for (size_t i = 0; i < names->count; i++) {
        const size_t n = strlen(name) + 1u;
        list[i] = out;
        (void)memcpy(out, folder, len);
        out += len;
        if (!has_end) {
            *out++ = '/';
        }
        (void)memcpy(out, name, n);
        out += n;
        name += n;
    }
    qsort(list, names->count, sizeof *list, compare);
    return list;
}

static bool read_names(DIR *directory, struct names *out)
{
    bool is_fine = true;
    for (struct dirent *e = readdir(directory); e != NULL && is_fine;
         e = readdir(directory)) {
        const bool is_hidden = e->d_name[0] == '.';
        out->has_sqlite = out->has_sqlite || ends_with(e->d_name, ".db3");
        if (!is_hidden && ends_with(e->d_name, ".mcap")) {
            is_fine = add(out, e->d_name);
        }
    }
    return is_fine;
}

static void refuse(const char *folder, const struct names *names,
                   lum_error *error)
{
    (void)lum_error_set(
        error,
        names->has_sqlite
            ? "%s: its recording is SQLite (.db3), which is not read: ros2 bag "
              "convert makes MCAP of it"
            : "%s: is a folder without an .mcap file; a folder of rosbag2 has "
              "one",
        folder);
}

char **bag_files_list(const char *folder, size_t *count, lum_error *error)
{
    struct names names = {0};
    char **list = NULL;
    DIR *directory = opendir(folder);
    if (directory == NULL) {
        (void)lum_error_set(error, "%s: cannot be opened: %s", folder,
                            strerror(errno));
        return NULL;
    }
    const bool is_fine = read_names(directory, &names);
    (void)closedir(directory);
    if (is_fine && names.count == 0) {
        refuse(folder, &names, error);
    } else {
        list = is_fine ? make_list(folder, &names) : NULL;
        if (list == NULL) {
            (void)lum_error_set(error, "out of memory");
        }
    }
    free(names.at);
    *count = names.count;
    return list;
}
