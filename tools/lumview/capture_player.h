/* Plays a capture: at its pace or step by step, from any frame. A thread does
 * it, or where there are none, who calls player_work(). */
#ifndef LUMVIEW_CAPTURE_PLAYER_H
#define LUMVIEW_CAPTURE_PLAYER_H

#include "../common/provenance.h"
#include "../common/sources.h"
#include "decoder.h"

#include "lum/base/error.h"

#include <stdint.h>

struct player;

struct player_options {
    const struct sources *sources;        /* kept */
    const char *rig;                      /* its file; NULL: no rig */
    const struct provenance_source *said; /* of the files; kept */
    bool is_quiet;                        /* no warnings on standard error */
    struct decoder_options decoder;
};

/* Begin. What can be read once is played from its beginning to its end. 0, or
 * -1 with the reason in error. */
int player_start(const struct player_options *options, struct player **out,
                 lum_error *error);

/* As feed_work(). */
int64_t player_work(struct player *player);

/* End; the stage is closing. NULL is allowed. */
void player_end(struct player *player);

#endif
