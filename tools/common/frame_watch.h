/* Where frames begin in packets that are not put together: for recordings,
 * which are copied as they come. */
#ifndef LUM_TOOLS_FRAME_WATCH_H
#define LUM_TOOLS_FRAME_WATCH_H

#include "lum/group.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* All zero: nothing came yet. */
struct frame_watch {
    struct {
        bool has_line;
        uint32_t line;   /* of its latest packet */
        uint64_t frames; /* that it began */
    } eyes[LUM_EYES];
    uint64_t frames; /* most that an eye began */
};

/* Whether a packet is the first of a frame, of the eye that begins it. Reads
 * only the header. */
bool frame_watch_begins(struct frame_watch *watch, const lum_layout *layout,
                        const void *bytes, size_t len);

#endif
