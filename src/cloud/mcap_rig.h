/** @file
 * The sensors of an MCAP file: their topics, their frames, and how these lie in
 * each other. Internal to cloud. */
#ifndef LUM_CLOUD_MCAP_RIG_H
#define LUM_CLOUD_MCAP_RIG_H

#include "buffer.h"
#include "mcap_file.h"

#include "lum/base/error.h"
#include "lum/cloud/writer.h"

/** One of them. */
typedef struct lum_mcap_rig_sensor {
    const char *topic;                         /**< of its clouds */
    char frame_id[LUM_MCAP_FRAME_ID_MAX + 1u]; /**< of its messages */
    bool has_pose;                             /**< whether this is known: */
    lum_pose pose;                             /**< in the rig's frame */
    bool has_mounts;             /**< whether those of this are wanted: */
    lum_calibration calibration; /**< of its eyes */
    unsigned channel;            /**< of its clouds */
    uint32_t lines;              /**< for rings, as of lum_ros_points */
} lum_mcap_rig_sensor;

/** All of them; one if the options name none. */
typedef struct lum_mcap_rig {
    char frame_id[LUM_MCAP_FRAME_ID_MAX + 1u];         /**< that they are in */
    size_t count;                                      /**< at least 1 */
    lum_mcap_rig_sensor sensors[LUM_MCAP_SENSORS_MAX]; /**< count of them */
} lum_mcap_rig;

/** Take what options say of them.
 * @param name the file's, for messages.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_mcap_rig_take(lum_mcap_rig *out, const char *name,
                                     const lum_mcap_options *options,
                                     lum_error *error);

/** Attach the files of calibrations and profiles that options have. */
LUM_MUST_CHECK int lum_mcap_rig_attach(lum_mcap_file *file,
                                       const lum_mcap_options *options,
                                       lum_error *error);

/** Whether anything is known of how the frames lie. */
bool lum_mcap_rig_has_transforms(const lum_mcap_rig *rig);

/** Write that as a tf2_msgs/msg/TFMessage. */
void lum_mcap_rig_put_transforms(const lum_mcap_rig *rig, int64_t stamp_ns,
                                 lum_bytes *out);

#endif
