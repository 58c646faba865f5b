/* When the kernel had a datagram, on the monotonic clock. */
#ifndef LUM_TOOLS_ARRIVAL_H
#define LUM_TOOLS_ARRIVAL_H

#include <stdint.h>

/* utc_ns is the kernel's stamp; now_ns and now_utc_ns are the same moment. The
 * calendar clock may be set in between: a stamp in the future, or one that is
 * older than 10 s, counts as now. */
int64_t arrival_ns(int64_t utc_ns, int64_t now_ns, int64_t now_utc_ns);

#endif
