/** @file
 * Pictures as PNG: a format for lum/cloud/writer.h. It needs cairo, so it is a
 * separate library. */
#ifndef LUM_PICTURE_PICTURE_H
#define LUM_PICTURE_PICTURE_H

#include "lum/cloud/writer.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The format, for lum_writer_options.picture.
 * @return the same at each call, never NULL. Thread-safe. */
const lum_format_ops *lum_picture_format(void);

#ifdef __cplusplus
}
#endif

#endif
