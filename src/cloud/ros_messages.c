#include "ros_messages.h"

#include "le.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NS_PER_S INT64_C(1000000000)

/* --- CDR --- */

lum_cdr lum_cdr_begin(lum_bytes *out)
{
    static const unsigned char plain_le[4] = {0, 1, 0, 0};
    lum_bytes_put(out, plain_le, sizeof plain_le);
    return (lum_cdr){out, out->len};
}

/* Zeros up to a multiple of n. */
static void align(const lum_cdr *cdr, size_t n)
{
    static const unsigned char zeros[8] = {0};
    const size_t over = (cdr->out->len - cdr->base) % n;
    lum_bytes_put(cdr->out, zeros, over == 0 ? 0 : n - over);
}

void lum_cdr_put_u8(lum_cdr *cdr, uint8_t v)
{
    lum_bytes_put_u8(cdr->out, v);
}

void lum_cdr_put_u16(lum_cdr *cdr, uint16_t v)
{
    align(cdr, 2);
    lum_bytes_put_u16(cdr->out, v);
}

void lum_cdr_put_u32(lum_cdr *cdr, uint32_t v)
{
    align(cdr, 4);
    lum_bytes_put_u32(cdr->out, v);
}

void lum_cdr_put_f64(lum_cdr *cdr, double v)
{
    unsigned char number[8];
    align(cdr, 8);
    (void)lum_put_f64(number, v);
    lum_bytes_put(cdr->out, number, sizeof number);
}

void lum_cdr_put_bytes(lum_cdr *cdr, const void *bytes, size_t n)
{
    lum_bytes_put(cdr->out, bytes, n);
}

void lum_cdr_put_string(lum_cdr *cdr, const char *text)
{
    const size_t n = strlen(text) + 1u;
    lum_cdr_put_u32(cdr, (uint32_t)n);
    lum_bytes_put(cdr->out, text, n);
}

/* --- Definitions --- */

#define RULE                                                                   \
    "================================================================"         \
    "================\n"

#define TIME                                                                   \
    RULE "MSG: builtin_interfaces/Time\n"                                      \
         "int32 sec\n"                                                         \
         "uint32 nanosec\n"

#define HEADER                                                                 \
    RULE "MSG: std_msgs/Header\n"                                              \
         "builtin_interfaces/Time stamp\n"                                     \
         "string frame_id\n" TIME

static const char cloud_definition[] =
    "std_msgs/Header header\n"
    "uint32 height\n"
    "uint32 width\n"
    "PointField[] fields\n"
    "bool is_bigendian\n"
    "uint32 point_step\n"
    "uint32 row_step\n"
    "uint8[] data\n"
    "bool is_dense\n" RULE "MSG: sensor_msgs/PointField\n"
    "uint8 INT8=1\n"
    "uint8 UINT8=2\n"
    "uint8 INT16=3\n"
    "uint8 UINT16=4\n"
    "uint8 INT32=5\n"
    "uint8 UINT32=6\n"
    "uint8 FLOAT32=7\n"
    "uint8 FLOAT64=8\n"
    "string name\n"
    "uint32 offset\n"
    "uint8 datatype\n"
    "uint32 count\n" HEADER;

static const char tf_definition[] =
    "geometry_msgs/TransformStamped[] transforms\n" RULE
    "MSG: geometry_msgs/TransformStamped\n"
    "std_msgs/Header header\n"
    "string child_frame_id\n"
    "geometry_msgs/Transform transform\n" RULE "MSG: geometry_msgs/Transform\n"
    "geometry_msgs/Vector3 translation\n"
    "geometry_msgs/Quaternion rotation\n" RULE "MSG: geometry_msgs/Vector3\n"
    "float64 x\n"
    "float64 y\n"
    "float64 z\n" RULE "MSG: geometry_msgs/Quaternion\n"
    "float64 x 0\n"
    "float64 y 0\n"
    "float64 z 0\n"
    "float64 w 1\n" HEADER;

static const char diagnostics_definition[] =
    "std_msgs/Header header\n"
    "diagnostic_msgs/DiagnosticStatus[] status\n" RULE
    "MSG: diagnostic_msgs/DiagnosticStatus\n"
    "byte OK=0\n"
    "byte WARN=1\n"
    "byte ERROR=2\n"
    "byte STALE=3\n"
    "byte level\n"
    "string name\n"
    "string message\n"
    "string hardware_id\n"
    "diagnostic_msgs/KeyValue[] values\n" RULE "MSG: diagnostic_msgs/KeyValue\n"
    "string key\n"
    "string value\n" HEADER;

