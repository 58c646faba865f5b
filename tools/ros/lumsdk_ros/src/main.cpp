#include "diagnostics.hpp"
#include "eyes.hpp"
#include "options.hpp"
#include "source.hpp"

#include <ros/ros.h>
#include <std_msgs/String.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <csignal>
#include <stdexcept>

using namespace lumsdk_ros;

namespace
{

constexpr int64_t second_ns = 1000000000;
constexpr int64_t tick_ns = second_ns / 20;
constexpr int64_t drain_ns = second_ns / 5; // for what was said last

volatile std::sig_atomic_t has_signal = 0;
lum_cancel *second_signal = nullptr; // lives as long as the program

void note_signal(int)
{
    if (has_signal != 0) {
        lum_cancel_raise(second_signal);
    }
    has_signal = 1;
}

// From here on: ROS's own handler would end the topics before the laser is off.
// What may keep a laser on is ended by these whatever it inherited, but for a
// hang-up that nohup has ignored.
void catch_signals()
{
    struct sigaction action = {};
    lum_error error = {""};
    if (lum_cancel_new(&second_signal, &error) != 0) {
        throw std::runtime_error(error.text);
    }
    struct sigaction hangup = {};
    sigset_t insisted;
    action.sa_handler = note_signal;
    (void)sigfillset(&action.sa_mask); // one after another
    (void)sigemptyset(&insisted);
    for (const int number : {SIGINT, SIGTERM, SIGQUIT}) {
        (void)sigaction(number, &action, nullptr);
        (void)sigaddset(&insisted, number);
    }
    (void)pthread_sigmask(SIG_UNBLOCK, &insisted, nullptr);
    if (sigaction(SIGHUP, nullptr, &hangup) == 0 &&
        hangup.sa_handler != SIG_IGN) {
        (void)sigaction(SIGHUP, &action, nullptr);
    }
}

std::unique_ptr<Source> make_source(const ros::NodeHandle &node,
                                    const Options &options,
                                    const Outlet &outlet, Notes &notes)
{
    switch (options.kind) {
    case SourceKind::sensor:
        return make_live_source(options, outlet, notes);
    case SourceKind::capture:
        return make_capture_source(options, outlet, notes);
    case SourceKind::bag:
    default:
        return make_bag_source(node, options, outlet, notes);
    }
}

void log(const Note &note)
{
    using ros::console::levels::Level;
    static constexpr Level levels[] = {Level::Info, Level::Warn, Level::Error,
                                       Level::Info}; // by kind
    ROS_LOG(levels[note.kind], ROSCONSOLE_DEFAULT_NAME, "%s",
            note.text.c_str());
}

void say(const Outlet &outlet, Notes &notes)
{
    for (const Note &note : notes.take()) {
        log(note);
        if (note.kind == Note::answer) {
            outlet.answer(note.text);
        }
    }
}

class Node
{
  public:
    explicit Node(const Options &options)
        : options_(options), outlet_(node_, options_),
          diagnostics_(ros::this_node::getName().substr(1), options_)
    {
        diagnostics_topic_ = node_.advertise<diagnostic_msgs::DiagnosticArray>(
            "/diagnostics", 10);
        eyes_.sendTransform(
            eye_transforms(options_.calibration, options_.frame_id));
        source_ = make_source(node_, options_, outlet_, notes_);
        if (options_.commands) {
            command_ =
                node_.subscribe("command", 16, &Node::take_command, this);
        }
        ROS_INFO("source: %s", options_.source.c_str());
    }

    // Whether the source was well to the end.
    bool run()
    {
        int64_t due_ns = 0;
        bool is_fine = true;
        while (ros::ok() && has_signal == 0 && is_fine) {
            const int64_t now_ns = lum_time_monotonic_ns();
            const SourceView view = source_->view();
            ros::spinOnce();
            say(outlet_, notes_);
            is_fine = !view.has_failed;
            if (now_ns >= due_ns || !is_fine) {
                due_ns = now_ns + second_ns;
                diagnostics_topic_.publish(diagnostics_.make(view, now_ns));
            }
            lum_time_sleep_until(now_ns + tick_ns);
        }
        return is_fine;
    }

    // The laser is off when it returns, or it is said that it is not.
    void end()
    {
        command_.shutdown();
        source_.reset();
        say(outlet_, notes_);
        lum_time_sleep_until(lum_time_monotonic_ns() + drain_ns);
    }

  private:
    void take_command(const std_msgs::StringConstPtr &message)
    {
        if (!source_->command(message->data)) {
            notes_.add(Note::answer, message->data + ": refused, not sent: " +
                                         options_.source +
                                         " is no sensor to command");
        }
    }

    const Options options_;
    ros::NodeHandle node_;
    Notes notes_;
    Outlet outlet_;
    Diagnostics diagnostics_;
    tf2_ros::StaticTransformBroadcaster eyes_;
    ros::Publisher diagnostics_topic_;
    ros::Subscriber command_;
    std::unique_ptr<Source> source_;
};

bool run()
{
    Options options = read_options(ros::NodeHandle("~"));
    catch_signals();
    options.second_signal = second_signal;
    Node node(options);
    const bool is_fine = node.run();
    node.end();
    return is_fine;
}

} // namespace

int main(int argc, char **argv)
{
    bool is_fine = false;
    ros::init(argc, argv, "lumsdk_node");
    ros::start();
    try {
        is_fine = run();
    } catch (const std::exception &e) {
        ROS_FATAL("%s", e.what());
    }
    ros::shutdown();
    return is_fine ? 0 : 1;
}
