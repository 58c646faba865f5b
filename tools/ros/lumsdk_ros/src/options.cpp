#include "options.hpp"

#include "parameters.hpp"
#include "rings.hpp"

#include <arpa/inet.h>
#include <ros/console.h>

#include <cstdlib>
#include <stdexcept>

namespace lumsdk_ros
{

namespace
{

[[noreturn]] void refuse(const std::string &text)
{
    throw std::runtime_error(text);
}

bool parse_address(const std::string &text, uint32_t &out, lum_error &why)
{
    if (lum_resolve(text.c_str(), &out, &why) != 0) {
        return false;
    }
    if (!lum_address_is_host(out)) {
        (void)lum_error_set(&why, "no sensor can have this address");
        return false;
    }
    return true;
}

bool parse_port(const std::string &text, uint16_t &out)
{
    char *end = nullptr;
    const unsigned long port = std::strtoul(text.c_str(), &end, 10);
    out = static_cast<uint16_t>(port);
    return !text.empty() && *end == '\0' && port >= 1 && port <= 65535;
}

void read_endpoint(const std::string &text, lum_endpoint &out)
{
    const size_t colon = text.find(':');
    lum_error why = {"the port is not a number from 1 to 65535"};
    out.port = LUM_PORT;
    if ((colon != std::string::npos &&
         !parse_port(text.substr(colon + 1), out.port)) ||
        !parse_address(text.substr(0, colon), out.address, why)) {
        refuse(
            "~source: udp://" + text +
            " is not udp://HOST[:PORT], such as udp://10.42.0.37: " + why.text);
    }
}

void read_source(Parameters &p, Options &o)
{
    static const std::string live = "udp://";
    o.source = p.text("source", "");
    if (o.source.empty()) {
        refuse("~source is not set: udp://ADDRESS of a sensor, a capture "
               "file, or bag");
    }
    if (o.source == "bag") {
        o.kind = SourceKind::bag;
    } else if (o.source.compare(0, live.size(), live) == 0) {
        o.kind = SourceKind::sensor;
        read_endpoint(o.source.substr(live.size()), o.endpoint);
        o.has_sensor = true;
        o.sensor = o.endpoint.address;
    }
}

// ADDRESS or ADDRESS%INTERFACE.
void read_sensor(Parameters &p, Options &o)
{
    const std::string sensor = p.text("sensor", "");
    if (sensor.empty() || o.kind == SourceKind::sensor) {
        return;
    }
    const size_t percent = sensor.find('%');
    lum_error why = {""};
    o.has_sensor = true;
    if (!parse_address(sensor.substr(0, percent), o.sensor, why)) {
        refuse("~sensor: " + sensor +
               " is no address, such as 10.42.0.37: " + why.text);
    }
    if (percent == std::string::npos) {
        return;
    }
    o.sensor_interface = sensor.substr(percent + 1);
    if (o.sensor_interface.empty() ||
        o.sensor_interface.size() >= LUM_INTERFACE_BYTES) {
        refuse("~sensor: " + sensor + " names no interface behind the %");
    }
    if (o.kind != SourceKind::capture) {
        refuse("~sensor: " + sensor + ": the packets of a bag have no "
                                      "interface: name the address alone");
    }
}

void read_port(Parameters &p, Options &o)
{
    const bool is_there = p.has("port");
    o.port =
        static_cast<uint16_t>(p.integer("port", LUM_PORT, 1, UINT16_MAX));
    if (is_there && o.kind != SourceKind::capture) {
        refuse("~port is the sensors' port in a capture, and ~source is " +
               o.source);
    }
}

void read_calibration(Parameters &p, Options &o)
{
    std::string path;
    std::string tree;
    lum_error error = {""};
    lum_calibration_default(&o.calibration);
    if (!p.yaml("calibration", path, tree)) {
        return;
    }
    o.has_calibration = true;
    const int result =
        tree.empty()
            ? lum_calibration_load(path.c_str(), &o.calibration, &error)
            : lum_calibration_parse(tree.data(), tree.size(), "~calibration",
                                    &o.calibration, &error);
    if (result != 0) {
        refuse(error.text);
    }
}

void read_profile(Parameters &p, Options &o)
{
    std::string path;
    std::string tree;
    lum_error error = {""};
    lum_profile profile;
    lum_layout_default(&o.layout);
    if (!p.yaml("profile", path, tree)) {
        return;
    }
    o.has_profile = true;
    const int result = tree.empty()
                           ? lum_profile_load(path.c_str(), &profile, &error)
                           : lum_profile_parse(tree.data(), tree.size(),
                                               "~profile", &profile, &error);
    if (result != 0) {
        refuse(error.text);
    }
    if (lum_layout_init(&o.layout, &profile, nullptr, nullptr) != LUM_OK) {
        refuse("~profile cannot be used");
    }
}

void read_edge(Parameters &p, lum_selection &s)
{
    const std::string edge = p.text("edge", "rising");
    if (edge == "rising") {
        s.edges = LUM_EDGES_RISING;
    } else if (edge == "falling") {
        s.edges = LUM_EDGES_FALLING;
    } else if (edge == "both") {
        s.edges = LUM_EDGES_BOTH;
    } else {
        refuse("~edge: " + edge + " is not rising, falling or both");
    }
}

void read_return(Parameters &p, lum_selection &s)
{
    static const struct {
        const char *name;
        lum_return_choice choice;
    } choices[] = {{"all", LUM_RETURNS_ALL},
                   {"first", LUM_RETURNS_FIRST},
                   {"last", LUM_RETURNS_LAST},
                   {"strongest", LUM_RETURNS_STRONGEST}};
    const std::string text = p.text("return", "all");
    for (const auto &c : choices) {
        if (text == c.name) {
            s.returns = c.choice;
            return;
        }
    }
    char *end = nullptr;
    const unsigned long number = std::strtoul(text.c_str(), &end, 10);
    if (text.empty() || *end != '\0' || number < 1 || number > 65535) {
        refuse("~return: " + text +
               " is not all, first, last, strongest or a number from 1");
    }
    s.returns = LUM_RETURNS_NUMBER;
    s.return_number = static_cast<uint16_t>(number);
}

void read_range(Parameters &p, lum_selection &s)
{
    s.has_range = p.has("range_min") || p.has("range_max");
    s.range_min = static_cast<float>(p.number("range_min", 0.0, 0.0, 1e6));
    s.range_max = static_cast<float>(p.number("range_max", 1e6, 0.0, 1e6));
    if (s.range_max < s.range_min) {
        refuse("~range_max is below ~range_min");
    }
}

void read_smoothing(Parameters &p, Options &o)
{
    const auto window = static_cast<uint32_t>(
        p.integer("smoothing", 0, 0, LUM_SMOOTH_WINDOW_MAX));
    const auto order = static_cast<uint32_t>(p.integer(
        "smoothing_order", LUM_SMOOTH_ORDER(window), 0, LUM_SMOOTH_ORDER_MAX));
    lum_smooth smooth;
    o.smooth_window = window;
    o.smooth_order = order;
    if (window > 1 && lum_smooth_init(&smooth, window, order) != LUM_OK) {
        refuse("~smoothing: a window of " + std::to_string(window) +
               " and ~smoothing_order " + std::to_string(order) +
               " do not go together: an odd window above the order is right, "
               "such as 31 and 2");
    }
}

void read_times(Parameters &p, Options &o)
{
    const std::string time = p.text("time", "source");
    if (time != "source" && time != "now") {
        refuse("~time: " + time + " is not source or now");
    }
    o.shifts_to_now = time == "now";
    o.speed = p.number("speed", 1.0, 0.0, 1000.0);
    o.loops = p.flag("loop", false);
    o.wait_for = p.list("wait_for");
}

} // namespace

Options read_options(const ros::NodeHandle &node)
{
    Parameters p(node);
    Options o;
    read_source(p, o);
    read_sensor(p, o);
    read_port(p, o);
    read_calibration(p, o);
    read_profile(p, o);
    lum_selection_default(&o.selection);
    read_edge(p, o.selection);
    read_return(p, o.selection);
    read_range(p, o.selection);
    read_smoothing(p, o);
    read_times(p, o);
    o.lines = static_cast<uint32_t>(
        p.integer("lines", 0, 0, static_cast<int>(Rings::lines_max)));
    o.shows_eyes = p.flag("eye_topics", false);
    o.frame_id = p.text("frame_id", "luminar");
    o.interface_name = p.text("interface", "");
    o.laser = p.flag("laser", false);
    o.commands = p.flag("commands", true);
    if (o.laser && o.kind != SourceKind::sensor) {
        refuse("~laser is for a sensor, and ~source is " + o.source);
    }
    for (const std::string &name : p.unknown()) {
        ROS_WARN("%s is no parameter of this node", name.c_str());
    }
    return o;
}

std::string address_text(uint32_t address)
{
    char text[INET_ADDRSTRLEN] = "";
    const in_addr a = {htonl(address)};
    (void)inet_ntop(AF_INET, &a, text, sizeof text);
    return text;
}

} // namespace lumsdk_ros
