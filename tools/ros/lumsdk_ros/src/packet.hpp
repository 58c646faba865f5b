// A packet on its way through the node.
#ifndef LUMSDK_ROS_PACKET_HPP
#define LUMSDK_ROS_PACKET_HPP

#include "lum.hpp"

#include <ros/time.h>

#include <cstddef>
#include <cstdint>

namespace lumsdk_ros
{

// Which side a recorded packet was sent to does not matter to its decoding.
constexpr uint16_t client_port = 50000;

struct Packet {
    const uint8_t *bytes;
    size_t len;
    int64_t time_ns; // when it came, UTC
    uint32_t sensor; // who sent it
};

inline lum_record record_of(const Packet &packet)
{
    lum_record r = {};
    r.time_ns = packet.time_ns;
    r.payload = packet.bytes;
    r.len = packet.len;
    r.source = packet.sensor;
    r.source_port = LUM_PORT;
    r.destination_port = client_port;
    r.kind = LUM_RECORD_DATAGRAM;
    return r;
}

// Times before 1970 or after 2106 do not fit; clocks that were never set give
// the former.
inline ros::Time ros_time(int64_t ns)
{
    constexpr int64_t second = 1000000000;
    const int64_t most = int64_t{UINT32_MAX} * second;
    const int64_t kept = ns < 0 ? 0 : (ns > most ? most : ns);
    return ros::Time(static_cast<uint32_t>(kept / second),
                     static_cast<uint32_t>(kept % second));
}

} // namespace lumsdk_ros

#endif
