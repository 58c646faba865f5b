#include "decoder.hpp"

#include <ros/console.h>

#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

namespace lumsdk_ros
{

namespace
{

// More than both eyes can have in a frame of 640 lines, all returns counted.
constexpr uint32_t points_max = uint32_t{1} << 24;

// All of it but struct_size are counters of 64 bits.
void add(lum_demux_counters &to, const lum_demux_counters &from)
{
    constexpr size_t first = offsetof(lum_demux_counters, packets);
    uint64_t a[(sizeof to - first) / sizeof(uint64_t)];
    uint64_t b[(sizeof from - first) / sizeof(uint64_t)];
    static_assert(first + sizeof a == sizeof to, "counters of 64 bits alone");
    std::memcpy(a, reinterpret_cast<const char *>(&to) + first, sizeof a);
    std::memcpy(b, reinterpret_cast<const char *>(&from) + first, sizeof b);
    for (size_t i = 0; i < sizeof a / sizeof *a; i++) {
        a[i] += b[i];
    }
    std::memcpy(reinterpret_cast<char *>(&to) + first, a, sizeof a);
}

} // namespace

Decoder::Decoder(const Options &options, Output output)
    : options_(options), output_(std::move(output)), maker_(options.lines)
{
    begin();
}

void Decoder::begin()
{
    lum_view view;
    lum_view_default(&view);
    view.selection = options_.selection;
    view.smooth_window = options_.smooth_window;
    view.smooth_order = options_.smooth_order;
    view.columns = cloud_columns;
    lum_framer_options o = {};
    o.struct_size = sizeof o;
    o.layout = &options_.layout;
    o.calibration = &options_.calibration;
    o.views = &view;
    o.view_count = 1;
    o.has_sensor = options_.has_sensor;
    o.sensor = options_.sensor;
    o.port = options_.port;
    o.sensor_interface = options_.sensor_interface.empty()
                             ? nullptr
                             : options_.sensor_interface.c_str();
    o.points_max = points_max;
    o.records_are_single = true;
    lum_framer *framer = nullptr;
    lum_error error = {""};
    if (lum_framer_new(&o, &framer, &error) != 0) {
        throw std::runtime_error(error.text);
    }
    framer_.reset(framer);
}

void Decoder::set_interface(const char *name)
{
    lum_framer_set_interface(framer_.get(), name);
}

void Decoder::take(const lum_record &record)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_push(framer_.get(), &record, nullptr)) !=
           LUM_FRAMER_NONE) {
        take_event(event);
    }
    if (!options_.has_sensor && lum_demux_sensor_count(demux()) > 1) {
        char first[LUM_SENSOR_NAME_BYTES];
        char second[LUM_SENSOR_NAME_BYTES];
        throw std::runtime_error(
            std::string("data of several sensors: ~sensor has to name one: ") +
            lum_demux_name(demux(), 0, first) + " or " +
            lum_demux_name(demux(), 1, second));
    }
}

void Decoder::take_event(lum_framer_event event)
{
    switch (event) {
    case LUM_FRAMER_FRAME:
        take_frame(*lum_framer_frame(framer_.get(), 0));
        break;
    case LUM_FRAMER_FAILED:
        throw std::bad_alloc();
    case LUM_FRAMER_NONE:
    case LUM_FRAMER_LINE:
    case LUM_FRAMER_FRAME_END:
        break;
    }
}

void Decoder::take_frame(const lum_frame &frame)
{
    lum_frame_info info = {};
    info.struct_size = sizeof info;
    (void)lum_frame_get_info(&frame, &info);
    if (lum_frame_line_count(&frame) == 0) {
        return;
    }
    cloud_.frame = info.number;
    // Without a clock a frame has arrivals alone.
    if (maker_.make(frame,
                    info.begin_utc_ns != 0 ? info.begin_utc_ns
                                           : info.begin_arrival_ns,
                    cloud_)) {
        ROS_WARN("frames have more lines than those before: rings of the green "
                 "eye begin at %u from here on; ~lines states where",
                 static_cast<unsigned>(maker_.rings().lines()));
    }
    if (cloud_.ringless != 0) {
        ROS_WARN_THROTTLE(10.0,
                          "%zu points are of lines beyond %u: their ring is %u",
                          cloud_.ringless, static_cast<unsigned>(cloud_.lines),
                          static_cast<unsigned>(Rings::none));
    }
    counts_.clouds++;
    counts_.points += cloud_.points.size();
    output_(cloud_);
}

void Decoder::flush()
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_flush(framer_.get())) != LUM_FRAMER_NONE) {
        take_event(event);
    }
}

const lum_demux *Decoder::demux() const
{
    return lum_framer_demux(framer_.get());
}

void Decoder::finish()
{
    flush();
    add_lines(counts_);
    begin();
}

// What the framer at work has counted.
void Decoder::add_lines(DecoderCounts &to) const
{
    lum_demux_counters total = {};
    total.struct_size = sizeof total;
    lum_demux_total(demux(), &total);
    add(to.demux, total);
    for (size_t i = 0; i < lum_demux_sensor_count(demux()); i++) {
        lum_framer_counters c = {};
        c.struct_size = sizeof c;
        (void)lum_framer_count(framer_.get(), i, &c);
        to.losses.no_angle += c.losses.no_angle;
        to.losses.no_range += c.losses.no_range;
        to.under_way += c.under_way.words + c.under_way.lines;
        to.pauses += c.pauses;
        to.in_pauses += c.lines_in_pauses;
        to.breaks += c.stray_at_breaks;
        to.left_out += c.points_late + c.points_cut;
    }
}

DecoderCounts Decoder::counts() const
{
    DecoderCounts counts = counts_;
    counts.lines = maker_.rings().lines();
    add_lines(counts);
    return counts;
}

} // namespace lumsdk_ros
