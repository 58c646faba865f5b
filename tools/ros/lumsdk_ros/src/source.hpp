// Where packets come from.
#ifndef LUMSDK_ROS_SOURCE_HPP
#define LUMSDK_ROS_SOURCE_HPP

#include "merger.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "outlet.hpp"
#include "pipeline.hpp"
#include "session.hpp"

#include <memory>
#include <string>

namespace lumsdk_ros
{

struct SourceView {
    PipelineView pipeline;
    bool has_session = false;
    SessionView session;
    bool has_merger = false;
    MergerCounts merger;
    uint64_t messages_dropped = 0; // of raw topics, by this node
    bool has_ended = false;        // a capture, read to its end
    bool has_failed = false;       // the node has to end
};

// Works in threads of its own from its making to its end. What it has to say
// it leaves in the notes.
class Source
{
  public:
    virtual ~Source() = default;

    virtual SourceView view() const = 0;

    // A command for the sensor; false: there is none.
    virtual bool command(const std::string &text) = 0;
};

// Throw std::runtime_error.
std::unique_ptr<Source> make_live_source(const Options &options,
                                         const Outlet &outlet, Notes &notes);
std::unique_ptr<Source> make_capture_source(const Options &options,
                                            const Outlet &outlet, Notes &notes);
std::unique_ptr<Source> make_bag_source(const ros::NodeHandle &node,
                                        const Options &options,
                                        const Outlet &outlet, Notes &notes);

} // namespace lumsdk_ros

#endif
