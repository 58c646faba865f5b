/* One file of an output: a cloud of the library's writer, or a capture. */
#ifndef LUMDUMP_OUTPUT_FILE_H
#define LUMDUMP_OUTPUT_FILE_H

#include "options.h"

#include "lum/base/error.h"
#include "lum/capture/capture.h"
#include "lum/cloud/writer.h"
#include "lum/picture/picture.h"

#include <stdbool.h>
#include <stdint.h>

/* How all files of an output are written. It points into itself: not to be
 * copied. */
struct file_format {
    bool is_capture;
    bool is_growing;                /* a recording that readers may look at */
    const struct provenance *about; /* a capture's; NULL: it has no room */
    lum_writer_options cloud;
    lum_mcap_options mcap;
    unsigned packing_threads;                      /* for its chunks */
    lum_mcap_sensor sensors[LUM_MCAP_SENSORS_MAX]; /* of a rig */
    lum_picture_options drawing;
    char title[160]; /* of a picture */
    char note[320];
};

struct output_file {
    lum_writer *cloud; /* NULL: it is the capture */
    lum_capture_writer *capture;
    int64_t frame;     /* its own; of a file that ends by rotation, its last */
    unsigned number;   /* of a numbered file */
    bool is_begun;     /* the capture's beginning is on its way to the disk */
    bool is_told_lost; /* others have removed or renamed it */
};

/* That of the i-th output. */
void file_format_choose(const struct options *options, size_t i,
                        struct file_format *out);

/* On failure nothing is open. */
int output_file_open(const struct file_format *format, const char *name,
                     struct output_file *out, lum_error *error);

uint64_t output_file_bytes(const struct output_file *file);

/* Captures and MCAP files have a place for it. */
int output_file_add_datagram(struct output_file *file, const lum_record *record,
                             lum_error *error);

int output_file_flush(struct output_file *file, lum_error *error);

/* Whether others have removed or renamed it, which is told once. */
bool output_file_find_lost(struct output_file *file, lum_error *out);

/* Finish it, wait for the disk. 0, or -1 with the reason in error and errno. */
int output_file_close(const struct output_file *file, lum_error *error);

#endif
