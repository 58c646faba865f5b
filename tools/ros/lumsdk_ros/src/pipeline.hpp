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
        : outlet_(outlet), layout_(options.layout),
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

    // What is no packet of a sensor, but counts.
    void take_other(const lum_record &record)
    {
        decoder_.take(record);
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

    const lum_layout &layout() const
    {
        return layout_;
    }

  private:
    const Outlet &outlet_;
    const lum_layout layout_;
    Decoder decoder_;
    Batcher batcher_;
    uint64_t packets_ = 0;
    uint64_t bytes_ = 0;

    mutable std::mutex lock_; // guards what follows
    PipelineView view_;
};

} // namespace lumsdk_ros

#endif
