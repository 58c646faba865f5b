/** @file
 * The messages of ROS 2 that a file of them has: their names and definitions,
 * and how they are written. Internal to cloud. */
#ifndef LUM_CLOUD_ROS_MESSAGES_H
#define LUM_CLOUD_ROS_MESSAGES_H

#include "buffer.h"
#include "extras.h"
#include "presets.h"

#include "lum/calibration.h"
#include "lum/cloud/writer.h"
#include "lum/pose.h"

/* --- CDR as ROS 2 has it in files and on the wire: plain CDR version 1
 * (XCDR1), little-endian. Numbers are aligned to their size, counted from
 * behind the four bytes that a message begins with --- */

/** A message in the making. */
typedef struct lum_cdr {
    lum_bytes *out; /**< what it is appended to */
    size_t base;    /**< from where alignment counts */
} lum_cdr;

/** Begin a message. */
lum_cdr lum_cdr_begin(lum_bytes *out);

/** Append a bool or a byte. */
void lum_cdr_put_u8(lum_cdr *cdr, uint8_t v);
/** Append a number of 16 bits. */
void lum_cdr_put_u16(lum_cdr *cdr, uint16_t v);
/** Append a number of 32 bits, or the length of a sequence. */
void lum_cdr_put_u32(lum_cdr *cdr, uint32_t v);
/** Append a double. */
void lum_cdr_put_f64(lum_cdr *cdr, double v);

/** Append bytes as they are; those of a sequence come behind its length. */
void lum_cdr_put_bytes(lum_cdr *cdr, const void *bytes, size_t n);

/** Append a string; its length counts the NUL that ends it. */
void lum_cdr_put_string(lum_cdr *cdr, const char *text);

/* --- Messages --- */

/** A channel of messages. */
typedef struct lum_ros_topic {
    const char *name;       /**< such as "/points" */
    const char *type;       /**< such as "sensor_msgs/msg/PointCloud2" */
    const char *definition; /**< of the type, and of those that it has */
    const char *qos;        /**< as rosbag2 writes offered_qos_profiles */
} lum_ros_topic;

/** The topics, in their order. */
enum {
    LUM_ROS_POINTS,
    LUM_ROS_TF_STATIC,
    LUM_ROS_DIAGNOSTICS,
    LUM_ROS_DATAGRAMS,
    LUM_ROS_TOPICS
};

/** Their descriptions. */
extern const lum_ros_topic lum_ros_topics[LUM_ROS_TOPICS];

/** Bytes of a point of a cloud, as the node for ROS 1 has it (docs/ros.md). */
#define LUM_ROS_POINT_BYTES 24u

/** Begin a sensor_msgs/msg/PointCloud2 of n points: all but its points and what
 * is behind them.
 * @param extras more fields of its points. */
lum_cdr lum_ros_begin_cloud(lum_bytes *out, int64_t stamp_ns,
                            const char *frame_id, uint32_t n,
                            const lum_extras *extras);

/** The same, of points with other fields. */
lum_cdr lum_ros_begin_preset(lum_bytes *out, int64_t stamp_ns,
                             const char *frame_id, uint32_t n,
                             const lum_preset *preset);

/** End it, once its points are there. */
void lum_ros_end_cloud(lum_cdr *cdr);

/** Bytes of the name of an eye's frame. */
#define LUM_ROS_CHILD_BYTES (LUM_MCAP_FRAME_ID_MAX + 8u)

/** A frame in another one; a frame and its child's. */
typedef struct lum_ros_transform {
    const char *frame_id; /**< the parent */
    const char *child;    /**< the frame itself */
    lum_pose pose;        /**< where the child is in it */
} lum_ros_transform;

/** A tf2_msgs/msg/TFMessage of transforms. */
void lum_ros_put_transforms(lum_bytes *out, int64_t stamp_ns,
                            const lum_ros_transform *transforms, size_t count);

/** Transforms from a sensor's frame to FRAME_blue and FRAME_green, LUM_EYES of
 * them. */
void lum_ros_find_mounts(const char *frame_id,
                         const lum_calibration *calibration,
                         char children[LUM_EYES][LUM_ROS_CHILD_BYTES],
                         lum_ros_transform *out);

/** A lumsdk_msgs/msg/Datagram (docs/formats.md). */
void lum_ros_put_datagram(lum_bytes *out, const lum_writer_datagram *datagram);

/** A diagnostic_msgs/msg/DiagnosticArray of one status. */
void lum_ros_put_status(lum_bytes *out, const lum_writer_status *status);

#endif
