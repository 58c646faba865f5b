/** @file
 * The points of a frame in order of time, as the node for ROS 1 gives them
 * (docs/ros.md): times from the earliest, rings instead of lines. Internal to
 * cloud. */
#ifndef LUM_CLOUD_ROS_POINTS_H
#define LUM_CLOUD_ROS_POINTS_H

#include "buffer.h"
#include "extras.h"
#include "presets.h"

#include "lum/cloud/writer.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Those of one eye. */
typedef struct lum_ros_eye {
    lum_bytes kept;   /**< its points, as ros_points.c keeps them */
    size_t count;     /**< how many */
    float last_s;     /**< the time of the last one */
    bool is_unsorted; /**< one is earlier than the one before */
    size_t to_come;   /**< how many are foreseen and were not added yet */
    float first_s;    /**< the time of the first of these */
} lum_ros_eye;

/** A frame's; all 0 is none. */
typedef struct lum_ros_points {
    lum_ros_eye eyes[LUM_EYES]; /**< by ::lum_eye */
    lum_bytes spare;            /**< room for sorting */
    size_t taken[LUM_EYES];     /**< of those kept: written already */
    uint32_t lines;             /**< the green eye's rings are as many above
                                     the blue's; 0: not one frame yet */
    bool lines_are_stated;      /**< they stay as they are */
    bool has_line[2];           /**< whether there is one of these: */
    uint32_t highest[2];        /**< the second highest line, the highest */
    const lum_extras *extras;   /**< of each point, behind the others; NULL:
                                     none */
    const lum_preset *preset;   /**< its fields instead of all; NULL: none */
} lum_ros_points;

/** Free what it holds. */
void lum_ros_points_free(lum_ros_points *points);

/** Add a line's points.
 * @param from_s its time, in seconds from the beginning of the frame, for all
 *               points where the line has no times.
 * @return 0; -1: no memory. */
LUM_MUST_CHECK int lum_ros_points_add(lum_ros_points *points,
                                      const lum_line_samples *line,
                                      float from_s);

/** How many there are. */
size_t lum_ros_points_count(const lum_ros_points *points);

/** Bring them into order.
 * @param first_s gets the time of the first, 0 without points.
 * @return 0; -1: no memory. */
LUM_MUST_CHECK int lum_ros_points_sort(lum_ros_points *points, float *first_s);

/** Bytes of a point of a message. */
size_t lum_ros_points_bytes(const lum_ros_points *points);

/** Most points of a message. */
size_t lum_ros_points_max(const lum_ros_points *points);

/** Write them, lum_ros_points_bytes() each, and have none for the next frame.
 * lum_ros_points_sort() came before. */
void lum_ros_points_take(lum_ros_points *points, float first_s,
                         unsigned char *out);

/** Say which points will come: those of a line that is added later. First all
 * lines of a frame are foreseen, then the same are added. */
void lum_ros_points_foresee(lum_ros_points *points,
                            const lum_line_samples *line);

/** Whether points are foreseen, not too many, and come in order, each eye's, so
 * that lum_ros_points_merge() can write them while they are added; no, if one
 * line had no times. If not, they are as if not foreseen.
 * @param count   gets how many there will be.
 * @param first_s gets the time of the first. */
bool lum_ros_points_can_merge(lum_ros_points *points, size_t *count,
                              float *first_s);

/** How many of an eye are foreseen and were not added yet. */
size_t lum_ros_points_to_come(const lum_ros_points *points, unsigned eye);

/** Write those that no later one comes before; with the last line all of them.
 * There was no call of lum_ros_points_sort().
 * @return the end of them. */
unsigned char *lum_ros_points_merge(lum_ros_points *points, float first_s,
                                    unsigned char *out);

/** All that were foreseen are written; have none for the next frame. */
void lum_ros_points_end_merge(lum_ros_points *points);

/** The points of a line, those of one eye that follow each other. */
typedef struct lum_ros_line {
    unsigned eye;  /**< an ::lum_eye */
    size_t count;  /**< how many; 0: no line is left */
    float first_s; /**< the time of the first */
} lum_ros_line;

/** The line that begins next, instead of lum_ros_points_take() as often as
 * there is one. With the last one gone there are no points for the next frame.
 * lum_ros_points_sort() came before. */
lum_ros_line lum_ros_points_next_line(lum_ros_points *points);

/** Write its points, lum_ros_points_bytes() each. */
void lum_ros_points_take_line(lum_ros_points *points, const lum_ros_line *line,
                              unsigned char *out);

#endif
