/* What tools know of a capture that is written. Internal. */
#ifndef LUM_CAPTURE_WRITER_H
#define LUM_CAPTURE_WRITER_H

#include "lum/capture/capture.h"

/* A descriptor of its file, for lum_outfile_sync_copy(); -1: it is none. */
int lum_capture_writer_copy(const lum_capture_writer *writer);

/* Its name, for messages. */
const char *lum_capture_writer_name(const lum_capture_writer *writer);

#endif