static const char datagram_definition[] =
    "# A UDP datagram as it came.\n"
    "builtin_interfaces/Time stamp\n"
    "uint8[4] source_address\n"
    "uint16 source_port\n"
    "uint8[4] destination_address\n"
    "uint16 destination_port\n"
    "# How many bytes were sent; data has fewer if it was cut short.\n"
    "uint32 length\n"
    "uint8[] data\n" TIME;

/* The last depth of reliable messages; durability 1 keeps them for readers that
 * come later, 2 does not. */
#define NEVER "\n    sec: 9223372036\n    nsec: 854775807\n"
#define QOS(depth, durability)                                                 \
    "- history: 1\n  depth: " depth                                            \
    "\n  reliability: 1\n  durability: " durability "\n  deadline:" NEVER      \
    "  lifespan:" NEVER "  liveliness: 1\n  liveliness_lease_duration:" NEVER  \
    "  avoid_ros_namespace_conventions: false\n"

const lum_ros_topic lum_ros_topics[LUM_ROS_TOPICS] = {
    [LUM_ROS_POINTS] = {"/points", "sensor_msgs/msg/PointCloud2",
                        cloud_definition, QOS("5", "2")},
    [LUM_ROS_TF_STATIC] = {"/tf_static", "tf2_msgs/msg/TFMessage",
                           tf_definition, QOS("1", "1")},
    [LUM_ROS_DIAGNOSTICS] = {"/diagnostics",
                             "diagnostic_msgs/msg/DiagnosticArray",
                             diagnostics_definition, QOS("10", "2")},
    [LUM_ROS_DATAGRAMS] = {"/datagrams", "lumsdk_msgs/msg/Datagram",
                           datagram_definition, QOS("1000", "2")}};

/* --- Their parts --- */

/* Seconds have 32 bits with sign; times before 1970 are none. */
static void put_time(lum_cdr *cdr, int64_t ns)
{
    const int64_t known = ns > 0 ? ns : 0;
    const int64_t s = known / NS_PER_S;
    lum_cdr_put_u32(cdr, (uint32_t)(s < INT32_MAX ? s : INT32_MAX));
    lum_cdr_put_u32(cdr, (uint32_t)(known % NS_PER_S));
}

static void put_header(lum_cdr *cdr, int64_t stamp_ns, const char *frame_id)
{
    put_time(cdr, stamp_ns);
    lum_cdr_put_string(cdr, frame_id);
}

/* --- Clouds --- */

static void put_field(lum_cdr *cdr, const char *name, size_t offset,
                      unsigned type)
{
    lum_cdr_put_string(cdr, name);
    lum_cdr_put_u32(cdr, (uint32_t)offset);
    lum_cdr_put_u8(cdr, lum_number_types[type].ros);
    lum_cdr_put_u32(cdr, 1); /* count */
}

static lum_cdr begin_cloud(lum_bytes *out, int64_t stamp_ns,
                           const char *frame_id, uint32_t n,
                           const lum_preset *preset, const lum_extras *extras)
{
    size_t at = lum_preset_bytes(preset);
    lum_cdr cdr = lum_cdr_begin(out);
    put_header(&cdr, stamp_ns, frame_id);
    lum_cdr_put_u32(&cdr, 1); /* height */
    lum_cdr_put_u32(&cdr, n);
    lum_cdr_put_u32(&cdr, (uint32_t)preset->count + extras->count);
    for (unsigned i = 0; i < preset->count; i++) {
        put_field(&cdr, preset->fields[i].name, lum_preset_offset(preset, i),
                  preset->fields[i].type);
    }
    for (unsigned i = 0; i < extras->count; i++) {
        put_field(&cdr, extras->name[i], at, extras->type[i]);
        at += lum_number_types[extras->type[i]].bytes;
    }
    lum_cdr_put_u8(&cdr, 0); /* is_bigendian */
    lum_cdr_put_u32(&cdr, (uint32_t)at);
    lum_cdr_put_u32(&cdr, (uint32_t)at * n);
    lum_cdr_put_u32(&cdr, (uint32_t)at * n);
    return cdr;
}

lum_cdr lum_ros_begin_preset(lum_bytes *out, int64_t stamp_ns,
                             const char *frame_id, uint32_t n,
                             const lum_preset *preset)
{
    static const lum_extras none;
    return begin_cloud(out, stamp_ns, frame_id, n, preset, &none);
}

