/** @file
 * Asking the caller of long work whether it is to go on. Internal. */
#ifndef LUM_BASE_GO_ON_H
#define LUM_BASE_GO_ON_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stdint.h>

/** The longest wait between two questions. */
#define LUM_GO_ON_WAIT_MS 50

/** What is asked. All bytes 0: nobody, and the work goes on. */
typedef struct lum_go_on {
    bool (*function)(void *context);
    void *context;
    int64_t next_ns; /**< when to ask again, on the monotonic clock */
    bool has_stopped;
} lum_go_on;

/** Whether to go on. The caller is asked if some milliseconds have passed since
 * it was last asked; once it has said no, it is not asked any more.
 * @param go_on NULL: nobody is asked. */
LUM_MUST_CHECK bool lum_go_on_ask(lum_go_on *go_on);

/** The message of work that was ended so.
 * @return -1. */
int lum_go_on_fail(lum_error *error);

#endif
