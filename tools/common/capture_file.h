/* A capture to be written. One that is made from what is there already stands
 * under its name only when it is whole; one that records what will not come
 * again, from its first datagram on. */
#ifndef LUM_TOOLS_CAPTURE_FILE_H
#define LUM_TOOLS_CAPTURE_FILE_H

#include "provenance.h"

#include "lum/base/error.h"
#include "lum/capture/capture.h"

#include <stdbool.h>

/* Whether a path is written as it is: standard output, a pipe, a device. */
bool capture_file_is_in_place(const char *path);

/* Whether it is to be pcapng, by its name. */
bool capture_file_is_pcapng(const char *path);

/* A pcapng file that says what about has, or, where that is NULL, a pcap file.
 * 0, or -1 with the reason in error; *out is NULL then. A link is followed. */
int capture_file_open(const char *path, const struct provenance *about,
                      lum_capture_writer **out, lum_error *error);

/* As capture_file_open(), with names of interfaces, as those of
 * lum_capture_writer_options; a pcapng file, if there are any. */
int capture_file_open_from(const char *path, const struct provenance *about,
                           const char *const *interfaces, size_t count,
                           lum_capture_writer **out, lum_error *error);

/* As capture_file_open(), with its final name from the first datagram on;
 * recorded data stays, even if the rest fails. */
int capture_file_record(const char *path, const struct provenance *about,
                        lum_capture_writer **out, lum_error *error);

#endif
