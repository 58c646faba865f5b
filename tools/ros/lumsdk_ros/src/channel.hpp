// A bounded queue of packets between the thread that receives and the one that
// decodes: what does not fit is dropped and counted, and nobody waits.
#ifndef LUMSDK_ROS_CHANNEL_HPP
#define LUMSDK_ROS_CHANNEL_HPP

#include "lum.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <vector>

namespace lumsdk_ros
{

// What was taken at once.
struct Load {
    struct Item {
        size_t at; // in bytes
        size_t len;
        int64_t time_ns;
    };
    std::vector<Item> items;
    std::vector<uint8_t> bytes;
};

class Channel
{
  public:
    // Those that came together. Returns how many were dropped.
    size_t put(const lum_received *datagrams, size_t count);
    void close();

    // Swap an emptied load for all there is; waits at most so long. False: it
    // is closed, and nothing is left.
    bool take(Load &load, std::chrono::milliseconds patience);

  private:
    std::mutex lock_;
    std::condition_variable news_;
    Load load_;
    bool is_closed_ = false;
};

} // namespace lumsdk_ros

#endif
