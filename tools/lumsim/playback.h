/* The data of a recording, sent with its timing. */
#ifndef LUMSIM_PLAYBACK_H
#define LUMSIM_PLAYBACK_H

#include "lum/net/socket.h"
#include "named_files.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct playback {
    struct recording *recording; /* NULL: nothing is replayed */
    struct recording_facts facts;
    double speed;
    bool loops;
    bool has_ended;  /* all of it was given */
    bool has_next;   /* next is a packet */
    bool has_failed; /* error says why */
    lum_error error;
    struct recorded next;
    int64_t begin_ns;   /* when its first packet is due */
    int64_t delayed_ns; /* by which all came later than recorded */
    uint8_t *bytes;     /* of the packets given last */
    uint64_t rounds;    /* times it was given whole */
};

/* Look through the capture and open it. 0, or -1 with the reason in error. */
int playback_open(struct playback *out, const struct options *o,
                  lum_error *error);

void playback_close(struct playback *playback);

/* From the start; begin_ns: when the first packet is due. */
void playback_begin(struct playback *playback, int64_t begin_ns);

/* Up to max datagrams that are due. Returns how many. */
size_t playback_take(struct playback *playback, int64_t now_ns,
                     lum_outgoing *out, size_t max);

/* When the next one is due; INT64_MAX: there is none. */
int64_t playback_next_ns(const struct playback *playback);

#endif
