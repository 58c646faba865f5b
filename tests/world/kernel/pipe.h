/* Pipes and fifos, with Linux's 16 pages of 4096 bytes, and the user's ends of
 * them. */
#ifndef WORLD_PIPE_H
#define WORLD_PIPE_H

#include "disk.h"
#include "file.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct world_queue;

/* A pipe: its two ends, one use each. flags: O_NONBLOCK or 0. */
void world_pipe_make(world_file **read_end, world_file **write_end, int flags);

/* --- an end that the user reads --- */

typedef struct world_reader world_reader;

/* It takes what comes in the moment in which it comes, and keeps it. The other
 * end is for a process. It lives as long as the world. */
world_reader *world_reader_new(const char *name, world_file **write_end);
/* As a program that opens a fifo of the disk to read; it does not wait. NULL:
 * there is no fifo of this name. */
world_reader *world_reader_of_fifo(world_disk *disk, const char *path);

/* From now on it takes so many bytes a second; 0: it stalls, and the pipe runs
 * full; WORLD_READER_FAST: all at once. */
#define WORLD_READER_FAST INT64_MAX
void world_reader_pace(world_reader *reader, int64_t bytes_per_s);
/* Writers then get SIGPIPE and EPIPE. */
void world_reader_close(world_reader *reader);

/* What it has taken, with a 0 behind it; valid until it takes more. */
const char *world_reader_text(const world_reader *reader, size_t *size);
/* All writers are gone, and all is taken. */
bool world_reader_has_ended(const world_reader *reader);
/* Woken when it has taken something, or at the end. */
struct world_queue *world_reader_came(world_reader *reader);

/* --- an end that the user writes --- */

typedef struct world_writer world_writer;

world_writer *world_writer_new(world_file **read_end);
world_writer *world_writer_of_fifo(world_disk *disk, const char *path);

/* The bytes go in as there is room; this does not wait. */
void world_writer_put(world_writer *writer, const void *bytes, size_t size);
/* As world_writer_put() for a text. */
void world_writer_say(world_writer *writer, const char *text);
/* Once all is in. */
void world_writer_close(world_writer *writer);
/* What was put but has not gone into the pipe yet. */
size_t world_writer_left(const world_writer *writer);

/* Before the files (world_file_reset). */
void world_pipe_reset(void);

#endif
