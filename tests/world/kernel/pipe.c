#define _GNU_SOURCE /* POLLRDNORM */
#include "pipe.h"

#include "disk_internal.h"
#include "pipe_internal.h"
#include "process.h"
#include "shown.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#define PAGES      16u
#define PAGE_BYTES 4096u

/* The user's ends look so long after something has changed. */
#define LOOK_NS (20 * WORLD_US)

struct pipe_page {
    unsigned from, len;
    char bytes[PAGE_BYTES];
};

struct pipe_body {
    struct pipe_page *pages[PAGES]; /* a ring; made when they are needed */
    unsigned first, count;
    unsigned readers, writers;
    unsigned reader_opens, writer_opens; /* of a fifo, ever */
    world_queue changed;
    disk_inode *inode; /* of a fifo; NULL: the last end frees the body */
    world_reader *reader;
    world_writer *writer;
};

/* What a file knows of its pipe. */
struct pipe_end {
    struct pipe_body *body;
    bool reads, writes;
    unsigned writer_opens; /* when it was opened, but for one that is there */
};

struct world_reader {
    world_reader *next;
    world_file *end; /* NULL: closed */
    struct pipe_body *body;
    shown shown;
    int64_t pace;
    bool is_due; /* an event will look */
    bool has_ended;
};

struct world_writer {
    world_writer *next;
    world_file *end;
    struct pipe_body *body;
    char *bytes;
    size_t len;
    bool is_due, closes;
};

static world_reader *readers;
static world_writer *writers;

static void *must(void *memory)
{
    if (memory == NULL) {
        abort();
    }
    return memory;
}

static int refuse(int code)
{
    errno = code;
    return -1;
}

static struct pipe_end *of(const world_file *file)
{
    return file->data;
}

static void rouse_reader(world_reader *reader);
static void rouse_writer(world_writer *writer);

static void changed(struct pipe_body *body)
{
    world_wake_all(&body->changed);
    if (body->reader != NULL) {
        rouse_reader(body->reader);
    }
    if (body->writer != NULL) {
        rouse_writer(body->writer);
    }
}

/* A fifo that was not opened to write yet has not ended. */
static bool is_at_end(const struct pipe_end *end)
{
    return end->body->writers == 0 &&
           end->body->writer_opens != end->writer_opens;
}

/* --- Bytes --- */

static bool is_full(const struct pipe_body *body)
{
    return body->count == PAGES;
}

static struct pipe_page *page_at(struct pipe_body *body, unsigned i)
{
    return body->pages[(body->first + i) % PAGES];
}

static size_t take(struct pipe_body *body, char *out, size_t size)
{
    size_t done = 0;
    while (done < size && body->count > 0) {
        struct pipe_page *page = page_at(body, 0);
        const size_t n =
            page->len < size - done ? page->len : (unsigned)(size - done);
        memcpy(out + done, page->bytes + page->from, n);
        page->from += (unsigned)n;
        page->len -= (unsigned)n;
        done += n;
        if (page->len == 0) {
            body->first = (body->first + 1u) % PAGES;
            body->count--;
        }
    }
    return done;
}

/* A page of its own for up to 4096 bytes. Returns how many. */
static size_t put_page(struct pipe_body *body, const char *bytes, size_t size)
{
    struct pipe_page **page = &body->pages[(body->first + body->count) % PAGES];
    const unsigned n = size < PAGE_BYTES ? (unsigned)size : PAGE_BYTES;
    if (*page == NULL) {
        *page = must(malloc(sizeof **page));
    }
    (*page)->from = 0;
    (*page)->len = n;
    memcpy((*page)->bytes, bytes, n);
    body->count++;
    return n;
}

/* As Linux: what is left over from whole pages goes behind the last bytes, if
 * all of it fits there. */
static size_t put_behind(struct pipe_body *body, const char *bytes, size_t size)
{
    const unsigned n = (unsigned)(size % PAGE_BYTES);
    if (n == 0 || body->count == 0) {
        return 0;
    }
    struct pipe_page *page = page_at(body, body->count - 1u);
    if (page->from + page->len + n > PAGE_BYTES) {
        return 0;
    }
    memcpy(page->bytes + page->from + page->len, bytes, n);
    page->len += n;
    return n;
}

static size_t put(struct pipe_body *body, const char *bytes, size_t size,
                  bool is_first)
{
    size_t done = is_first ? put_behind(body, bytes, size) : 0;
    while (done < size && !is_full(body)) {
        done += put_page(body, bytes + done, size - done);
    }
    return done;
}

/* --- Ends of processes --- */

