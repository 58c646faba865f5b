/* The capture being written. One that is made from what is there already stands
 * under its name only when it is whole; one that records what will not come
 * again, from its first datagram on. */
#ifndef LUM_TOOLS_CAPTURE_FILE_H
#define LUM_TOOLS_CAPTURE_FILE_H

#include "provenance.h"

#include "lum/base/error.h"
#include "lum/capture/capture.h"

#include <stdbool.h>
#include <stdint.h>

struct capture_file {
    lum_capture_writer *writer;
};

/* Whether a path is written as it is: standard output, a pipe, a device. */
bool capture_file_is_in_place(const char *path);

/* A pcapng file that says what about has, or, where that is NULL, a pcap file.
 * 0, or -1 with the reason in error. A link is followed. */
int capture_file_open(const char *path, const struct provenance *about,
                      struct capture_file *out, lum_error *error);

/* As capture_file_open(), under its own name from the first datagram on; what
 * was recorded stays, whatever becomes of the rest. */
int capture_file_record(const char *path, const struct provenance *about,
                        struct capture_file *out, lum_error *error);

/* 0, or -1 with the reason in error and errno. */
int capture_file_add(struct capture_file *file, const lum_datagram *datagram,
                     lum_error *error);

/* Make what was added readable to others. 0, or -1 with the reason in error and
 * errno. */
int capture_file_flush(struct capture_file *file, lum_error *error);

/* Bytes of the file so far. */
uint64_t capture_file_bytes(const struct capture_file *file);

/* Give the file its name. 0, or -1 with the reason in error and errno; then
 * nothing is left behind but what was recorded. */
int capture_file_close(struct capture_file *file, lum_error *error);

/* Remove what was written; of a recording it stays, if there is any. Does not
 * wait for whoever reads. */
void capture_file_abort(struct capture_file *file);

#endif
