/* What a browser may ask for. There is nothing that a sensor would notice. */
#ifndef LUMVIEW_PAGE_COMMAND_H
#define LUMVIEW_PAGE_COMMAND_H

#include "feed.h"

#include <stdbool.h>
#include <stddef.h>

#define COMMAND_BYTES 64u

enum command_kind {
    COMMAND_VIEW,
    COMMAND_FRAMES,
    COMMAND_PAST,
    COMMAND_PLAY,
    COMMAND_PAUSE,
    COMMAND_STEP,
    COMMAND_SEEK,
    COMMAND_SPEED,
    COMMAND_LOOP
};

struct command {
    enum command_kind kind;
    struct feed_view view;
    int64_t number; /* frames, step, seek; past: the frame before which */
    uint64_t past;  /* bit i: the frame that many and one before it */
    double speed;
    bool loops;
};

/* False: it is none. len is at most COMMAND_BYTES. */
bool command_parse(const char *text, size_t len, struct command *out);

#endif
