#include "framer_internal.h"

void lum_pace_take(lum_pace *p, int64_t frame, int64_t time_ns)
{
    if (p->has_frame && frame <= p->frame) {
        return;
    }
    if (p->has_frame && !p->has_begin) {
        p->has_begin = true;
        p->first = frame;
        p->first_ns = time_ns;
    }
    p->has_frame = true;
    p->frame = frame;
    p->last_ns = time_ns;
}

double lum_pace_rate(const lum_pace *p)
{
    return p->has_begin && p->last_ns > p->first_ns
               ? (double)(p->frame - p->first) /
                     ((double)(p->last_ns - p->first_ns) * 1e-9)
               : 0.0;
}
