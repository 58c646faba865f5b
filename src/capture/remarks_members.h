/** @file
 * How the sensors of a stream differ from the members that are wanted.
 * Internal to capture. */
#ifndef LUM_CAPTURE_REMARKS_MEMBERS_H
#define LUM_CAPTURE_REMARKS_MEMBERS_H

#include "lum/base/error.h"
#include "lum/capture/demux.h"

/** Say the n-th remark on the members.
 * @param n   from 0 on; becomes less by those that there are.
 * @param out set only if there is an n-th. */
bool lum_remarks_say_members(const lum_demux *demux, size_t *n, lum_error *out);

#endif
