// Where the eyes sit, as static transforms.
#ifndef LUMSDK_ROS_EYES_HPP
#define LUMSDK_ROS_EYES_HPP

#include "lum.hpp"

#include <geometry_msgs/TransformStamped.h>

#include <string>
#include <vector>

namespace lumsdk_ros
{

// From the sensor's frame to FRAME_blue and FRAME_green.
std::vector<geometry_msgs::TransformStamped> eye_transforms(
    const lum_calibration &calibration, const std::string &frame_id);

} // namespace lumsdk_ros

#endif
