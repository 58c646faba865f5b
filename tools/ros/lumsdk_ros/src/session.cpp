#include "session.hpp"

#include <stdexcept>

namespace lumsdk_ros
{

namespace
{

constexpr int64_t second_ns = 1000000000;
constexpr int64_t tick_every_ns = second_ns / 20;

// After a batch that was not full: more come together then, in fewer calls.
constexpr int64_t rest_ns = second_ns / 1000;

} // namespace

Session::Session(const Options &options, Channel &channel, Notes &notes)
    : options_(options), channel_(channel), notes_(notes)
{
    lum_error error = {""};
    lum_cancel *cancel = nullptr;
    if (lum_cancel_new(&cancel, &error) != 0) {
        throw std::runtime_error(error.text);
    }
    cancel_.reset(cancel);
    if (open(true, error) != LUM_NET_OK) {
        throw std::runtime_error(error.text);
    }
    laser_.reset(
        new Laser(sensor_.get(), options_.layout, options_.laser, notes_));
    if (!lum_socket_has_room(lum_sensor_socket(sensor_.get()))) {
        notes_.add(Note::info,
                   "the system grants a smaller receive buffer than was asked "
                   "for: sysctl -w net.core.rmem_max=" +
                       std::to_string(LUM_SOCKET_RECEIVE_BUFFER));
    }
    thread_ = std::thread([this] { run(); });
}

lum_net_result Session::open(bool owns, lum_error &error)
{
    lum_sensor_options o;
    lum_sensor *sensor = nullptr;
    lum_sensor_options_default(&o);
    o.sensor = options_.endpoint;
    o.interface_name = options_.interface_name.empty()
                           ? nullptr
                           : options_.interface_name.c_str();
    o.layout = options_.layout;
    o.owns = owns;
    o.receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
    o.cancel = cancel_.get();
    const lum_net_result result = lum_sensor_open(&o, &sensor, &error);
    sensor_.reset(sensor);
    return result;
}

void Session::command(const std::string &text)
{
    laser_->add(text);
}

SessionView Session::view() const
{
    const std::lock_guard<std::mutex> guard(lock_);
    return view_;
}

void Session::make_view()
{
    const std::lock_guard<std::mutex> guard(lock_);
    if (!is_broken_) { // else it may only be closed
        view_.counters.struct_size = sizeof view_.counters;
        lum_sensor_count(sensor_.get(), &view_.counters);
    }
    view_.channel_drops = drops_;
    view_.has_status = laser_->has_status();
    view_.status = laser_->status();
    view_.is_broken = is_broken_;
}

void Session::tell_move()
{
    lum_endpoint to = {0, 0};
    const bool is_moved = lum_sensor_moved_to(sensor_.get(), &to);
    if (is_moved && !is_moved_) {
        const std::string old = address_text(options_.endpoint.address);
        notes_.add(Note::error,
                   "the data comes from " + address_text(to.address) +
                       " now, not from " + old +
                       ": the sensor has got that address. It is not taken, "
                       "and ends in 3 s, since the heartbeats go to " +
                       old + ": start the node anew with udp://" +
                       address_text(to.address));
    }
    is_moved_ = is_moved;
}

void Session::tick(int64_t now_ns)
{
    tick_ns_ = now_ns + tick_every_ns;
    tell_move();
    laser_->tick(now_ns);
    make_view();
}

void Session::step()
{
    lum_sensor_event event;
    lum_sensor_receive(sensor_.get(), tick_ns_, &event);
    const int64_t now_ns = lum_time_monotonic_ns();
    if (event.kind == LUM_SENSOR_DATAGRAMS) {
        drops_ += channel_.put(event.datagrams, event.datagram_count);
    } else if (event.kind == LUM_SENSOR_FAILED) {
        is_broken_ = true;
        notes_.add(Note::error, event.error.text);
    } else {
        laser_->take(event, now_ns);
    }
    if (now_ns >= tick_ns_) {
        tick(now_ns);
    }
    if (event.kind == LUM_SENSOR_DATAGRAMS &&
        event.datagram_count < LUM_SOCKET_BATCH) {
        lum_time_sleep_until(now_ns + rest_ns);
    }
}

void Session::run()
{
    while (!stop_ && !is_broken_) {
        step();
    }
    make_view();
    channel_.close();
}

// Of LUM_SENSOR_OFF_MS a second signal may end what is behind the first 3 s:
// by then a sensor that gets no heartbeats is down by itself.
lum_laser_off Session::switch_off_within(uint16_t &status)
{
    constexpr uint32_t alone_ms = 3000;
    const lum_laser_off off = lum_sensor_laser_off_within(
        sensor_.get(), alone_ms, nullptr, &status);
    return off == LUM_LASER_OFF_SEEN || off == LUM_LASER_OFF_UNSEEN
               ? off
               : lum_sensor_laser_off_within(sensor_.get(),
                                             LUM_SENSOR_OFF_MS - alone_ms,
                                             options_.second_signal, &status);
}

// A socket that broke sends nothing more, another may.
void Session::switch_off()
{
    lum_error error = {""};
    uint16_t status = 0;
    lum_laser_off off = LUM_LASER_OFF_UNKNOWN;
    if (is_broken_) {
        sensor_.reset();
        (void)open(false, error);
    }
    if (sensor_) {
        lum_sensor_give_up(sensor_.get());
        off = switch_off_within(status);
    }
    lum_endpoint at = options_.endpoint; // the new one of a sensor that moved
    if (sensor_) {
        (void)lum_sensor_moved_to(sensor_.get(), &at);
    }
    const std::string tell =
        "lumctl --host " + address_text(at.address) + " laser off";
    if (off == LUM_LASER_OFF_SEEN) {
        notes_.add(Note::info, "the laser is off");
    } else if (off == LUM_LASER_OFF_UNKNOWN) {
        notes_.add(Note::error,
                   "laser off was not answered: a sensor that lives switches "
                   "it off 3 s after the last heartbeat, which has been sent; "
                   "make sure by " +
                       tell);
    } else if (off == LUM_LASER_OFF_UNSEEN) {
        notes_.add(
            Note::error,
            "laser off was answered without a status TLV, so nothing shows it "
            "off: tlv.status of the profile says " +
                std::to_string(options_.layout.profile.tlv[LUM_TLV_STATUS]) +
                "; a sensor that lives switches it off 3 s after the last "
                "heartbeat, which has been sent");
    } else {
        const std::string state =
            lum_laser_is_down(status)
                ? "LASER ON IS STILL IN EFFECT after laser off: the laser "
                  "comes up by itself when what keeps it down ends"
                : "THE LASER IS STILL ON after laser off";
        notes_.add(Note::error, state + " (" + bit_names(status) + "): " +
                                    tell + ", or cut its power");
    }
}

Session::~Session()
{
    stop_ = true;
    lum_cancel_raise(cancel_.get());
    thread_.join();
    if (laser_->is_ours()) {
        switch_off();
    }
}

} // namespace lumsdk_ros
