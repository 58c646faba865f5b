/* What the summary says of the captures that were read as one stream. */
#ifndef LUMDUMP_STREAM_H
#define LUMDUMP_STREAM_H

#include "lum/capture/capture.h"

#include <stdint.h>
#include <stdio.h>

/* Rows where they are several, with what lies between them. */
void stream_print_text(const lum_capture *capture, FILE *out);

/* Records that were read of all of them. */
uint64_t stream_records(const lum_capture *capture);

/* The member "sources". print_text: writes a JSON string. */
void stream_print_json(const lum_capture *capture,
                       void (*print_text)(const char *text, FILE *out),
                       FILE *out);

#endif
