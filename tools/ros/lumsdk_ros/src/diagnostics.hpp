// How the node is, for /diagnostics.
#ifndef LUMSDK_ROS_DIAGNOSTICS_HPP
#define LUMSDK_ROS_DIAGNOSTICS_HPP

#include "options.hpp"
#include "source.hpp"

#include <diagnostic_msgs/DiagnosticArray.h>

#include <string>

namespace lumsdk_ros
{

class Diagnostics
{
  public:
    Diagnostics(std::string node_name, const Options &options);

    // now_ns: monotonic; rates are those since the call before.
    diagnostic_msgs::DiagnosticArray make(const SourceView &view,
                                          int64_t now_ns);

  private:
    using Status = diagnostic_msgs::DiagnosticStatus;

    Status make_data(const SourceView &view, int64_t now_ns);
    Status make_losses(const SourceView &view);
    Status make_laser(const SessionView &view) const;
    Status make_status(const char *name) const;

    const std::string node_name_;
    const std::string hardware_;
    const bool is_live_;
    PipelineView before_;
    int64_t before_ns_;
    int64_t heard_ns_;
    uint64_t lost_before_ = 0;
};

} // namespace lumsdk_ros

#endif
