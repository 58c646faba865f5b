/** @file
 * Ends waits from another thread or a signal handler. One cancel may end the
 * waits of any number of sockets and sensors. */
#ifndef LUM_NET_CANCEL_H
#define LUM_NET_CANCEL_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A cancel. */
typedef struct lum_cancel lum_cancel;

/** Make one, not raised.
 * @param out   to be freed with lum_cancel_free().
 * @param error gets the message on failure: no memory, no descriptors.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_cancel_new(lum_cancel **out, lum_error *error);

/** Free it; nothing may wait on it. NULL is allowed. */
void lum_cancel_free(lum_cancel *cancel);

/** End all waits, those that begin later too, until lum_cancel_reset(). Safe in
 * a signal handler (not on Windows, where handlers are threads anyway) and in
 * any thread; keeps errno. NULL is allowed. */
void lum_cancel_raise(lum_cancel *cancel);

/** Whether it is raised; NULL never is. Any thread. */
bool lum_cancel_is_raised(const lum_cancel *cancel);

/** Lower it again. */
void lum_cancel_reset(lum_cancel *cancel);

#ifdef __cplusplus
}
#endif

#endif
