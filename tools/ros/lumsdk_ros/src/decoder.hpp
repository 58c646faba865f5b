// Packets to clouds.
#ifndef LUMSDK_ROS_DECODER_HPP
#define LUMSDK_ROS_DECODER_HPP

#include "cloud.hpp"
#include "lum.hpp"
#include "options.hpp"

#include <functional>
#include <memory>

namespace lumsdk_ros
{

// What was decoded and lost since the node began.
struct DecoderCounts {
    lum_demux_counters demux = {};
    lum_point_losses losses = {};
    uint64_t under_way = 0; // what lines lack that were under way when the
                            // packets began or ended: counted as lost, and is
                            // not
    uint64_t pauses = 0;    // of the sensors
    uint64_t in_pauses = 0; // lines missing in them
    uint64_t breaks = 0;    // of demux.assembly.stray: they began again
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

    // As lum_framer_set_interface().
    void set_interface(const char *name);

    // Throws std::runtime_error where data of several sensors comes and none
    // was named.
    void take(const lum_record &record);

    // Frames that are open come out.
    void flush();

    // Until the end of the packets.
    const lum_demux *demux() const;

    // The end of the packets: what is open comes out, and others may follow.
    void finish();

    DecoderCounts counts() const;

  private:
    struct FreeFramer {
        void operator()(lum_framer *framer) const
        {
            lum_framer_free(framer);
        }
    };

    void begin();
    void take_event(lum_framer_event event);
    void take_frame(const lum_frame &frame);
    void add_lines(DecoderCounts &to) const;

    const Options options_;
    Output output_;
    std::unique_ptr<lum_framer, FreeFramer> framer_;
    CloudMaker maker_;
    Cloud cloud_;
    DecoderCounts counts_; // without those of the framer at work
};

} // namespace lumsdk_ros

#endif
