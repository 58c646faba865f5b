#include "outlet.hpp"

#include "packet.hpp"

#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <stdexcept>

namespace lumsdk_ros
{

namespace
{

// A second of clouds, and several of packets: a recorder may be busy so long.
constexpr uint32_t clouds_queued = 10;
constexpr uint32_t batches_queued = 500;
constexpr uint32_t answers_queued = 100;

using Field = sensor_msgs::PointField;

Field make_field(const char *name, size_t offset, uint8_t type)
{
    Field field;
    field.name = name;
    field.offset = static_cast<uint32_t>(offset);
    field.datatype = type;
    field.count = 1;
    return field;
}

std::vector<Field> make_fields()
{
    return {make_field("x", offsetof(Point, x), Field::FLOAT32),
            make_field("y", offsetof(Point, y), Field::FLOAT32),
            make_field("z", offsetof(Point, z), Field::FLOAT32),
            make_field("intensity", offsetof(Point, intensity), Field::FLOAT32),
            make_field("time", offsetof(Point, time), Field::FLOAT32),
            make_field("ring", offsetof(Point, ring), Field::UINT16),
            make_field("return", offsetof(Point, number), Field::UINT8),
            make_field("eye", offsetof(Point, eye), Field::UINT8)};
}

bool is_big_endian()
{
    const uint16_t one = 1;
    return *reinterpret_cast<const uint8_t *>(&one) == 0;
}

} // namespace

const char *const raw_topics[LUM_EYES] = {"luminar_raw_blue_data",
                                          "luminar_raw_green_data"};

Outlet::Outlet(ros::NodeHandle node, const Options &options)
    : options_(options), node_(node),
      points_(node.advertise<sensor_msgs::PointCloud2>("points", clouds_queued))
{
    static const char *const names[LUM_EYES] = {"points_blue", "points_green"};
    for (unsigned eye = 0; eye < LUM_EYES && options.shows_eyes; eye++) {
        eyes_[eye] = node.advertise<sensor_msgs::PointCloud2>(names[eye],
                                                              clouds_queued);
    }
    if (options.kind != SourceKind::bag) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            raw_[eye] =
                node.advertise<Packets>(raw_topics[eye], batches_queued);
        }
    }
    if (options.commands) {
        answer_ = node.advertise<std_msgs::String>("answer", answers_queued);
    }
    (void)has_audience(); // whether all names are known
}

void Outlet::publish(const Cloud &cloud) const
{
    if (points_.getNumSubscribers() != 0) {
        publish(points_, cloud);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (eyes_[eye] && eyes_[eye].getNumSubscribers() != 0) {
            Cloud part;
            take_eye(cloud, eye, part);
            publish(eyes_[eye], part);
        }
    }
}

void Outlet::publish(const ros::Publisher &to, const Cloud &cloud) const
{
    const sensor_msgs::PointCloud2Ptr m(new sensor_msgs::PointCloud2);
    const auto *bytes = reinterpret_cast<const uint8_t *>(cloud.points.data());
    const size_t size = cloud.points.size() * sizeof(Point);
    m->header.stamp = ros_time(cloud.stamp_ns);
    m->header.frame_id = options_.frame_id;
    m->height = 1;
    m->width = static_cast<uint32_t>(cloud.points.size());
    m->fields = make_fields();
    m->is_bigendian = is_big_endian();
    m->point_step = sizeof(Point);
    m->row_step = static_cast<uint32_t>(size);
    m->data.assign(bytes, bytes + size);
    m->is_dense = true;
    to.publish(m);
}

void Outlet::publish(unsigned eye, const PacketsPtr &packets) const
{
    raw_[eye].publish(packets);
}

void Outlet::answer(const std::string &text) const
{
    std_msgs::String m;
    m.data = text;
    answer_.publish(m);
}

bool Outlet::has_audience() const
{
    const ros::Publisher *const all[] = {&points_,  &eyes_[0], &eyes_[1],
                                         &raw_[0], &raw_[1],  &answer_};
    bool has_all = true;
    for (const std::string &name : options_.wait_for) {
        const std::string topic = node_.resolveName(name);
        const auto *const end = std::end(all);
        const auto *const found =
            std::find_if(std::begin(all), end, [&](const ros::Publisher *p) {
                return *p && p->getTopic() == topic;
            });
        if (found == end) {
            throw std::runtime_error("~wait_for: " + topic +
                                     " is not published by this node");
        }
        has_all &= (*found)->getNumSubscribers() != 0;
    }
    return has_all;
}

} // namespace lumsdk_ros