static ssize_t read_pipe(world_file *file, void *out, size_t size)
{
    struct pipe_body *body = of(file)->body;
    while (size > 0) {
        const size_t n = take(body, out, size);
        if (n > 0) {
            changed(body);
            return (ssize_t)n;
        }
        if (body->writers == 0) {
            return 0;
        }
        if (!world_file_waits(file)) {
            return refuse(EAGAIN);
        }
        if (world_wait(&body->changed, WORLD_NEVER) == WORLD_INTERRUPTED) {
            return refuse(EINTR);
        }
    }
    return 0;
}

/* The signal comes before the call returns. */
static int refuse_broken(void)
{
    if (world_process_self() != NULL) {
        world_signal_self(SIGPIPE);
    }
    return refuse(EPIPE);
}

static ssize_t write_pipe(world_file *file, const void *bytes, size_t size)
{
    struct pipe_body *body = of(file)->body;
    size_t done = 0;
    bool is_first = true;
    int code = 0;
    while (done < size && code == 0) {
        if (body->readers == 0) {
            const int result = refuse_broken();
            return done > 0 ? (ssize_t)done : result;
        }
        const size_t n =
            put(body, (const char *)bytes + done, size - done, is_first);
        done += n;
        is_first = false;
        if (n > 0) {
            changed(body);
        } else if (!world_file_waits(file)) {
            code = EAGAIN;
        } else if (world_wait(&body->changed, WORLD_NEVER) ==
                   WORLD_INTERRUPTED) {
            code = EINTR;
        }
    }
    return done > 0 || code == 0 ? (ssize_t)done : refuse(code);
}

static short poll_pipe(world_file *file)
{
    const struct pipe_end *end = of(file);
    const struct pipe_body *body = end->body;
    unsigned events = 0;
    if (end->reads) {
        events |= body->count > 0 ? POLLIN | POLLRDNORM : 0u;
        events |= is_at_end(end) ? POLLHUP : 0u;
    }
    if (end->writes) {
        events |= is_full(body) ? 0u : POLLOUT | POLLWRNORM;
        events |= body->readers == 0 ? POLLERR : 0u;
    }
    return (short)events;
}

static int stat_pipe(world_file *file, struct stat *out)
{
    const disk_inode *inode = of(file)->body->inode;
    if (inode != NULL) {
        disk_stat(inode, out);
        return 0;
    }
    out->st_mode = S_IFIFO | S_IRUSR | S_IWUSR;
    out->st_ino = file->number;
    out->st_nlink = 1;
    out->st_uid = WORLD_UID;
    out->st_blksize = PAGE_BYTES;
    return 0;
}

static int control_pipe(world_file *file, unsigned long request, void *argument)
{
    struct pipe_body *body = of(file)->body;
    int held = 0;
    if (request != FIONREAD) {
        return refuse(ENOTTY);
    }
    for (unsigned i = 0; i < body->count; i++) {
        held += (int)page_at(body, i)->len;
    }
    *(int *)argument = held;
    return 0;
}

void pipe_body_free(struct pipe_body *body)
{
    if (body == NULL) {
        return;
    }
    for (unsigned i = 0; i < PAGES; i++) {
        free(body->pages[i]);
    }
    free(body);
}

static void close_pipe(world_file *file)
{
    struct pipe_end *end = of(file);
    struct pipe_body *body = end->body;
    disk_inode *inode = body->inode;
    body->readers -= end->reads ? 1u : 0u;
    body->writers -= end->writes ? 1u : 0u;
    free(end);
    changed(body);
    if (body->readers == 0 && body->writers == 0) {
        body->first = body->count = 0; /* a fifo forgets */
    }
    if (inode != NULL) {
        disk_inode_drop(inode);
    } else if (body->readers == 0 && body->writers == 0) {
        pipe_body_free(body);
    }
}

static world_file *reopen_pipe(world_file *file, int flags);

static const world_file_kind pipe_kind = {
    .name = "pipe",
    .read = read_pipe,
    .write = write_pipe,
    .stat = stat_pipe,
    .poll = poll_pipe,
    .ioctl = control_pipe,
    .reopen = reopen_pipe,
    .close = close_pipe,
};

/* --- Making --- */

static world_file *make_end(struct pipe_body *body, int flags)
{
    struct pipe_end *end = must(calloc(1, sizeof *end));
    const int mode = flags & O_ACCMODE;
    end->body = body;
    end->reads = mode != O_WRONLY;
    end->writes = mode != O_RDONLY;
    end->writer_opens = body->writer_opens - (body->writers > 0 ? 1u : 0u);
    body->readers += end->reads ? 1u : 0u;
    body->writers += end->writes ? 1u : 0u;
    body->reader_opens += end->reads ? 1u : 0u;
    body->writer_opens += end->writes ? 1u : 0u;
    world_file *file = world_file_new(&pipe_kind, flags, end);
    file->changed = &body->changed;
    return file;
}

