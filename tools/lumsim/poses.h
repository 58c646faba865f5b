/* The true poses of a simulated sensor, as a TUM file: one at the begin of each
 * line, and one at the end. */
#ifndef LUMSIM_POSES_H
#define LUMSIM_POSES_H

#include "lum/base/error.h"
#include "lum/pose.h"

#include <stdint.h>

struct poses;

/* 0, or -1 with the reason in error. */
int poses_open(const char *path, struct poses **out, lum_error *error);

/* The next one. 0, or -1 with the reason in error. */
int poses_add(struct poses *poses, int64_t time_ns, const lum_pose *pose,
              lum_error *error);

/* 0, or -1 with the reason in error; then no file is left. */
int poses_close(struct poses *poses, lum_error *error);

/* Remove what was written. NULL is allowed. */
void poses_abort(struct poses *poses);

#endif
