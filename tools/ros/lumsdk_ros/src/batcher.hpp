// Packets to messages of the raw topics.
#ifndef LUMSDK_ROS_BATCHER_HPP
#define LUMSDK_ROS_BATCHER_HPP

#include "packet.hpp"

#include <lumsdk_ros/Packets.h>

#include <functional>
#include <string>

namespace lumsdk_ros
{

class Batcher
{
  public:
    // Gets the messages of both eyes, by turns.
    using Output = std::function<void(unsigned eye, const PacketsPtr &)>;

    Batcher(const lum_layout &layout, std::string frame_id, Output output);

    void add(const Packet &packet);

    // Show what there is; last: nothing will follow.
    void flush(bool last);

  private:
    void open(const Packet &packet);
    bool is_full(const Packet &packet) const;

    const lum_layout layout_;
    const std::string frame_id_;
    Output output_;
    PacketsPtr batch_[LUM_EYES];
    uint64_t begin_ = 0;
    uint64_t end_ = 0;
    uint32_t sensor_ = 0;
    int64_t first_ns_ = 0;
    size_t bytes_ = 0;
};

} // namespace lumsdk_ros

#endif
