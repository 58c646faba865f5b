#define _POSIX_C_SOURCE 200809L
#include "file_writer.h"

#include "rows_file.h"

#include "base/outfile.h"
#include "base/text.h"
#include "base/thread.h"
#include "lum/base/time.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define ROWS_BYTES   16384u
#define HEADER_BYTES 512
#define LOCK_NS      INT64_C(2000000000) /* for another run's line */
#define AGAIN_NS     INT64_C(5000000)
#define END_NS       INT64_C(3000000000)

/* What waits to be written. */
struct work {
    char rows[ROWS_BYTES];
    size_t rows_len;
    char *page; /* NULL: none */
};

struct file_writer {
    char *rows;
    char *header;
    char *page;
    struct work writing; /* the thread's, as the next */
    bool has_begun;      /* to write to standard output */

    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    struct work next;
    uint64_t lost;
    bool has_failed[2]; /* rows, page: the last try */
    bool has_news;
    lum_error news;
    bool is_ending;
    bool has_ended;
};

/* --- Files --- */

static int fail(const char *path, lum_error *error)
{
    return lum_error_set(
        error, "%s: %s", path,
        errno == EEXIST   ? "holds other columns; give another file"
        : errno == ESPIPE ? "is a pipe; give - and let standard output be one"
        : errno == EBUSY  ? "another run adds lines to it"
                          : strerror(errno));
}

/* Another run holds it only while it adds a line. */
static int open_rows(const char *path)
{
    const int64_t end = lum_time_monotonic_ns() + LOCK_NS;
    int fd = rows_file_open(path, false);
    while (fd < 0 && errno == EBUSY && lum_time_monotonic_ns() < end) {
        lum_time_sleep_until(lum_time_monotonic_ns() + AGAIN_NS);
        fd = rows_file_open(path, false);
    }
    return fd;
}

/* How much of the header a file begins with; -1: with something else. A full
 * disk, or a lost power, may have left a part of it. */
static int find_header(const struct file_writer *s, int fd)
{
    char begin[HEADER_BYTES];
    const size_t len = strlen(s->header);
    const int n =
        lseek(fd, 0, SEEK_SET) == 0 ? (int)read(fd, begin, (unsigned)len) : -1;
    return n >= 0 && memcmp(begin, s->header, (size_t)n) == 0 ? n : -1;
}

/* Cuts off the half line that a run may have left that was killed. A longer one
 * is of others: EEXIST. */
static int cut_half_line(int fd, off_t *size)
{
    char end[FILE_WRITER_ROW_BYTES];
    const off_t from =
        *size > (off_t)sizeof end ? *size - (off_t)sizeof end : 0;
    const int n =
        lseek(fd, from, SEEK_SET) == from ? (int)read(fd, end, sizeof end) : -1;
    int whole = n;
    while (whole > 0 && end[whole - 1] != '\n') {
        whole--;
    }
    if (n <= 0 || whole == 0) {
        errno = n < 0 ? errno : EEXIST;
        return -1;
    }
    *size = from + whole;
    return whole == n ? 0 : rows_file_cut(fd, *size);
}

/* Before a line is added to a file of a size: the header, if it has none. */
static int prepare(const struct file_writer *s, int fd, off_t *size)
{
    const size_t len = strlen(s->header);
    const int found = find_header(s, fd);
    if (found < 0 || (found < (int)len && found < *size)) {
        errno = EEXIST;
        return -1;
    }
    if (found == (int)len) {
        return cut_half_line(fd, size);
    }
    *size = 0;
    return rows_file_cut(fd, 0) == 0 ? rows_file_put(fd, s->header, len) : -1;
}

/* Lines are added whole or not at all: what a full disk took of them is cut off
 * again. */
static int add_to_file(const struct file_writer *s, int fd,
                       const struct work *work, off_t size)
{
    if (prepare(s, fd, &size) == 0 &&
        rows_file_put(fd, work->rows, work->rows_len) == 0) {
        return 0;
    }
    const int code = errno;
    if (code != EEXIST) {
        (void)!rows_file_cut(fd, size);
    }
    errno = code;
    return -1;
}

