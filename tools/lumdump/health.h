/* How a run goes, for outputs that are messages: what came, what was lost. */
#ifndef LUMDUMP_HEALTH_H
#define LUMDUMP_HEALTH_H

#include "convert.h"

/* Tell the outputs, if any is such, as of now; of a capture, as of its last
 * packet. */
enum pass_result health_tell(struct pass *pass, lum_error *error);

/* The same after each second of a capture, for the reader of standard output.
 */
enum pass_result health_tell_on_the_way(struct pass *pass, lum_error *error);

#endif
