/** @file
 * Pictures as PNG: a format for lum/cloud/writer.h. It needs cairo, so it is a
 * separate library. */
#ifndef LUM_PICTURE_PICTURE_H
#define LUM_PICTURE_PICTURE_H

#include "lum/cloud/writer.h"
#include "lum/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What colours mean. */
typedef enum lum_picture_colour {
    LUM_PICTURE_RANGE,       /**< metres from the eye, logarithmically */
    LUM_PICTURE_HEIGHT,      /**< z, metres */
    LUM_PICTURE_PULSE_WIDTH, /**< nanoseconds */
    LUM_PICTURE_LABEL        /**< whole numbers of the column "label", one of
                                  lum_writer_options.extra; each number has a
                                  colour */
} lum_picture_colour;

/** Least and most pixels of a picture, each way. */
#define LUM_PICTURE_SIDE_MIN 640u
#define LUM_PICTURE_SIDE_MAX 8000u /**< see above */

/** How a picture is drawn. All bytes 0 except struct_size are the defaults. */
typedef struct lum_picture_options {
    size_t struct_size;        /**< sizeof(lum_picture_options) */
    lum_picture_colour colour; /**< of points */
    uint32_t width;            /**< pixels, LUM_PICTURE_SIDE_MIN to
                                    LUM_PICTURE_SIDE_MAX; 0: 1600 */
    uint32_t height;           /**< likewise; 0: 1200 */
    const char *title;         /**< where the points come from, such as the name
                                    of a file; NULL: nothing. Copied, and cut
                                    where it is too long; non-ASCII becomes ? */
    const char *note;          /**< which points they are, and how they were
                                    made; likewise */
    const lum_pose *pose;      /**< NULL, or where the sensor is in the frame of
                                    the points: the image of both eyes is drawn
                                    from there. Copied */
} lum_picture_options;

/** The format, for lum_writer_options.picture. Its title has the number of the
 * frame too, and its time if lum_writer_begin_frame() gave one after 1970.
 * @return the same at each call, never NULL. Thread-safe. */
const lum_format_ops *lum_picture_format(void);

#ifdef __cplusplus
}
#endif

#endif