/* A new end sees a pipe that had its writer from the beginning. */
void world_pipe_make(world_file **read_end, world_file **write_end, int flags)
{
    struct pipe_body *body = must(calloc(1, sizeof *body));
    *read_end = make_end(body, O_RDONLY | flags);
    *write_end = make_end(body, O_WRONLY | flags);
}

/* Until the other side was opened, if only for a moment. */
static int wait_for_other(const unsigned *opens, struct pipe_body *body)
{
    const unsigned before = *opens;
    while (*opens == before) {
        if (world_wait(&body->changed, WORLD_NEVER) == WORLD_INTERRUPTED) {
            return EINTR;
        }
    }
    return 0;
}

/* While it waits the file is the call's: it goes with the process. */
static world_file *wait_open(world_file *file, struct pipe_body *body)
{
    const int mode = file->flags & O_ACCMODE;
    const bool lacks_other = (mode == O_RDONLY && body->writers == 0) ||
                             (mode == O_WRONLY && body->readers == 0);
    int code = 0;
    if (!lacks_other || !world_file_waits(file) ||
        world_process_self() == NULL) {
        return file;
    }
    world_file_hold(file);
    world_file_drop(file);
    code = wait_for_other(
        mode == O_RDONLY ? &body->writer_opens : &body->reader_opens, body);
    if (code == 0) {
        (void)world_file_use(file);
    }
    world_fd_release(file);
    errno = code;
    return code == 0 ? file : NULL;
}

/* A process that does not wait cannot write where nobody reads. */
static bool lacks_reader(const struct pipe_body *body, int flags)
{
    return (flags & O_ACCMODE) == O_WRONLY && (flags & O_NONBLOCK) != 0 &&
           body->readers == 0 && world_process_self() != NULL;
}

static world_file *open_body(struct pipe_body *body, int flags)
{
    if (lacks_reader(body, flags)) {
        errno = ENXIO;
        return NULL;
    }
    if (body->inode != NULL) {
        (void)disk_inode_use(body->inode); /* the end's, which drops it */
    }
    world_file *file = make_end(body, flags);
    changed(body);
    return wait_open(file, body);
}

static world_file *reopen_pipe(world_file *file, int flags)
{
    return open_body(of(file)->body, flags);
}

world_file *pipe_open_fifo(disk_inode *inode, int flags)
{
    if (inode->pipe == NULL) {
        inode->pipe = must(calloc(1, sizeof *inode->pipe));
        inode->pipe->inode = inode;
    }
    return open_body(inode->pipe, flags);
}

disk_inode *pipe_inode(const world_file *file)
{
    return file->kind == &pipe_kind ? of(file)->body->inode : NULL;
}

/* --- The user reads --- */

static void look(void *argument);

static void rouse_reader(world_reader *reader)
{
    if (reader->is_due || reader->has_ended || reader->pace == 0) {
        return;
    }
    if (reader->pace == WORLD_READER_FAST) {
        look(reader);
    } else if (reader->body->count > 0 || is_at_end(of(reader->end))) {
        reader->is_due = true;
        (void)world_at(world_now() + LOOK_NS, look, reader);
    }
}

/* All that is there, or a page of it. */
static size_t take_some(world_reader *reader)
{
    char bytes[PAGE_BYTES];
    size_t all = 0;
    size_t n = 0;
    do {
        n = take(reader->body, bytes, sizeof bytes);
        all += n;
        if (n > 0) {
            shown_add(&reader->shown, bytes, n);
        }
    } while (n > 0 && reader->pace == WORLD_READER_FAST);
    return all;
}

static void look(void *argument)
{
    world_reader *reader = argument;
    reader->is_due = false;
    if (reader->end == NULL || reader->pace == 0) {
        return;
    }
    const size_t n = take_some(reader);
    if (n > 0) {
        world_wake_all(&reader->body->changed);
    }
    if (n > 0 && reader->pace != WORLD_READER_FAST) {
        reader->is_due = true;
        (void)world_at(world_now() + LOOK_NS +
                           (int64_t)n * WORLD_S / reader->pace,
                       look, reader);
    } else if (is_at_end(of(reader->end))) {
        reader->has_ended = true;
        world_wake_all(&reader->shown.came);
    }
}

static world_reader *new_reader(world_file *end, const char *name)
{
    world_reader *reader = must(calloc(1, sizeof *reader));
    reader->end = end;
    reader->body = of(end)->body;
    reader->pace = WORLD_READER_FAST;
    shown_begin(&reader->shown, name);
    reader->body->reader = reader;
    reader->next = readers;
    readers = reader;
    rouse_reader(reader);
    return reader;
}

world_reader *world_reader_new(const char *name, world_file **write_end)
{
    world_file *read_end = NULL;
    world_pipe_make(&read_end, write_end, 0);
    return new_reader(read_end, name);
}

