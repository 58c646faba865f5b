// Packets of whatever source, to clouds and raw messages; and what came of
// them, for others.
#ifndef LUMSDK_ROS_PIPELINE_HPP
#define LUMSDK_ROS_PIPELINE_HPP

#include "batcher.hpp"
#include "decoder.hpp"
#include "outlet.hpp"

#include <mutex>

namespace lumsdk_ros
{

struct PipelineView {
    DecoderCounts decoder;
    uint64_t packets = 0; // of the sensor, and their bytes
    uint64_t bytes = 0;
};

// One thread's, but for view().
class Pipeline
{
  public:
    Pipeline(const Options &options, const Outlet &outlet)
        : outlet_(outlet), layout_(options.layout), port_(options.port),
          decoder_(options, [this](const Cloud &c) { outlet_.publish(c); }),
          batcher_(options.layout, options.frame_id,
                   [this](unsigned eye, const PacketsPtr &packets) {
                       outlet_.publish(eye, packets);
                   })
    {
    }

    // What a sensor sent.
    void take(const Packet &packet)
    {
        packets_++;
        bytes_ += packet.len;
        batcher_.add(packet);
        decoder_.take(record_of(packet));
    }

    // What came from a raw topic.
    void take_again(const Packet &packet)
    {
        packets_++;
        bytes_ += packet.len;
        decoder_.take(record_of(packet));
    }

    // A record of a capture; only what its sensor sent is batched.
    void take(const lum_record &record, const char *interface_name)
    {
        decoder_.set_interface(interface_name);
        decoder_.take(record);
        if (is_of_sensor(record)) {
            const Packet packet = {record.payload, record.len, record.time_ns,
                                   sensor_of(record)};
            packets_++;
            bytes_ += packet.len;
            batcher_.add(packet);
        }
    }

    // What came of the packets, all of them decoded; until finish().
    const lum_demux *end()
    {
        decoder_.flush();
        return decoder_.demux();
    }

    // Show what waits for its batch to be full.
    void flush()
    {
        batcher_.flush(false);
    }

    // Nothing follows that belongs to what came.
    void finish(bool shows_packets)
    {
        decoder_.finish();
        if (shows_packets) {
            batcher_.flush(true);
        }
        make_view();
    }

    void make_view()
    {
        const std::lock_guard<std::mutex> guard(lock_);
        view_.decoder = decoder_.counts();
        view_.packets = packets_;
        view_.bytes = bytes_;
    }

    PipelineView view() const
    {
        const std::lock_guard<std::mutex> guard(lock_);
        return view_;
    }

  private:
    bool is_from_sensor(const lum_record &r) const
    {
        return r.source_port == port_;
    }

    // As the demultiplexer finds it: data is a sensor's to whatever side it
    // went, all else what it sent.
    bool is_of_sensor(const lum_record &r) const
    {
        lum_group group;
        return lum_record_is_datagram(&r) &&
               (is_from_sensor(r) ||
                (r.destination_port == port_ &&
                 lum_packet_decode(&layout_, r.payload, r.len, &group) ==
                     LUM_PACKET_DATA)) &&
               lum_demux_is_wanted(decoder_.demux());
    }

    uint32_t sensor_of(const lum_record &r) const
    {
        return is_from_sensor(r) ? r.source : r.destination;
    }

    const Outlet &outlet_;
    const lum_layout layout_;
    const uint16_t port_;
    Decoder decoder_;
    Batcher batcher_;
    uint64_t packets_ = 0;
    uint64_t bytes_ = 0;

    mutable std::mutex lock_; // guards what follows
    PipelineView view_;
};

} // namespace lumsdk_ros

#endif
