/** @file
 * Words of a line that give no point (docs/protocol.md, section 7). */
#ifndef LUM_POINT_LOSSES_H
#define LUM_POINT_LOSSES_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Words that gave no point. */
typedef struct lum_point_losses {
    uint64_t no_angle; /**< their pixel has no angles */
    uint64_t no_range; /**< their range is not above zero */
} lum_point_losses;

#ifdef __cplusplus
}
#endif

#endif
