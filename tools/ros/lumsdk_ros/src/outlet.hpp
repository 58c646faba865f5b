// The topics that the node publishes.
#ifndef LUMSDK_ROS_OUTLET_HPP
#define LUMSDK_ROS_OUTLET_HPP

#include "cloud.hpp"
#include "options.hpp"

#include <lumsdk_ros/Packets.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

namespace lumsdk_ros
{

// Names of the raw topics, by eye, in the node's namespace.
extern const char *const raw_topics[LUM_EYES];

class Outlet
{
  public:
    Outlet(ros::NodeHandle node, const Options &options);

    void publish(const Cloud &cloud) const;
    void publish(unsigned eye, const PacketsPtr &packets) const;
    void answer(const std::string &text) const;

    // Whether each of the topics that the options name has a subscriber.
    bool has_audience() const;

  private:
    void publish(const ros::Publisher &to, const Cloud &cloud) const;

    const Options options_;
    ros::NodeHandle node_;
    ros::Publisher points_;
    ros::Publisher eyes_[LUM_EYES];
    ros::Publisher raw_[LUM_EYES];
    ros::Publisher answer_;
};

} // namespace lumsdk_ros

#endif
