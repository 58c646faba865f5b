// Parameters of the node, with what is wrong told by name.
#ifndef LUMSDK_ROS_PARAMETERS_HPP
#define LUMSDK_ROS_PARAMETERS_HPP

#include <ros/node_handle.h>

#include <set>
#include <string>
#include <vector>

namespace lumsdk_ros
{

class Parameters
{
  public:
    explicit Parameters(const ros::NodeHandle &node);

    std::string text(const std::string &name, const std::string &usual);
    bool flag(const std::string &name, bool usual);
    double number(const std::string &name, double usual, double least,
                  double most);
    int integer(const std::string &name, int usual, int least, int most);
    std::vector<std::string> list(const std::string &name);
    bool has(const std::string &name);

    // A file's content or a tree of parameters (rosparam load), as YAML text
    // with a name for messages; false: not set.
    bool yaml(const std::string &name, std::string &path, std::string &tree);

    // Parameters that nobody asked for: most often misspelt.
    std::vector<std::string> unknown() const;

    std::string full_name(const std::string &name) const;

  private:
    bool get(const std::string &name, XmlRpc::XmlRpcValue &out);

    ros::NodeHandle node_;
    std::set<std::string> asked_;
};

} // namespace lumsdk_ros

#endif
