#include "bag_folder.h"

#include "../common/make_folder.h"
#include "base/outfile.h"
#include "base/system.h"
#include "cloud/buffer.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAME_BYTES 4096u
#define BASE_BYTES 256u
#define FILE_BYTES (BASE_BYTES + 32u)

struct bag_folder {
    const char *path;
    char base[BASE_BYTES]; /* its last part, which its files are named after */
    size_t begun;
    lum_mcap_info *files; /* of those that were noted */
    size_t count;
    size_t room;
};

/* --- The folder --- */

/* "a/drive/" is the same folder as "a/drive". */
static bool find_base(const char *path, char *out, size_t size)
{
    char trimmed[NAME_BYTES];
    size_t len = strlen(path);
    while (len > 1 && path[len - 1u] == '/') {
        len--;
    }
    if (len >= sizeof trimmed) {
        return false;
    }
    (void)memcpy(trimmed, path, len);
    trimmed[len] = '\0';
    const int n = snprintf(out, size, "%s", lum_system_base(trimmed));
    return n > 0 && (size_t)n < size && strcmp(out, ".") != 0 &&
           strcmp(out, "..") != 0;
}

static int make(const char *path, lum_error *error)
{
    if (make_folder(path) == 0) {
        return 0;
    }
    return lum_error_set(
        error,
        errno == EEXIST
            ? "%s: is there already; rosbag2 makes a new folder: name "
              "another one, or remove it"
            : "%s: cannot make the folder: %s",
        path, strerror(errno));
}

