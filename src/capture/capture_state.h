/** @file
 * The place in a capture, to go on from it later. Internal. */
#ifndef LUM_CAPTURE_CAPTURE_STATE_H
#define LUM_CAPTURE_CAPTURE_STATE_H

#include "base/pack.h"
#include "lum/capture/capture.h"

/** Whether lum_capture_pack() is possible: it is one source, not compressed,
 * that can be read from any place. */
bool lum_capture_can_seek(const lum_capture *capture);

/** The place of the next record, with all that is needed to read it, in either
 * direction. Bytes that are read must be of this capture.
 * @return 0; -1 with the reason in error, which is empty if the bytes mean
 *         nothing: then only another place can be read. */
LUM_MUST_CHECK int lum_capture_pack(lum_capture *capture, lum_pack *pack,
                                    lum_error *error);

#endif
