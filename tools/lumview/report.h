/* What a person is told of a capture that is played. The thread that plays owns
 * it. */
#ifndef LUMVIEW_REPORT_H
#define LUMVIEW_REPORT_H

#include "captures.h"
#include "decoder.h"
#include "player.h"

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct report {
    const struct player_options *options;
    const struct captures *captures;
    bool is_scanned;      /* a scan tells what is odd about the captures */
    struct totals before; /* of earlier passes */
    int64_t cut_frame;    /* the latest with too many points */
    uint64_t cut;         /* how many were left out of it; 0: of none */
    lum_error broken;     /* the reader's: why it did not get to the end; "" */
};

/* A frame is shown: counters, messages. */
void report_frame(struct report *report, const lum_capture *capture,
                  const struct decoder *decoder, const struct picture *picture);

/* A pass has come to the end of the captures. */
void report_end(struct report *report, const lum_capture *capture,
                const struct decoder *decoder);

/* A pass is over; the counters of the next begin at 0. */
void report_add_pass(struct report *report, const struct decoder *decoder);

#endif
