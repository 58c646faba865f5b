#include "batcher.hpp"

#include <utility>

namespace lumsdk_ros
{

namespace
{

constexpr int64_t span_ns = 20000000;
constexpr uint64_t packets_max = 4096;
constexpr size_t bytes_max = size_t{1} << 20;

} // namespace

Batcher::Batcher(const lum_layout &layout, std::string frame_id, Output output)
    : layout_(layout), frame_id_(std::move(frame_id)),
      output_(std::move(output))
{
}

void Batcher::open(const Packet &packet)
{
    begin_ = end_;
    first_ns_ = packet.time_ns;
    sensor_ = packet.sensor;
    bytes_ = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        batch_[eye].reset(new Packets);
        batch_[eye]->header.stamp = ros_time(packet.time_ns);
        batch_[eye]->header.frame_id = frame_id_;
        batch_[eye]->eye = static_cast<uint8_t>(eye);
        batch_[eye]->sensor = packet.sensor;
        batch_[eye]->begin = begin_;
    }
}

bool Batcher::is_full(const Packet &packet) const
{
    const int64_t since_ns = packet.time_ns - first_ns_;
    return since_ns < 0 || since_ns >= span_ns ||
           end_ - begin_ >= packets_max || bytes_ + packet.len > bytes_max ||
           packet.sensor != sensor_;
}

void Batcher::add(const Packet &packet)
{
    if (packet.len > UINT16_MAX) {
        return; // no UDP payload
    }
    if (batch_[0] && is_full(packet)) {
        flush(false);
    }
    if (!batch_[0]) {
        open(packet);
    }
    lum_group group;
    const bool is_data = lum_packet_decode(&layout_, packet.bytes, packet.len,
                                           &group) == LUM_PACKET_DATA;
    Packets &to = *batch_[is_data ? group.eye : 0u];
    to.places.push_back(static_cast<uint16_t>(end_ - begin_));
    to.stamps.push_back(ros_time(packet.time_ns));
    to.lengths.push_back(static_cast<uint16_t>(packet.len));
    to.data.insert(to.data.end(), packet.bytes, packet.bytes + packet.len);
    bytes_ += packet.len;
    end_++;
}

void Batcher::flush(bool last)
{
    if (!batch_[0] && last) {
        open({nullptr, 0, first_ns_, sensor_});
    }
    if (!batch_[0]) {
        return;
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        batch_[eye]->end = end_;
        batch_[eye]->last = last;
        output_(eye, batch_[eye]);
        batch_[eye].reset(); // a subscriber of this process may keep it
    }
    end_ = last ? 0 : end_;
}

} // namespace lumsdk_ros
