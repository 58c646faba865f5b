/** @file
 * Pictures as PNG: a format of lum/cloud/writer.h that needs cairo, so a room
 * of its own. */
#ifndef LUM_PICTURE_PICTURE_H
#define LUM_PICTURE_PICTURE_H

#include "lum/cloud/writer.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What draws: for lum_writer_options.picture.
 * @return the same at each call, never NULL. Thread-safe. */
const lum_format_ops *lum_picture_format(void);

#ifdef __cplusplus
}
#endif

#endif
