// The thread that keeps the session with a sensor.
#ifndef LUMSDK_ROS_SESSION_HPP
#define LUMSDK_ROS_SESSION_HPP

#include "channel.hpp"
#include "laser.hpp"
#include "lum.hpp"
#include "notes.hpp"
#include "options.hpp"

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

namespace lumsdk_ros
{

// What a session knows, for others.
struct SessionView {
    lum_sensor_counters counters = {};
    uint64_t channel_drops = 0;
    bool has_status = false;
    uint16_t status = 0;
    bool is_broken = false;
};

// Heartbeats leave from inside the receiving calls of its thread and from
// nowhere else: when it hangs, or the process is stopped, they stop, and 3 s
// later the sensor switches its laser off. It never waits for a subscriber, a
// log or the decoder.
class Session
{
  public:
    // Opens the session. Throws std::runtime_error.
    Session(const Options &options, Channel &channel, Notes &notes);

    // Ends the thread and switches off the laser where it was on from here.
    ~Session();

    Session(const Session &) = delete;
    Session &operator=(const Session &) = delete;

    // A command of the manual's, in whatever thread.
    void command(const std::string &text);

    SessionView view() const;

  private:
    struct FreeCancel {
        void operator()(lum_cancel *cancel) const
        {
            lum_cancel_free(cancel);
        }
    };
    struct CloseSensor {
        void operator()(lum_sensor *sensor) const
        {
            lum_sensor_close(sensor);
        }
    };

    lum_net_result open(bool owns, lum_error &error);
    void run();
    void step();
    void tick(int64_t now_ns);
    void tell_move();
    void make_view();
    lum_laser_off switch_off_within(uint16_t &status);
    void switch_off();

    const Options options_;
    Channel &channel_;
    Notes &notes_;
    std::unique_ptr<lum_cancel, FreeCancel> cancel_;
    std::unique_ptr<lum_sensor, CloseSensor> sensor_;
    std::unique_ptr<Laser> laser_;
    std::atomic<bool> stop_{false};
    bool is_broken_ = false;
    bool is_moved_ = false;
    uint64_t drops_ = 0;
    int64_t tick_ns_ = 0;
    std::thread thread_;

    mutable std::mutex lock_; // guards what follows
    SessionView view_;
};

} // namespace lumsdk_ros

#endif