/* Standard output, or a terminal: the header comes once. */
static int add_to_stream(struct file_writer *s, int fd, const struct work *work)
{
    const bool is_first = !s->has_begun;
    s->has_begun = true;
    return is_first && rows_file_put(fd, s->header, strlen(s->header)) != 0
               ? -1
               : rows_file_put(fd, work->rows, work->rows_len);
}

/* A pipe would lose lines that nobody reads before it is closed. */
static int add_rows(struct file_writer *s, int fd, const struct work *work)
{
    struct stat look;
    if (fstat(fd, &look) != 0) {
        return -1;
    }
    if (S_ISREG(look.st_mode)) {
        return add_to_file(s, fd, work, look.st_size);
    }
    if (!S_ISCHR(look.st_mode)) {
        errno = ESPIPE;
        return -1;
    }
    return add_to_stream(s, fd, work);
}

static int write_rows(struct file_writer *s, const struct work *work,
                      lum_error *error)
{
    if (strcmp(s->rows, "-") == 0) {
        return add_to_stream(s, STDOUT_FILENO, work) == 0
                   ? 0
                   : fail("standard output", error);
    }
    const int fd = open_rows(s->rows);
    if (fd < 0) {
        return fail(s->rows, error);
    }
    const int result = add_rows(s, fd, work);
    if (result != 0) {
        (void)fail(s->rows, error);
    }
    (void)close(fd);
    return result;
}

/* A file that cannot take lines is known before the first. */
static int check_rows(struct file_writer *s, lum_error *error)
{
    const struct work nothing = {.rows_len = 0};
    return s->rows == NULL || strcmp(s->rows, "-") == 0
               ? 0
               : write_rows(s, &nothing, error);
}

/* --- The thread --- */

static uint64_t count_rows(const struct work *work)
{
    uint64_t n = 0;
    for (size_t i = 0; i < work->rows_len; i++) {
        n += work->rows[i] == '\n' ? 1u : 0u;
    }
    return n;
}

/* With the lock held. What fails again and again is news once. */
static void note(struct file_writer *s, unsigned what, int result,
                 const lum_error *error)
{
    if (result != 0 && !s->has_failed[what]) {
        s->has_news = true;
        s->news = *error;
    }
    s->has_failed[what] = result != 0;
}

static void do_work(struct file_writer *s)
{
    struct work *work = &s->writing;
    lum_error error = {""};
    if (work->rows_len > 0) {
        const int result = write_rows(s, work, &error);
        (void)pthread_mutex_lock(&s->lock);
        s->lost += result != 0 ? count_rows(work) : 0;
        work->rows_len = 0;
        note(s, 0, result, &error);
        (void)pthread_mutex_unlock(&s->lock);
    }
    if (work->page != NULL) {
        const int result =
            lum_outfile_save(s->page, work->page, strlen(work->page), &error);
        free(work->page);
        work->page = NULL;
        (void)pthread_mutex_lock(&s->lock);
        note(s, 1, result, &error);
        (void)pthread_mutex_unlock(&s->lock);
    }
}

static void *run(void *context)
{
    struct file_writer *s = context;
    bool goes_on = true;
    while (goes_on) {
        (void)pthread_mutex_lock(&s->lock);
        while (s->next.rows_len == 0 && s->next.page == NULL && !s->is_ending) {
            (void)pthread_cond_wait(&s->changed, &s->lock);
        }
        s->writing = s->next;
        s->next.rows_len = 0;
        s->next.page = NULL;
        goes_on = !s->is_ending;
        (void)pthread_mutex_unlock(&s->lock);
        do_work(s);
    }
    (void)pthread_mutex_lock(&s->lock);
    s->has_ended = true;
    (void)pthread_cond_broadcast(&s->changed);
    (void)pthread_mutex_unlock(&s->lock);
    return NULL;
}

/* --- Its user's side --- */