/* The fifo of a path, opened without waiting. */
static world_file *open_end(world_disk *disk, const char *path, int flags)
{
    disk_place place;
    world_file *file = NULL;
    if (disk_find(disk, "/", path, DISK_FOLLOWS, &place) != 0) {
        return NULL;
    }
    if (place.inode != NULL && S_ISFIFO(place.inode->mode)) {
        file = pipe_open_fifo(place.inode, flags | O_NONBLOCK);
    }
    disk_place_drop(&place);
    return file;
}

world_reader *world_reader_of_fifo(world_disk *disk, const char *path)
{
    world_file *end = open_end(disk, path, O_RDONLY);
    return end != NULL ? new_reader(end, path) : NULL;
}

void world_reader_pace(world_reader *reader, int64_t bytes_per_s)
{
    reader->pace = bytes_per_s;
    if (bytes_per_s != WORLD_READER_FAST) {
        world_met(bytes_per_s == 0 ? "fault:reader-stalls"
                                   : "fault:reader-slow");
        WORLD_TRACE("%s: its reader takes %lld bytes/s", reader->shown.name,
                    (long long)bytes_per_s);
    }
    rouse_reader(reader);
}

void world_reader_close(world_reader *reader)
{
    world_file *end = reader->end;
    if (end != NULL) {
        WORLD_TRACE("%s: its reader goes", reader->shown.name);
        world_met("fault:reader-closes");
        reader->end = NULL;
        reader->has_ended = true;
        reader->body->reader = NULL;
        world_wake_all(&reader->shown.came);
        world_file_drop(end);
    }
}

const char *world_reader_text(const world_reader *reader, size_t *size)
{
    return shown_text(&reader->shown, size);
}

bool world_reader_has_ended(const world_reader *reader)
{
    return reader->has_ended;
}

world_queue *world_reader_came(world_reader *reader)
{
    return &reader->shown.came;
}

/* --- The user writes --- */

static void fill(void *argument);

static void rouse_writer(world_writer *writer)
{
    if (writer->is_due || writer->end == NULL) {
        return;
    }
    const bool can = writer->body->readers > 0 && !is_full(writer->body);
    if ((writer->len > 0 && can) || (writer->len == 0 && writer->closes)) {
        writer->is_due = true;
        (void)world_at(world_now() + LOOK_NS, fill, writer);
    }
}

static void fill(void *argument)
{
    world_writer *writer = argument;
    world_file *end = writer->end;
    writer->is_due = false;
    if (end == NULL) {
        return;
    }
    if (writer->len > 0 && writer->body->readers > 0) {
        const size_t n = put(writer->body, writer->bytes, writer->len, true);
        writer->len -= n;
        memmove(writer->bytes, writer->bytes + n, writer->len);
        world_wake_all(&writer->body->changed);
    }
    if (writer->len == 0 && writer->closes) {
        writer->end = NULL;
        writer->body->writer = NULL;
        world_file_drop(end);
        return;
    }
    rouse_writer(writer);
}

static world_writer *new_writer(world_file *end)
{
    world_writer *writer = must(calloc(1, sizeof *writer));
    writer->end = end;
    writer->body = of(end)->body;
    writer->body->writer = writer;
    writer->next = writers;
    writers = writer;
    return writer;
}

world_writer *world_writer_new(world_file **read_end)
{
    world_file *write_end = NULL;
    world_pipe_make(read_end, &write_end, 0);
    return new_writer(write_end);
}

world_writer *world_writer_of_fifo(world_disk *disk, const char *path)
{
    world_file *end = open_end(disk, path, O_WRONLY);
    return end != NULL ? new_writer(end) : NULL;
}

void world_writer_put(world_writer *writer, const void *bytes, size_t size)
{
    if (size > 0) {
        writer->bytes = must(realloc(writer->bytes, writer->len + size));
        memcpy(writer->bytes + writer->len, bytes, size);
        writer->len += size;
    }
    rouse_writer(writer);
}

void world_writer_say(world_writer *writer, const char *text)
{
    world_writer_put(writer, text, strlen(text));
}

void world_writer_close(world_writer *writer)
{
    writer->closes = true;
    rouse_writer(writer);
}

size_t world_writer_left(const world_writer *writer)
{
    return writer->len;
}

/* Their ends go with all files, and are not looked at then. */
void world_pipe_reset(void)
{
    while (readers != NULL) {
        world_reader *next = readers->next;
        if (readers->end != NULL) {
            readers->body->reader = NULL;
        }
        shown_end(&readers->shown);
        free(readers);
        readers = next;
    }
    while (writers != NULL) {
        world_writer *next = writers->next;
        if (writers->end != NULL) {
            writers->body->writer = NULL;
        }
        free(writers->bytes);
        free(writers);
        writers = next;
    }
}