lum_cdr lum_ros_begin_cloud(lum_bytes *out, int64_t stamp_ns,
                            const char *frame_id, uint32_t n,
                            const lum_extras *extras)
{
    return begin_cloud(out, stamp_ns, frame_id, n, &lum_preset_of_messages,
                       extras);
}

void lum_ros_end_cloud(lum_cdr *cdr)
{
    lum_cdr_put_u8(cdr, 1); /* is_dense */
}

/* --- Transforms --- */

void lum_ros_put_transforms(lum_bytes *out, int64_t stamp_ns,
                            const lum_ros_transform *transforms, size_t count)
{
    lum_cdr cdr = lum_cdr_begin(out);
    lum_cdr_put_u32(&cdr, (uint32_t)count);
    for (size_t i = 0; i < count; i++) {
        const lum_ros_transform *t = &transforms[i];
        put_header(&cdr, stamp_ns, t->frame_id);
        lum_cdr_put_string(&cdr, t->child);
        for (unsigned k = 0; k < 3u; k++) {
            lum_cdr_put_f64(&cdr, t->pose.at[k]);
        }
        for (unsigned k = 0; k < 4u; k++) {
            lum_cdr_put_f64(&cdr, t->pose.turn[k]);
        }
    }
}

/* Rz(yaw) Ry(pitch) Rx(roll), as the calibration's mounts are. */
static lum_pose pose_of_eye(const lum_eye_calibration *c)
{
    const double half_radian = 3.14159265358979323846 / 360.0;
    const double roll = c->mount_roll_udeg * 1e-6 * half_radian;
    const double pitch = c->mount_pitch_udeg * 1e-6 * half_radian;
    const double yaw = c->mount_yaw_udeg * 1e-6 * half_radian;
    const double cr = cos(roll);
    const double sr = sin(roll);
    const double cp = cos(pitch);
    const double sp = sin(pitch);
    const double cy = cos(yaw);
    const double sy = sin(yaw);
    return (lum_pose){
        {c->mount_um[0] * 1e-6, c->mount_um[1] * 1e-6, c->mount_um[2] * 1e-6},
        {sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
         cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy}};
}

void lum_ros_find_mounts(const char *frame_id,
                         const lum_calibration *calibration,
                         char children[LUM_EYES][LUM_ROS_CHILD_BYTES],
                         lum_ros_transform *out)
{
    static const char *const eyes[LUM_EYES] = {"blue", "green"};
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        (void)snprintf(children[eye], LUM_ROS_CHILD_BYTES, "%s_%s", frame_id,
                       eyes[eye]);
        out[eye] = (lum_ros_transform){frame_id, children[eye],
                                       pose_of_eye(&calibration->eye[eye])};
    }
}

/* --- Datagrams --- */

static void put_address(lum_cdr *cdr, uint32_t address)
{
    for (unsigned i = 0; i < 4u; i++) {
        lum_cdr_put_u8(cdr, (uint8_t)(address >> (24u - 8u * i)));
    }
}

void lum_ros_put_datagram(lum_bytes *out, const lum_writer_datagram *datagram)
{
    lum_cdr cdr = lum_cdr_begin(out);
    put_time(&cdr, datagram->time_ns);
    put_address(&cdr, datagram->source);
    lum_cdr_put_u16(&cdr, datagram->source_port);
    put_address(&cdr, datagram->destination);
    lum_cdr_put_u16(&cdr, datagram->destination_port);
    lum_cdr_put_u32(&cdr, (uint32_t)datagram->len); /* as it was sent */
    lum_cdr_put_u32(&cdr, (uint32_t)datagram->len);
    lum_cdr_put_bytes(&cdr, datagram->payload, datagram->len);
}

/* --- Status --- */

void lum_ros_put_status(lum_bytes *out, const lum_writer_status *status)
{
    lum_cdr cdr = lum_cdr_begin(out);
    put_header(&cdr, status->time_ns, "");
    lum_cdr_put_u32(&cdr, 1);
    lum_cdr_put_u8(&cdr, (uint8_t)status->level);
    lum_cdr_put_string(&cdr, status->name);
    lum_cdr_put_string(&cdr, status->message);
    lum_cdr_put_string(&cdr, status->hardware_id);
    lum_cdr_put_u32(&cdr, (uint32_t)status->count);
    for (size_t i = 0; i < status->count; i++) {
        lum_cdr_put_string(&cdr, status->values[i].key);
        lum_cdr_put_string(&cdr, status->values[i].value);
    }
}
