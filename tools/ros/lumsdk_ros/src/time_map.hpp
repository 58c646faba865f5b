// The sensor's clock in UTC, from when its packets came.
#ifndef LUMSDK_ROS_TIME_MAP_HPP
#define LUMSDK_ROS_TIME_MAP_HPP

#include <cstdint>

namespace lumsdk_ros
{

// A packet is never early, and now and then one is hardly late: the smallest
// difference between arrival and clock of the last seconds is the best
// estimate of where the sensor's clock stands. Only what went through take()
// decides, so the same packets with the same times give the same answer.
class TimeMap
{
  public:
    // A line's clock and the arrival of its first packet. Returns what to add
    // to a clock now.
    int64_t take(int64_t clock_ns, int64_t arrival_ns);

  private:
    void begin(int64_t delay_ns, int64_t arrival_ns);

    bool has_any_ = false;
    bool has_before_ = false;
    int64_t began_ns_ = 0;  // of the present half of the window
    int64_t least_ns_ = 0;  // in it
    int64_t before_ns_ = 0; // least in the half before
};

} // namespace lumsdk_ros

#endif
