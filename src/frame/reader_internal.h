/* A reader, and its source. */
#ifndef LUM_FRAME_READER_INTERNAL_H
#define LUM_FRAME_READER_INTERNAL_H

#include "lum/frame/reader.h"

#include "base/go_on.h"
#include "place.h"

/* What the reader is about. */
enum stage {
    READING,
    PUSHING,  /* the record gave an event: push it again */
    FLUSHING, /* the source has ended */
    ENDED
};

struct lum_reader {
    lum_record_source source;
    lum_capture *capture; /* NULL: records of the caller */
    char **paths;         /* to open them again; NULL: not possible */
    size_t path_count;
    lum_go_on go_on;
    size_t work_bytes; /* most between two questions */
    size_t work;       /* since the last one */
    lum_framer *framer;
    enum stage stage;
    lum_record record;
    int status;      /* how the source ended: 0 or -1 */
    lum_error error; /* why */
    struct place place;
};

/* Open the capture that the options name; the caller's source of bytes is taken
 * over, also on failure. 0, or -1 with the reason in error. */
int lum_reader_open_source(lum_reader *reader,
                           const lum_reader_options *options, lum_error *error);

/* Also if nothing was opened. */
void lum_reader_close_source(lum_reader *reader);

/* Open the paths again. 0, or -1 with the reason in error. */
int lum_reader_reopen(lum_reader *reader, lum_error *error);

#endif
