/* The packets of the selected lines: a capture is cut like a cloud. Packets are
 * held until their line has come, and leave in their order. */
#ifndef LUMDUMP_CUT_H
#define LUMDUMP_CUT_H

#include "options.h"

#include "lum/assembler.h"
#include "lum/base/error.h"
#include "lum/capture/capture.h"

#include <stdbool.h>

struct cut;

/* Whether the options choose lines. */
bool cut_is_asked(const struct options *options);

/* NULL without memory. The options and the layout are kept. */
struct cut *cut_new(const struct options *options, const lum_layout *layout);

/* NULL is allowed. */
void cut_free(struct cut *cut);

/* Hold a packet of the sensor, which was pushed before. 0; -1 without memory,
 * with the reason in error. */
int cut_add(struct cut *cut, const lum_record *record, lum_error *error);

/* A line came, wanted or not. */
void cut_take_line(struct cut *cut, const lum_line *line, bool is_wanted);

/* No line comes any more. */
void cut_end(struct cut *cut);

/* The next packet to be written; its payload lives until cut_add(). False:
 * there is none yet. */
bool cut_next(struct cut *cut, lum_record *out);

#endif
