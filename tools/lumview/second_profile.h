/* The same records by a second profile. It follows a decoder, which tells the
 * time: each of its frames is shown beside the newest complete one of these. */
#ifndef LUMVIEW_SECOND_PROFILE_H
#define LUMVIEW_SECOND_PROFILE_H

#include "decoder.h"

struct second;

/* options: of the decoder, with the second layout and projector. To be freed by
 * second_free(); NULL without memory. */
struct second *second_new(const lum_framer_options *options);
void second_free(struct second *second); /* NULL is allowed */

/* As lum_framer_set_interface(). */
void second_set_interface(struct second *second, const char *name);

/* Take a record, before the decoder does, or the end of the source: NULL. It
 * is as decoder_push(): of several frames that one record completes, each is
 * there in its turn. views: that the next frames are to have; none while frames
 * are passed over. */
enum decoded second_push(struct second *second, const lum_record *record,
                         const struct feed_views *views);

/* Put its newest frame beside those of the picture, in the views that both
 * have. */
void second_join(const struct second *second, struct picture *picture);

#endif
