/** @file
 * Captures from streams. Internal to capture. */
#ifndef LUM_CAPTURE_CAPTURE_INTERNAL_H
#define LUM_CAPTURE_CAPTURE_INTERNAL_H

#include "lum/capture/capture.h"

#include <stdio.h>

/** As lum_capture_open(), from a stream that nothing has been read from.
 * @param file taken over: closed on failure, and with the capture.
 * @param name stands for the file's name in messages; copied. */
LUM_MUST_CHECK int lum_capture_open_stream(FILE *file, const char *name,
                                           lum_capture **out, lum_error *error);

#endif
