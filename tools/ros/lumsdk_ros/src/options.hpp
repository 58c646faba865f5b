// What the node's parameters say.
#ifndef LUMSDK_ROS_OPTIONS_HPP
#define LUMSDK_ROS_OPTIONS_HPP

#include "lum.hpp"

#include <ros/node_handle.h>

#include <string>
#include <vector>

namespace lumsdk_ros
{

enum class SourceKind {
    sensor,
    capture,
    bag
};

struct Options {
    std::string source;
    SourceKind kind = SourceKind::capture;
    std::string interface_name;
    lum_endpoint endpoint = {0, LUM_PORT}; // of a live sensor
    bool has_sensor = false;               // one of several
    uint32_t sensor = 0;                   // its address
    std::string sensor_interface; // in the capture; empty: none was named
    uint16_t port = LUM_PORT;     // of sensors in the capture
    bool has_calibration = false; // by a parameter
    bool has_profile = false;     // likewise
    lum_calibration calibration = {};
    lum_layout layout = {};
    lum_selection selection = {};
    uint32_t smooth_window = 0; // 0, 1: none
    uint32_t smooth_order = 0;
    const lum_cancel *second_signal = nullptr; // ends a long laser off
    uint32_t lines = 0;      // of a frame, for the rings; 0: as the frames show
    bool shows_eyes = false; // a topic for each, too
    std::string frame_id;
    bool laser = false;
    bool commands = true;
    bool shifts_to_now = false; // stamps of a capture or a bag
    bool loops = false;
    double speed = 1.0;                // 0: as fast as it can be read
    std::vector<std::string> wait_for; // topics, until each has a subscriber
};

// Throws std::runtime_error with a sentence for a person.
Options read_options(const ros::NodeHandle &node);

// 10.42.0.37
std::string address_text(uint32_t address);

} // namespace lumsdk_ros

#endif
