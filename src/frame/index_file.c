/* The index beside a capture: found, checked, saved and loaded. */
#include "reader_internal.h"

#include "base/outfile.h"
#include "base/sized.h"
#include "capture/source_internal.h"
#include "framer_state.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of a capture's begin and end that tell it from others. */
#define END_BYTES 65536u

/* More than an index ever has. */
#define FILE_BYTES_MAX (8u * LUM_INDEX_BYTES_MAX)

static const char suffix[] = ".lumindex";

/* --- What it is an index of --- */

static int add_sum(lum_source *s, uint64_t from, size_t len, lum_index_key *key,
                   lum_error *error)
{
    if (lum_source_seek(s, from, error) != 0) {
        return -1;
    }
    if (!lum_source_has(s, len)) {
        return lum_error_set(error, "%s",
                             s->has_failed ? s->error.text
                                           : "it has become shorter");
    }
    key->ends = lum_index_sum(key->ends, s->at, len);
    return 0;
}

static int sum_capture(const char *path, lum_index_key *key, lum_error *error)
{
    lum_source *s = NULL;
    lum_error reason = {"it is empty"};
    int result = -1;
    if (lum_source_open(path, &s, error) != 0) {
        return -1;
    }
    key->bytes = s->functions.total;
    const size_t len = key->bytes < END_BYTES ? (size_t)key->bytes : END_BYTES;
    if (lum_source_can_seek(s) && add_sum(s, 0, len, key, &reason) == 0) {
        result = add_sum(s, key->bytes - len, len, key, &reason);
    }
    lum_source_close(s);
    return result == 0 ? 0
                       : lum_error_set(error, "%s: cannot be read: %s", path,
                                       reason.text);
}

/* The clocks that the reader was given are one of the options. */
static int find_key(lum_reader *r, lum_index_key *key, lum_error *error)
{
    const struct place *p = &r->place;
    lum_pack options = {.written = NULL};
    lum_framer_pack_options(r->framer, &options);
    key->options = lum_index_sum(0, options.written, options.len);
    if (p->clocks.len != 0) {
        key->options =
            lum_index_sum(key->options, p->clocks.written, p->clocks.len);
    }
    const bool has_failed = options.has_failed;
    lum_pack_reset(&options);
    return has_failed ? lum_error_set(error, "out of memory")
                      : sum_capture(r->paths[0], key, error);
}

/* --- Its file --- */

/* To be freed; NULL without memory. */
static char *name_file(const lum_reader *r, const char *path)
{
    const char *name = path != NULL ? path : r->paths[0];
    const size_t len = strlen(name);
    char *full = malloc(len + sizeof suffix);
    if (full != NULL) {
        memcpy(full, name, len + 1u);
        if (path == NULL) {
            memcpy(full + len, suffix, sizeof suffix);
        }
    }
    return full;
}

/* Whether there can be an index. */
static int check(lum_reader *r, lum_error *error)
{
    lum_place_begin(r);
    if (r->paths == NULL || r->path_count != 1u || r->place.start.len == 0) {
        return lum_error_set(error, "only one capture file that is not "
                                    "compressed has an index");
    }
    return r->place.keeps_index
               ? 0
               : lum_error_set(error, "this reader keeps no index; set "
                                      "lum_reader_options.keeps_index");
}

int lum_reader_save_index(lum_reader *reader, const char *path,
                          lum_error *error)
{
    lum_index_key key = {0, 0, 0};
    lum_pack pack = {.written = NULL};
    if (check(reader, error) != 0 || find_key(reader, &key, error) != 0) {
        return -1;
    }
    char *name = name_file(reader, path);
    int result = -1;
    if (name != NULL && lum_index_write(&reader->place.index, &key, &pack)) {
        result = lum_outfile_save(name, pack.written, pack.len, error);
    } else {
        (void)lum_error_set(error, "not enough memory to write an index");
    }
    lum_pack_reset(&pack);
    free(name);
    return result;
}

/* The one that knows more. */
static void use(struct place *p, lum_index *index)
{
    lum_index *worse = index;
    if (index->known >= p->index.known) {
        const lum_index other = p->index;
        p->index = *index;
        *worse = other;
    }
    lum_index_clear(worse);
}

static int load(lum_reader *r, lum_source *s, lum_error *error)
{
    lum_index_key key = {0, 0, 0};
    lum_index index = {.stride = 1};
    const uint64_t size = s->functions.total;
    if (size > FILE_BYTES_MAX) {
        return lum_error_set(error, "it is too long for an index");
    }
    if (!lum_source_has(s, (size_t)size)) {
        return lum_error_set(error, "it cannot be read");
    }
    if (find_key(r, &key, error) != 0 ||
        lum_index_read(&index, &key, s->at, (size_t)size, error) != 0) {
        return -1;
    }
    use(&r->place, &index);
    return 1;
}

/* 1; 0: there is none; -1. */
static int load_file(lum_reader *r, const char *name, lum_error *error)
{
    lum_error reason = {""};
    lum_source *s = NULL;
    int result = -1;
    if (lum_source_open(name, &s, NULL) == 0) {
        result = load(r, s, &reason);
        lum_source_close(s);
    } else if (errno == ENOENT) {
        return 0;
    } else {
        (void)lum_error_set(&reason, "%s", strerror(errno));
    }
    return result > 0
               ? result
               : lum_error_set(error, "%s: is not used: %s", name, reason.text);
}

int lum_reader_load_index(lum_reader *reader, const char *path,
                          lum_error *error)
{
    const struct place *p = &reader->place;
    if (check(reader, error) != 0) {
        return -1;
    }
    if (p->jump.awaited_next < p->jump.awaited_count) {
        return lum_error_set(error, "an index cannot be loaded between a seek "
                                    "and the frame that was sought");
    }
    char *name = name_file(reader, path);
    if (name == NULL) {
        return lum_error_set(error, "not enough memory to read an index");
    }
    const int result = load_file(reader, name, error);
    free(name);
    return result;
}

lum_result lum_reader_get_index(const lum_reader *reader, lum_reader_index *out)
{
    const struct place *p = &reader->place;
    const lum_reader_index state = {.struct_size = sizeof state,
                                    .frames = p->index.frames,
                                    .is_whole = p->index.is_whole,
                                    .is_kept = p->keeps_index,
                                    .entries = p->index.count,
                                    .bytes = p->index.bytes,
                                    .next = p->frames.order};
    return lum_sized_fill(out, &state, sizeof state) ? LUM_OK : LUM_E_VALUE;
}
