/* Views that a caller asked for, once they are checked. */
#ifndef LUM_FRAME_VIEWS_H
#define LUM_FRAME_VIEWS_H

#include "lum/frame/framer.h"
#include "lum/smooth.h"

#include <stddef.h>
#include <stdint.h>

typedef struct lum_checked_view {
    lum_view asked;
    uint32_t window; /* of its smoothing; 0: none */
    lum_smooth smooth;
} lum_checked_view;

typedef struct lum_checked_views {
    lum_checked_view view[LUM_VIEWS_MAX];
    size_t count;
} lum_checked_views;

/* given: count views, each as large as its caller's version has it.
 * out: undefined on -1, with the reason in error. */
int lum_views_check(const lum_view *given, size_t count, lum_checked_views *out,
                    lum_error *error);

#endif