struct bag_folder *bag_folder_new(const char *path, lum_error *error)
{
    struct bag_folder *f = calloc(1, sizeof *f);
    if (f == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    f->path = path;
    if (!find_base(path, f->base, sizeof f->base)) {
        (void)lum_error_set(error, "%s: is not the name of a new folder", path);
        free(f);
        return NULL;
    }
    if (make(path, error) != 0) {
        free(f);
        return NULL;
    }
    return f;
}

static bool name_in(const struct bag_folder *f, const char *name, char *out,
                    size_t size)
{
    const size_t len = strlen(f->path);
    const bool has_end = len > 0 && f->path[len - 1u] == '/';
    const int n =
        snprintf(out, size, "%s%s%s", f->path, has_end ? "" : "/", name);
    return n >= 0 && (size_t)n < size;
}

static void name_of_file(const struct bag_folder *f, size_t i,
                         char out[FILE_BYTES])
{
    (void)snprintf(out, FILE_BYTES, "%s_%zu.mcap", f->base, i);
}

bool bag_folder_next_name(struct bag_folder *folder, char *out, size_t size)
{
    char name[FILE_BYTES];
    name_of_file(folder, folder->begun++, name);
    return name_in(folder, name, out, size);
}

static int make_room(struct bag_folder *f, size_t n, lum_error *error)
{
    if (n <= f->room) {
        return 0;
    }
    const size_t room = n > 2u * f->room ? n : 2u * f->room;
    lum_mcap_info *more = realloc(f->files, room * sizeof *f->files);
    if (more == NULL) {
        return lum_error_set(error, "out of memory");
    }
    f->files = more;
    f->room = room;
    return 0;
}

int bag_folder_note(struct bag_folder *folder, size_t number,
                    const lum_writer *file, lum_error *error)
{
    static const lum_mcap_info nothing = {.struct_size = sizeof nothing};
    if (make_room(folder, number + 1u, error) != 0) {
        return -1;
    }
    while (folder->count <= number) {
        folder->files[folder->count++] = nothing;
    }
    return lum_writer_mcap_info(file, &folder->files[number]) == 0
               ? 0
               : lum_error_set(error, "%s: is not of MCAP files", folder->path);
}

/* --- metadata.yaml --- */

LUM_PRINTF(2, 3)
static void add(lum_bytes *t, const char *format, ...)
{
    va_list arguments;
    char one[1024];
    va_start(arguments, format);
    const int n = vsnprintf(one, sizeof one, format, arguments);
    va_end(arguments);
    if (n < 0 || (size_t)n >= sizeof one) {
        t->failed = true;
        return;
    }
    lum_bytes_put(t, one, (size_t)n);
}

/* In double quotes: readers compare what is in them with the channel's. */
static void add_quoted(lum_bytes *t, const char *value)
{
    add(t, "\"");
    for (const char *p = value; *p != '\0'; p++) {
        if (*p == '\n') {
            add(t, "\\n");
        } else if (*p == '"' || *p == '\\') {
            add(t, "\\%c", *p);
        } else if ((unsigned char)*p < ' ') {
            add(t, "\\x%02x", (unsigned)*p);
        } else {
            add(t, "%c", *p);
        }
    }
    add(t, "\"");
}

static void add_times(lum_bytes *t, const char *margin, int64_t begin_ns,
                      int64_t end_ns, uint64_t messages)
{
    add(t,
        "%sduration:\n%s  nanoseconds: %" PRId64 "\n"
        "%sstarting_time:\n%s  nanoseconds_since_epoch: %" PRId64 "\n"
        "%smessage_count: %" PRIu64 "\n",
        margin, margin, end_ns - begin_ns, margin, margin, begin_ns, margin,
        messages);
}

/* What all files have together. */
static lum_mcap_info sum(const struct bag_folder *folder)
{
    lum_mcap_info all = {.struct_size = sizeof all};
    for (size_t i = 0; i < folder->count; i++) {
        const lum_mcap_info *one = &folder->files[i];
        if (one->messages > 0) {
            const bool is_first = all.messages == 0;
            all.begin_ns = is_first || one->begin_ns < all.begin_ns
                               ? one->begin_ns
                               : all.begin_ns;
            all.end_ns =
                is_first || one->end_ns > all.end_ns ? one->end_ns : all.end_ns;
        }
        all.messages += one->messages;
        all.topic_count = one->topic_count;
        for (size_t k = 0; k < one->topic_count; k++) {
            const uint64_t before = all.topics[k].messages;
            all.topics[k] = one->topics[k];
            all.topics[k].messages += before;
        }
    }
    return all;
}

static void add_topics(lum_bytes *t, const lum_mcap_info *all)
{
    add(t, "  topics_with_message_count:\n");
    for (size_t i = 0; i < all->topic_count; i++) {
        const lum_mcap_topic *topic = &all->topics[i];
        add(t,
            "    - topic_metadata:\n"
            "        name: %s\n"
            "        type: %s\n"
            "        serialization_format: cdr\n"
            "        offered_qos_profiles: ",
            topic->name, topic->type);
        add_quoted(t, topic->qos);
        add(t, "\n      message_count: %" PRIu64 "\n", topic->messages);
    }
}

static void add_name(lum_bytes *t, const struct bag_folder *folder, size_t i)
{
    char name[FILE_BYTES];
    name_of_file(folder, i, name);
    add_quoted(t, name);
    add(t, "\n");
}

static void add_paths(lum_bytes *t, const struct bag_folder *folder)
{
    add(t, "  compression_format: \"\"\n"
           "  compression_mode: \"\"\n"
           "  relative_file_paths:\n");
    for (size_t i = 0; i < folder->count; i++) {
        add(t, "    - ");
        add_name(t, folder, i);
    }
}

static void add_files(lum_bytes *t, const struct bag_folder *folder)
{
    add(t, "  files:\n");
    for (size_t i = 0; i < folder->count; i++) {
        const lum_mcap_info *info = &folder->files[i];
        add(t, "    - path: ");
        add_name(t, folder, i);
        add_times(t, "      ", info->begin_ns, info->end_ns, info->messages);
    }
}

int bag_folder_finish(const struct bag_folder *folder, lum_error *error)
{
    char name[NAME_BYTES];
    lum_bytes t = {0};
    const lum_mcap_info all = sum(folder);
    add(&t, "rosbag2_bagfile_information:\n"
            "  version: 5\n"
            "  storage_identifier: mcap\n");
    add_times(&t, "  ", all.begin_ns, all.end_ns, all.messages);
    add_topics(&t, &all);
    add_paths(&t, folder);
    add_files(&t, folder);
    int result = -1;
    if (t.failed || !name_in(folder, "metadata.yaml", name, sizeof name)) {
        (void)lum_error_set(error, "%s: no memory for metadata.yaml",
                            folder->path);
    } else {
        result = lum_outfile_save(name, t.at, t.len, error);
    }
    lum_bytes_free(&t);
    return result;
}

/* One that holds files stays. */
void bag_folder_free(struct bag_folder *folder)
{
    if (folder != NULL) {
        remove_folder(folder->path);
        free(folder->files);
        free(folder);
    }
}
