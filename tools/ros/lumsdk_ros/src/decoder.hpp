// Packets to clouds.
#ifndef LUMSDK_ROS_DECODER_HPP
#define LUMSDK_ROS_DECODER_HPP

#include "cloud.hpp"
#include "lum.hpp"
#include "options.hpp"
#include "time_map.hpp"

#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace lumsdk_ros
{

// What was decoded and lost since the node began.
struct DecoderCounts {
    lum_demux_counters demux = {};
    lum_point_losses losses = {};
    uint64_t joined = 0; // what lines lack that were under way when the
                         // packets began: counted as lost, and is not
    uint64_t clouds = 0;
    uint64_t points = 0;
    uint64_t left_out = 0; // points of lines behind their cloud
    uint32_t lines = 0;    // what the green eye's rings are above the blue's
};

class Decoder
{
  public:
    using Output = std::function<void(const Cloud &)>;

    // Throws std::runtime_error.
    Decoder(const Options &options, Output output);

    // Throws std::runtime_error where data of several sensors comes and none
    // was named.
    void take(const lum_record &record);

    // The end of the packets: what is open comes out, and others may follow.
    void finish();

    DecoderCounts counts() const;

  private:
    struct FreeDemux {
        void operator()(lum_demux *demux) const
        {
            lum_demux_free(demux);
        }
    };

    void begin();
    void take_event(lum_result event);
    void take_line(const lum_line &line);
    void note_joined(const lum_line &line);
    size_t compute(const lum_line &line);
    Frame &frame_of(int64_t number);
    void end_frames(int64_t last);
    void end_frame();

    const Options options_;
    Output output_;
    lum_projector projector_ = {};
    std::unique_ptr<lum_demux, FreeDemux> demux_;
    std::vector<lum_sample> samples_;
    std::vector<lum_return> returns_;
    lum_sample_workspace workspace_ = {};
    lum_angle angles_[LUM_LINE_PIXELS] = {}; // smoothed
    TimeMap times_;
    bool has_clock_ = true;
    std::map<int64_t, Frame> frames_;
    Frame spare_; // keeps the memory of the frame before
    Cloud cloud_;
    Rings rings_;
    bool has_joined_[LUM_EYES] = {}; // a line of the eye was handed out
    bool has_ended_ = false;         // a frame
    int64_t ended_ = 0;              // the highest of these
    DecoderCounts counts_; // without those of the demultiplexer at work
};

} // namespace lumsdk_ros

#endif
