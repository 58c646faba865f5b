#include "time_map.hpp"

#include <algorithm>
#include <cstdlib>

namespace lumsdk_ros
{

namespace
{

constexpr int64_t second_ns = 1000000000;
constexpr int64_t half_ns = 5 * second_ns; // of the window

// A clock further away than this was set, or began anew.
constexpr int64_t reset_ns = second_ns;

} // namespace

void TimeMap::begin(int64_t delay_ns, int64_t arrival_ns)
{
    began_ns_ = arrival_ns;
    least_ns_ = delay_ns;
}

int64_t TimeMap::take(int64_t clock_ns, int64_t arrival_ns)
{
    const int64_t delay_ns = arrival_ns - clock_ns;
    if (!has_any_ || std::abs(delay_ns - least_ns_) > reset_ns ||
        arrival_ns < began_ns_ - reset_ns) {
        has_any_ = true;
        has_before_ = false;
        begin(delay_ns, arrival_ns);
    } else if (arrival_ns - began_ns_ >= half_ns) {
        has_before_ = true;
        before_ns_ = least_ns_;
        begin(delay_ns, arrival_ns);
    }
    least_ns_ = std::min(least_ns_, delay_ns);
    return has_before_ ? std::min(before_ns_, least_ns_) : least_ns_;
}

} // namespace lumsdk_ros
