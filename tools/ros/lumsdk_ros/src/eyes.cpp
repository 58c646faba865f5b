#include "eyes.hpp"

#include <ros/time.h>

#include <cmath>

namespace lumsdk_ros
{

namespace
{

constexpr double half_radian = 3.14159265358979323846 / 360.0;

// Rz(yaw) Ry(pitch) Rx(roll), as the calibration's mounts are.
geometry_msgs::Quaternion rotation(const lum_eye_calibration &c)
{
    const double roll = c.mount_roll_udeg * 1e-6 * half_radian;
    const double pitch = c.mount_pitch_udeg * 1e-6 * half_radian;
    const double yaw = c.mount_yaw_udeg * 1e-6 * half_radian;
    const double cr = std::cos(roll);
    const double sr = std::sin(roll);
    const double cp = std::cos(pitch);
    const double sp = std::sin(pitch);
    const double cy = std::cos(yaw);
    const double sy = std::sin(yaw);
    geometry_msgs::Quaternion q;
    q.w = cr * cp * cy + sr * sp * sy;
    q.x = sr * cp * cy - cr * sp * sy;
    q.y = cr * sp * cy + sr * cp * sy;
    q.z = cr * cp * sy - sr * sp * cy;
    return q;
}

} // namespace

std::vector<geometry_msgs::TransformStamped> eye_transforms(
    const lum_calibration &calibration, const std::string &frame_id)
{
    static const char *const names[LUM_EYES] = {"_blue", "_green"};
    std::vector<geometry_msgs::TransformStamped> transforms(LUM_EYES);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const lum_eye_calibration &c = calibration.eye[eye];
        geometry_msgs::TransformStamped &t = transforms[eye];
        t.header.stamp = ros::Time::now();
        t.header.frame_id = frame_id;
        t.child_frame_id = frame_id + names[eye];
        t.transform.translation.x = c.mount_um[0] * 1e-6;
        t.transform.translation.y = c.mount_um[1] * 1e-6;
        t.transform.translation.z = c.mount_um[2] * 1e-6;
        t.transform.rotation = rotation(c);
    }
    return transforms;
}

} // namespace lumsdk_ros
