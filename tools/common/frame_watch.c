#include "frame_watch.h"

#include "lum/packet.h"

/* Packets that overtake each other are no more lines apart. */
#define REORDER_LINES 8u

bool frame_watch_begins(struct frame_watch *watch, const lum_layout *layout,
                        const void *bytes, size_t len)
{
    lum_group group;
    if (lum_packet_decode(layout, bytes, len, &group) != LUM_PACKET_DATA) {
        return false;
    }
    const bool is_first = !watch->eyes[group.eye].has_line;
    const bool falls =
        !is_first && group.line + REORDER_LINES < watch->eyes[group.eye].line;
    watch->eyes[group.eye].has_line = true;
    watch->eyes[group.eye].line = group.line;
    if (is_first) {
        watch->eyes[group.eye].frames = watch->frames;
    }
    if (!falls || ++watch->eyes[group.eye].frames <= watch->frames) {
        return false;
    }
    watch->frames = watch->eyes[group.eye].frames;
    return true;
}
