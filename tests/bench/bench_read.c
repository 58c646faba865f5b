/* What `script/bench --peers` holds Python against, in one process that lives
 * for all rounds. Each line of standard input is a task, and is answered by
 * "WALL PROCESSOR COUNT": seconds, seconds of this process, and what was done.
 *
 *   frames CAPTURE    every frame with columns x y z: points
 *   threads CAPTURE   the same by two threads
 *   read CAPTURE      read() of all, 1 MB a call: bytes
 *   memcpy            64 MiB: bytes */
#define _POSIX_C_SOURCE 200809L
#include "datagrams.h"

#include "lum/frame/reader.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COPY_BYTES  ((size_t)64u << 20)
#define BLOCK_BYTES 1000000u
#define LINE_BYTES  4200u

/* The compiler must believe that somebody reads and writes what p points to. */
static void escape(const void *p)
{
    __asm__ volatile("" : : "r"(p) : "memory");
}

static size_t read_frames(const char *path, uint32_t threads)
{
    const lum_framer_options framer = {.struct_size = sizeof framer,
                                       .threads = threads};
    const lum_reader_options options = {
        .struct_size = sizeof options, .path = path, .framer = &framer};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    lum_error error = {""};
    size_t count = 0;
    int status = lum_reader_open(&options, &reader, &error);
    while (status >= 0 &&
           (status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        size_t spacing = 0;
        escape(lum_frame_xyz(frame, &spacing));
        count += lum_frame_count(frame);
    }
    if (status < 0) {
        stop(error.text);
    }
    lum_reader_close(reader);
    return count;
}

static size_t read_file(const char *path)
{
    static char block[BLOCK_BYTES];
    ssize_t n = 0;
    size_t count = 0;
    const int fd = open(path, O_RDONLY);
    while (fd >= 0 && (n = read(fd, block, sizeof block)) > 0) {
        count += (size_t)n;
    }
    if (fd < 0 || n < 0) {
        stop("the capture cannot be read");
    }
    (void)close(fd);
    return count;
}

static size_t copy(void)
{
    static char *from = NULL;
    static char *to = NULL;
    if (from == NULL) {
        from = allocate(COPY_BYTES);
        to = allocate(COPY_BYTES);
        memset(from, 1, COPY_BYTES);
    }
    memcpy(to, from, COPY_BYTES);
    escape(to);
    return COPY_BYTES;
}

static size_t work(const char *task)
{
    if (strncmp(task, "frames ", 7) == 0) {
        return read_frames(task + 7, 1);
    }
    if (strncmp(task, "threads ", 8) == 0) {
        return read_frames(task + 8, 2);
    }
    if (strncmp(task, "read ", 5) == 0) {
        return read_file(task + 5);
    }
    if (strcmp(task, "memcpy") == 0) {
        return copy();
    }
    stop("unknown task");
}

int main(void)
{
    static char task[LINE_BYTES];
    while (fgets(task, sizeof task, stdin) != NULL) {
        task[strcspn(task, "\n")] = '\0';
        const double wall = now_s();
        const double processor = processor_s();
        const size_t count = work(task);
        (void)printf("%.9f %.9f %zu\n", now_s() - wall,
                     processor_s() - processor, count);
        (void)fflush(stdout);
    }
    return 0;
}
