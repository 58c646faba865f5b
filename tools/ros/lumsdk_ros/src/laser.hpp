// A sensor's laser and its status: asked for, switched, watched, commanded.
#ifndef LUMSDK_ROS_LASER_HPP
#define LUMSDK_ROS_LASER_HPP

#include "lum.hpp"
#include "notes.hpp"

#include <deque>
#include <mutex>
#include <string>

namespace lumsdk_ros
{

// Names of the bits of a status, or "none".
std::string bit_names(unsigned bits);

// The requests of one session, one at a time. All but add() is for the thread
// that receives.
class Laser
{
  public:
    // wanted: switch it on.
    Laser(lum_sensor *sensor, const lum_layout &layout, bool wanted,
          Notes &notes);

    // An event that is no datagrams; now_ns: monotonic.
    void take(const lum_sensor_event &event, int64_t now_ns);

    // Time goes on; to be called several times a second.
    void tick(int64_t now_ns);

    // A command of the manual's, in whatever thread; what is none is refused
    // at once.
    void add(const std::string &text);

    // It was switched on from here, or was to be.
    bool is_ours() const
    {
        return is_ours_;
    }

    // One that still holds: the sensor answers.
    bool has_status() const
    {
        return has_status_ && !is_unheard_;
    }

    uint16_t status() const
    {
        return status_;
    }

  private:
    enum class State {
        untouched, // nobody asked for it, or it was switched off
        asked,     // it is being switched on
        up,
        down, // by itself
    };
    enum class Request {
        none,
        poll,
        on,
        off, // after a hazard
        command
    };

    void ask(int64_t now_ns);
    bool send(Request request, const std::string &text);
    void give_up();
    bool next_command(std::string &text);
    void take_answer(const lum_sensor_event &event, int64_t now_ns);
    void take_no_answer(const lum_sensor_event &event, int64_t now_ns);
    void show_texts(lum_tlv_reader tlvs);
    void note_status(uint16_t status, int64_t now_ns);
    void follow(uint16_t status);
    void take_hazard(uint16_t status);
    void judge_on(int64_t now_ns);
    void judge_command(const lum_sensor_event &event);

    lum_sensor *const sensor_;
    const lum_layout layout_;
    Notes &notes_;
    State state_;
    bool is_ours_;
    Request request_ = Request::none;
    std::string text_;    // of the command under way
    std::string refusal_; // the sensor's words on it
    unsigned attempts_ = 0;
    bool is_off_due_ = false;
    bool has_status_ = false;
    bool is_unheard_ = false;
    uint16_t status_ = 0;
    uint16_t told_ = 0; // hazards that were warned of
    int64_t began_ns_;
    int64_t tick_ns_;
    int64_t next_ns_ = 0;

    std::mutex lock_; // guards what follows
    std::deque<std::string> commands_;
};

} // namespace lumsdk_ros

#endif
