#include "decoder.hpp"

#include <ros/console.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <new>
#include <stdexcept>
#include <utility>

namespace lumsdk_ros
{

namespace
{

// Beyond this many the lowest is finished, whatever may still come for it.
constexpr size_t open_frames_max = 8;

// All of it are counters of 64 bits.
void add(lum_demux_counters &to, const lum_demux_counters &from)
{
    uint64_t a[sizeof to / sizeof(uint64_t)];
    uint64_t b[sizeof from / sizeof(uint64_t)];
    static_assert(sizeof a == sizeof to, "counters of 64 bits alone");
    std::memcpy(a, &to, sizeof a);
    std::memcpy(b, &from, sizeof b);
    for (size_t i = 0; i < sizeof a / sizeof *a; i++) {
        a[i] += b[i];
    }
    std::memcpy(&to, a, sizeof a);
}

} // namespace

Decoder::Decoder(const Options &options, Output output)
    : options_(options), output_(std::move(output)), rings_(options.lines)
{
    if (lum_projector_init(&projector_, &options_.calibration,
                           &options_.layout) != LUM_OK) {
        throw std::runtime_error("~calibration cannot be used");
    }
    has_clock_ = options_.layout.profile.group[LUM_FIELD_TIMESTAMP].bytes != 0;
    begin();
}

void Decoder::begin()
{
    lum_demux_options o = {};
    o.layout = options_.layout;
    o.has_sensor = options_.has_sensor;
    o.sensor = options_.sensor;
    lum_assembler_config_default(&o.config);
    demux_.reset(lum_demux_new(&o));
    if (!demux_) {
        throw std::bad_alloc();
    }
    samples_.resize(o.config.words_per_line);
    returns_.resize(o.config.words_per_line);
    workspace_.returns = returns_.data();
    has_ended_ = false;
    std::fill(std::begin(has_joined_), std::end(has_joined_), false);
}

void Decoder::take(const lum_record &record)
{
    lum_result r = LUM_OK;
    while ((r = lum_demux_push(demux_.get(), &record, nullptr)) > 0) {
        take_event(r);
    }
    if (r != LUM_OK) {
        throw std::bad_alloc();
    }
    if (!options_.has_sensor && lum_demux_sensor_count(demux_.get()) > 1) {
        throw std::runtime_error(
            "data of several sensors: ~sensor has to name one");
    }
}

void Decoder::take_event(lum_result event)
{
    const lum_assembler *assembler = lum_demux_current(demux_.get());
    if (event == LUM_LINE_READY) {
        take_line(*lum_assembler_line(assembler));
    } else {
        end_frames(lum_assembler_frame(assembler));
    }
}

size_t Decoder::compute(const lum_line &line)
{
    lum_line smoothed = line;
    if (options_.smooths) {
        lum_smooth_line(&options_.smooth, &line, angles_);
        smoothed.angles = angles_;
    }
    return lum_samples_compute(&projector_, &smoothed, &options_.selection,
                               &workspace_, samples_.data(), &counts_.losses);
}

// The first line of an eye was under way when the packets began, as far as it
// lacks anything.
void Decoder::note_joined(const lum_line &line)
{
    if (!has_joined_[line.eye]) {
        has_joined_[line.eye] = true;
        counts_.joined += line.lost_words;
        counts_.joined += line.angle_count < LUM_LINE_PIXELS ? 1 : 0;
    }
}

void Decoder::take_line(const lum_line &line)
{
    note_joined(line);
    const size_t count = compute(line);
    const int64_t clock_ns = has_clock_ ? line.clock_us * 1000 : line.arrival;
    const int64_t offset_ns = times_.take(clock_ns, line.arrival);
    if (has_ended_ && line.frame <= ended_) {
        counts_.left_out += count;
        return;
    }
    counts_.left_out +=
        frame_of(line.frame)
            .add(line, samples_.data(), count, clock_ns, offset_ns);
    if (frames_.size() > open_frames_max) {
        end_frame();
    }
}

Frame &Decoder::frame_of(int64_t number)
{
    const auto found = frames_.find(number);
    if (found != frames_.end()) {
        return found->second;
    }
    spare_.clear();
    Frame &frame = frames_[number] = std::move(spare_);
    spare_ = Frame();
    return frame;
}

void Decoder::end_frames(int64_t last)
{
    while (!frames_.empty() && frames_.begin()->first <= last) {
        end_frame();
    }
    ended_ = has_ended_ ? std::max(ended_, last) : last;
    has_ended_ = true;
}

// The lowest one.
void Decoder::end_frame()
{
    const auto lowest = frames_.begin();
    cloud_.frame = lowest->first;
    if (lowest->second.finish(rings_, cloud_)) {
        ROS_WARN("frames have more lines than those before: rings of the green "
                 "eye begin at %u from here on; ~lines states where",
                 static_cast<unsigned>(rings_.lines()));
    }
    if (cloud_.ringless != 0) {
        ROS_WARN_THROTTLE(10.0,
                          "%zu points are of lines beyond %u: their ring is %u",
                          cloud_.ringless, static_cast<unsigned>(cloud_.lines),
                          static_cast<unsigned>(Rings::none));
    }
    has_ended_ = true;
    ended_ = lowest->first;
    spare_ = std::move(lowest->second);
    (void)frames_.erase(lowest);
    counts_.clouds++;
    counts_.points += cloud_.points.size();
    output_(cloud_);
}

void Decoder::finish()
{
    lum_demux_counters total;
    lum_result r = LUM_OK;
    while ((r = lum_demux_flush(demux_.get())) > 0) {
        take_event(r);
    }
    while (!frames_.empty()) {
        end_frame();
    }
    lum_demux_total(demux_.get(), &total);
    add(counts_.demux, total);
    begin();
}

DecoderCounts Decoder::counts() const
{
    DecoderCounts counts = counts_;
    counts.lines = rings_.lines();
    lum_demux_counters total;
    lum_demux_total(demux_.get(), &total);
    add(counts.demux, total);
    return counts;
}

} // namespace lumsdk_ros
