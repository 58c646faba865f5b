#include "diagnostics.hpp"

#include <ros/time.h>

#include <algorithm>
#include <utility>

namespace lumsdk_ros
{

namespace
{

using Status = diagnostic_msgs::DiagnosticStatus;

constexpr int64_t silence_ns = LUM_SENSOR_SILENCE_MS * INT64_C(1000000);

void add(Status &status, const char *key, const std::string &value)
{
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
}

void add_rate(Status &status, const char *key, uint64_t now, uint64_t before,
              double seconds)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%.1f",
                   static_cast<double>(now - before) / seconds);
    add(status, key, text);
}

struct Loss {
    const char *name;
    uint64_t count;
    bool matters; // data that was to be there
};

std::vector<Loss> losses_of(const SourceView &v)
{
    const lum_demux_counters &c = v.pipeline.decoder.demux;
    const lum_assembly_counters &a = c.assembly;
    std::vector<Loss> losses = {
        {"lost_words", a.lost_words, true},
        {"lines_skipped", a.lines_skipped, true},
        {"lines_in_pauses", v.pipeline.decoder.in_pauses, true},
        {"pauses", v.pipeline.decoder.pauses, true},
        {"lines_missing_angles", a.lines_missing_angles, true},
        {"late", a.late, true},
        {"duplicate", a.duplicate, false},
        {"conflict", a.conflict, true},
        {"no_room", a.no_room, true},
        {"stray", a.stray, true},
        {"stray_at_breaks", v.pipeline.decoder.breaks, false},
        {"out_of_order", c.out_of_order, false},
        {"bad_words", a.bad_words, true},
        {"malformed", c.packets[LUM_PACKET_MALFORMED], true},
        {"unknown_tag", c.packets[LUM_PACKET_UNKNOWN_TAG], true},
        {"unknown_type", c.packets[LUM_PACKET_UNKNOWN_TYPE], true},
        {"foreign", c.packets[LUM_PACKET_FOREIGN], false},
        {"cut_short", c.cut_short + v.session.counters.cut_short, true},
        {"other", c.other, false},
        {"no_angle", v.pipeline.decoder.losses.no_angle, false},
        {"no_range", v.pipeline.decoder.losses.no_range, false},
        {"points_left_out", v.pipeline.decoder.left_out, true}};
    if (v.has_session) {
        losses.push_back(
            {"kernel_drops", v.session.counters.kernel_drops, true});
        losses.push_back({"node_drops", v.session.channel_drops, true});
        losses.push_back(
            {"foreign_source", v.session.counters.foreign_source, false});
        losses.push_back(
            {"send_failures", v.session.counters.send_failures, true});
    }
    if (v.has_merger) {
        losses.push_back({"messages_lost", v.merger.lost, true});
        losses.push_back({"messages_refused", v.merger.refused, true});
        losses.push_back({"messages_dropped", v.messages_dropped, true});
    }
    return losses;
}

} // namespace

Diagnostics::Diagnostics(std::string node_name, const Options &options)
    : node_name_(std::move(node_name)),
      hardware_(options.has_sensor ? address_text(options.sensor)
                                   : options.source),
      is_live_(options.kind == SourceKind::sensor),
      before_ns_(lum_time_monotonic_ns()), heard_ns_(before_ns_)
{
}

Status Diagnostics::make_status(const char *name) const
{
    Status status;
    status.name = node_name_ + ": " + name;
    status.hardware_id = hardware_;
    status.level = Status::OK;
    return status;
}

Status Diagnostics::make_data(const SourceView &view, int64_t now_ns)
{
    const PipelineView &now = view.pipeline;
    const double seconds =
        static_cast<double>(now_ns - before_ns_) * 1e-9 + 1e-9;
    Status status = make_status("data");
    heard_ns_ = now.packets != before_.packets ? now_ns : heard_ns_;
    status.message = "packets come";
    if (view.has_failed) {
        status.level = Status::ERROR;
        status.message = "failed";
    } else if (view.has_ended) {
        status.message = "the capture has ended";
    } else if (now.packets == 0) {
        status.level = is_live_ ? Status::WARN : Status::OK;
        status.message = "waiting for packets";
    } else if (now_ns - heard_ns_ >= silence_ns) {
        status.level = is_live_ ? Status::WARN : Status::OK;
        status.message = "no packets for " +
                         std::to_string(LUM_SENSOR_SILENCE_MS / 1000) + " s";
    }
    add_rate(status, "frames_per_second", now.decoder.clouds,
             before_.decoder.clouds, seconds);
    add_rate(status, "points_per_second", now.decoder.points,
             before_.decoder.points, seconds);
    add_rate(status, "packets_per_second", now.packets, before_.packets,
             seconds);
    add_rate(status, "bytes_per_second", now.bytes, before_.bytes, seconds);
    add(status, "frames", std::to_string(now.decoder.clouds));
    add(status, "points", std::to_string(now.decoder.points));
    add(status, "lines", std::to_string(now.decoder.lines));
    add(status, "packets", std::to_string(now.packets));
    add(status, "bytes", std::to_string(now.bytes));
    before_ = now;
    before_ns_ = now_ns;
    return status;
}

Status Diagnostics::make_losses(const SourceView &view)
{
    Status status = make_status("losses");
    const uint64_t joined = view.pipeline.decoder.under_way;
    uint64_t lost = 0;
    for (const Loss &loss : losses_of(view)) {
        add(status, loss.name, std::to_string(loss.count));
        lost += loss.matters ? loss.count : 0;
    }
    add(status, "under_way_when_joined", std::to_string(joined));
    lost -= std::min(lost, joined);
    status.message = lost == 0 ? "none" : "some, none of late";
    if (lost > lost_before_) {
        status.level = Status::WARN;
        status.message = "data is being lost";
    }
    lost_before_ = lost;
    return status;
}

Status Diagnostics::make_laser(const SessionView &view) const
{
    Status status = make_status("laser");
    if (!view.has_status) {
        status.level = Status::STALE;
        status.message = "the sensor has not told its status";
        return status;
    }
    const bool is_down = lum_laser_is_down(view.status);
    const unsigned hazards = view.status & LUM_LASER_HAZARDS;
    char hex[8];
    (void)snprintf(hex, sizeof hex, "0x%04x", view.status);
    status.message = is_down ? "down" : "up";
    if (hazards != 0) {
        status.level = Status::ERROR;
        status.message += ", hazard: " + bit_names(hazards);
    }
    add(status, "status", hex);
    add(status, "laser", is_down ? "down" : "up");
    add(status, "hazards", bit_names(hazards));
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        add(status, lum_laser_bit_name(bit),
            (view.status >> bit & 1u) != 0 ? "true" : "false");
    }
    return status;
}

diagnostic_msgs::DiagnosticArray Diagnostics::make(const SourceView &view,
                                                   int64_t now_ns)
{
    diagnostic_msgs::DiagnosticArray array;
    array.header.stamp = ros::Time::now();
    array.status.push_back(make_data(view, now_ns));
    array.status.push_back(make_losses(view));
    if (view.has_session) {
        array.status.push_back(make_laser(view.session));
    }
    return array;
}

} // namespace lumsdk_ros