static void destroy(struct file_writer *s)
{
    (void)pthread_mutex_destroy(&s->lock);
    (void)pthread_cond_destroy(&s->changed);
    free(s->rows);
    free(s->header);
    free(s->page);
    free(s);
}

/* A copy, or NULL of NULL. False: no memory. */
static bool copy(const char *text, char **out)
{
    *out = text != NULL ? lum_text_copy(text) : NULL;
    return text == NULL || *out != NULL;
}

struct file_writer *file_writer_new(const char *rows, const char *header,
                                    const char *page, lum_error *error)
{
    struct file_writer *s = calloc(1, sizeof *s);
    pthread_t thread;
    if (s == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    (void)pthread_mutex_init(&s->lock, NULL);
    (void)pthread_cond_init(&s->changed, NULL);
    s->header = lum_text_copy(header);
    const bool has_rows = copy(rows, &s->rows);
    if (!copy(page, &s->page) || !has_rows || s->header == NULL) {
        (void)lum_error_set(error, "out of memory");
    } else if (check_rows(s, error) == 0) {
        if (lum_thread_start(&thread, run, s) == 0) {
            (void)pthread_detach(thread);
            return s;
        }
        (void)lum_error_set(error, "no thread to write files with");
    }
    destroy(s);
    return NULL;
}

void file_writer_add(struct file_writer *writer, const char *row)
{
    const size_t len = strlen(row);
    if (writer->rows == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&writer->lock);
    if (len > ROWS_BYTES - writer->next.rows_len) {
        writer->lost++;
    } else {
        memcpy(writer->next.rows + writer->next.rows_len, row, len);
        writer->next.rows_len += len;
    }
    (void)pthread_cond_broadcast(&writer->changed);
    (void)pthread_mutex_unlock(&writer->lock);
}

void file_writer_turn(struct file_writer *writer, const char *page)
{
    char *copy = writer->page != NULL ? lum_text_copy(page) : NULL;
    (void)pthread_mutex_lock(&writer->lock);
    free(writer->next.page);
    writer->next.page = copy;
    writer->has_failed[1] |= copy == NULL && writer->page != NULL;
    (void)pthread_cond_broadcast(&writer->changed);
    (void)pthread_mutex_unlock(&writer->lock);
}

bool file_writer_tell(struct file_writer *writer, lum_error *out)
{
    (void)pthread_mutex_lock(&writer->lock);
    const bool has_news = writer->has_news;
    *out = writer->news;
    writer->has_news = false;
    (void)pthread_mutex_unlock(&writer->lock);
    return has_news;
}

static bool has_ended(struct file_writer *s)
{
    (void)pthread_mutex_lock(&s->lock);
    const bool has = s->has_ended;
    (void)pthread_mutex_unlock(&s->lock);
    return has;
}

/* One that hangs in a disk keeps its memory: it may wake up yet. */
struct file_writer_rest file_writer_end(struct file_writer *writer)
{
    struct file_writer_rest rest = {.lost = 0};
    const int64_t end = lum_time_monotonic_ns() + END_NS;
    if (writer == NULL) {
        return rest;
    }
    (void)pthread_mutex_lock(&writer->lock);
    writer->is_ending = true;
    (void)pthread_cond_broadcast(&writer->changed);
    (void)pthread_mutex_unlock(&writer->lock);
    while (!has_ended(writer) && lum_time_monotonic_ns() < end) {
        lum_time_sleep_until(lum_time_monotonic_ns() + AGAIN_NS);
    }
    (void)pthread_mutex_lock(&writer->lock);
    rest.hangs = !writer->has_ended;
    rest.lost = writer->lost + (rest.hangs ? count_rows(&writer->writing) +
                                                 count_rows(&writer->next)
                                           : 0);
    rest.has_news = writer->has_news;
    rest.news = writer->news;
    rest.page_failed =
        writer->page != NULL && (writer->has_failed[1] || rest.hangs);
    (void)pthread_mutex_unlock(&writer->lock);
    if (!rest.hangs) {
        destroy(writer);
    }
    return rest;
}
