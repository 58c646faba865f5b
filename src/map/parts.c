#define _GNU_SOURCE       /* O_TMPFILE */
#define _FILE_OFFSET_BITS 64

#include "parts.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

#if defined(_WIN32)

#include <io.h>
#include <process.h>
#include <stdio.h>

#define TRIES      100
#define ENDING     40u        /* bytes that a name gets behind it */
#define BYTES_ONCE (1u << 28) /* that a call takes */
#define CLOSE      _close

int lum_map_spool_open(lum_map_spool *spool, const char *beside)
{
    const size_t room = strlen(beside) + ENDING;
    char *name = malloc(room);
    int code = name == NULL ? ENOMEM : EEXIST;
    spool->size = 0;
    for (int i = 0; i < TRIES && code == EEXIST; i++) {
        (void)snprintf(name, room, "%s.spool.%d-%d", beside, _getpid(), i);
        spool->fd = _open(name,
                          _O_RDWR | _O_CREAT | _O_EXCL | _O_BINARY |
                              _O_TEMPORARY | _O_NOINHERIT,
                          _S_IREAD | _S_IWRITE);
        code = spool->fd < 0 ? errno : 0;
    }
    free(name);
    return code;
}

static unsigned at_once(size_t n)
{
    return n < BYTES_ONCE ? (unsigned)n : BYTES_ONCE;
}

static int64_t put_some(int fd, uint64_t at, const void *bytes, size_t n)
{
    return _lseeki64(fd, (int64_t)at, SEEK_SET) < 0
               ? -1
               : _write(fd, bytes, at_once(n));
}

static int64_t get_some(int fd, uint64_t at, void *bytes, size_t n)
{
    return _lseeki64(fd, (int64_t)at, SEEK_SET) < 0
               ? -1
               : _read(fd, bytes, at_once(n));
}

#else

#include <unistd.h>

#define CLOSE close

/* Without a name from the start, where the file system can do that.
 * name: room for a folder; of its own are the first n bytes. */
static int open_nameless(char *name, size_t n)
{
#if defined(O_TMPFILE)
    while (n > 0 && name[n - 1u] != '/') {
        n--;
    }
    name[n] = '.'; /* the folder itself */
    name[n + 1u] = '\0';
    return open(name, O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
#else
    (void)name;
    (void)n;
    return -1;
#endif
}

int lum_map_spool_open(lum_map_spool *spool, const char *beside)
{
    static const char ending[] = ".spool.XXXXXX";
    const size_t n = strlen(beside);
    char *name = malloc(n + sizeof ending);
    if (name == NULL) {
        return ENOMEM;
    }
    memcpy(name, beside, n);
    spool->size = 0;
    spool->fd = open_nameless(name, n);
    int code = 0;
    if (spool->fd < 0) {
        memcpy(name, beside, n);
        memcpy(name + n, ending, sizeof ending);
        spool->fd = mkstemp(name);
        code = spool->fd < 0 || unlink(name) != 0 ? errno : 0;
    }
    free(name);
    return code;
}

static int64_t put_some(int fd, uint64_t at, const void *bytes, size_t n)
{
    return pwrite(fd, bytes, n, (off_t)at);
}

static int64_t get_some(int fd, uint64_t at, void *bytes, size_t n)
{
    return pread(fd, bytes, n, (off_t)at);
}

#endif

/* --- The file on every system --- */

static int spool_write(lum_map_spool *spool, const void *bytes, size_t n)
{
    const char *p = bytes;
    while (n > 0) {
        const int64_t done = put_some(spool->fd, spool->size, p, n);
        if (done == 0 || (done < 0 && errno != EINTR)) {
            return done == 0 ? ENOSPC : errno;
        }
        if (done > 0) {
            p += done;
            n -= (size_t)done;
            spool->size += (uint64_t)done;
        }
    }
    return 0;
}

static int spool_read(const lum_map_spool *spool, uint64_t from, void *bytes,
                      size_t n)
{
    char *p = bytes;
    while (n > 0) {
        const int64_t done = get_some(spool->fd, from, p, n);
        if (done == 0 || (done < 0 && errno != EINTR)) {
            return done == 0 ? EIO : errno;
        }
        if (done > 0) {
            p += done;
            n -= (size_t)done;
            from += (uint64_t)done;
        }
    }
    return 0;
}

void lum_map_spool_close(lum_map_spool *spool)
{
    const int code = errno;
    if (spool->fd >= 0) {
        (void)CLOSE(spool->fd);
    }
    spool->fd = -1;
    errno = code;
}

/* --- Reading --- */

#define READ_ENTRIES  2048u /* of a part at a time */
#define WRITE_ENTRIES 4096u /* of parts that become one */

/* What stands behind the voxels of a part. */
typedef struct part_tail {
    uint64_t before; /* that of the tile's part before */
    uint64_t count;  /* voxels */
} part_tail;

static int refill(lum_map_part *part, const lum_map_spool *spool)
{
    const size_t n =
        part->left < READ_ENTRIES ? (size_t)part->left : READ_ENTRIES;
    if (n == 0) {
        part->next = NULL;
        return 0;
    }
    const int code =
        spool_read(spool, part->from, part->buffer, n * sizeof *part->buffer);
    part->from += n * sizeof *part->buffer;
    part->left -= n;
    part->next = part->buffer;
    part->end = part->buffer + n;
    return code;
}

static int begin_parts(lum_map_merge *merge, const lum_map_tile *tile,
                       const lum_map_spool *spool)
{
    part_tail tail = {tile->part, 0};
    int code = 0;
    for (uint32_t i = 0; i < tile->parts && code == 0; i++) {
        lum_map_part *part = &merge->parts[merge->count++];
        const uint64_t end = tail.before;
        part->buffer = merge->buffers + (size_t)i * READ_ENTRIES;
        code = spool_read(spool, end, &tail, sizeof tail);
        if (code == 0) {
            part->left = tail.count;
            part->from = end - tail.count * sizeof *part->buffer;
            code = refill(part, spool);
        }
    }
    return code;
}

int lum_map_merge_begin(lum_map_merge *merge, const lum_map_tile *tile,
                        const lum_map_spool *spool)
{
    *merge = (lum_map_merge){.count = 0};
    if (tile->table.used > 0) {
        merge->parts[merge->count++] = (lum_map_part){
            .next = tile->table.at, .end = tile->table.at + tile->table.used};
    }
    if (tile->parts == 0) {
        return 0;
    }
    merge->buffers =
        malloc((size_t)tile->parts * READ_ENTRIES * sizeof *merge->buffers);
    return merge->buffers == NULL ? ENOMEM : begin_parts(merge, tile, spool);
}

/* The part with the lowest key, or NULL. */
static lum_map_part *lowest(lum_map_merge *merge)
{
    lum_map_part *found = NULL;
    for (unsigned i = 0; i < merge->count; i++) {
        lum_map_part *part = &merge->parts[i];
        if (part->next != NULL &&
            (found == NULL || part->next->key < found->next->key)) {
            found = part;
        }
    }
    return found;
}

static int step(lum_map_part *part, const lum_map_spool *spool)
{
    part->next++;
    return part->next < part->end ? 0 : refill(part, spool);
}

int lum_map_merge_next(lum_map_merge *merge, const lum_map_spool *spool,
                       lum_map_entry *out, size_t room, size_t *count)
{
    lum_map_part *part = lowest(merge);
    size_t n = 0;
    int code = 0;
    while (part != NULL && n < room && code == 0) {
        lum_map_entry *entry = &out[n++];
        *entry = *part->next;
        code = step(part, spool);
        for (part = lowest(merge);
             part != NULL && code == 0 && part->next->key == entry->key;
             part = lowest(merge)) {
            lum_map_join(entry, part->next);
            code = step(part, spool);
        }
    }
    *count = n;
    return code;
}

void lum_map_merge_end(lum_map_merge *merge)
{
    free(merge->buffers);
    *merge = (lum_map_merge){.count = 0};
}

/* --- Writing --- */

static int write_tail(lum_map_tile *tile, lum_map_spool *spool,
                      const part_tail *tail)
{
    const uint64_t place = spool->size;
    const int code = spool_write(spool, tail, sizeof *tail);
    if (code == 0) {
        tile->part = place;
    }
    return code;
}

static int write_merged(lum_map_merge *merge, lum_map_spool *spool,
                        uint64_t *written)
{
    size_t count = WRITE_ENTRIES;
    lum_map_entry *entries = malloc(WRITE_ENTRIES * sizeof *entries);
    int code = entries == NULL ? ENOMEM : 0;
    while (count == WRITE_ENTRIES && code == 0) {
        code = lum_map_merge_next(merge, spool, entries, WRITE_ENTRIES, &count);
        if (code == 0) {
            code = spool_write(spool, entries, count * sizeof *entries);
            *written += count;
        }
    }
    free(entries);
    return code;
}

/* The places of the parts that were before are lost until the end: where a
 * tile is touched so often, that is little beside what else it costs. */
static int join_parts(lum_map_tile *tile, lum_map_spool *spool,
                      int64_t *written)
{
    lum_map_merge merge;
    part_tail tail = {0, 0};
    uint64_t before = 0;
    int code = lum_map_merge_begin(&merge, tile, spool);
    for (unsigned i = 0; i < merge.count && code == 0; i++) {
        before += merge.parts[i].left +
                  (uint64_t)(merge.parts[i].end - merge.parts[i].next);
    }
    if (code == 0) {
        code = write_merged(&merge, spool, &tail.count);
    }
    lum_map_merge_end(&merge);
    if (code == 0) {
        code = write_tail(tile, spool, &tail);
        tile->parts = 1;
        *written = (int64_t)tail.count - (int64_t)(before - tile->table.used);
    }
    return code;
}

int lum_map_part_write(lum_map_tile *tile, lum_map_spool *spool,
                       int64_t *written)
{
    const part_tail tail = {tile->part, tile->table.used};
    if (tile->parts == LUM_MAP_PARTS_MAX) {
        return join_parts(tile, spool, written);
    }
    int code = spool_write(spool, tile->table.at,
                           tile->table.used * sizeof *tile->table.at);
    if (code == 0) {
        code = write_tail(tile, spool, &tail);
    }
    tile->parts++;
    *written = (int64_t)tail.count;
    return code;
}
