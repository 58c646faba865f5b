// A frame's lines to one cloud, in order of time.
#ifndef LUMSDK_ROS_CLOUD_HPP
#define LUMSDK_ROS_CLOUD_HPP

#include "lum.hpp"
#include "rings.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lumsdk_ros
{

// As it stands in a sensor_msgs/PointCloud2: every field where its size wants
// it.
struct Point {
    float x;
    float y;
    float z;
    float intensity; // pulse width, ns
    float time;      // seconds from the stamp
    uint16_t ring;   // of Rings
    uint8_t number;  // of the return
    uint8_t eye;     // 0 blue, 1 green
};

static_assert(sizeof(Point) == 24, "as the message's fields say");
static_assert(offsetof(Point, intensity) == 12 && offsetof(Point, time) == 16 &&
                  offsetof(Point, ring) == 20 &&
                  offsetof(Point, number) == 22 && offsetof(Point, eye) == 23,
              "as the message's fields say");

struct Cloud {
    int64_t frame = 0;
    int64_t stamp_ns = 0; // UTC, of the earliest point
    uint32_t lines = 0;   // what the green eye's rings are above the blue's
    size_t ringless = 0;  // points of lines beyond these
    std::vector<Point> points;
};

// What one eye sees of a cloud, its rings counted from 0.
void take_eye(const Cloud &cloud, unsigned eye, Cloud &out);

// The columns that a cloud is made of.
constexpr lum_columns cloud_columns =
    LUM_COLUMNS_XYZ | LUM_COLUMN_BIT(LUM_COLUMN_PULSE_WIDTH) |
    LUM_COLUMN_BIT(LUM_COLUMN_TIME) | LUM_COLUMN_BIT(LUM_COLUMN_LINE) |
    LUM_COLUMN_BIT(LUM_COLUMN_RETURN_NUMBER) | LUM_COLUMN_BIT(LUM_COLUMN_EYE);

// Makes clouds of frames, and keeps memory for the next.
class CloudMaker
{
  public:
    explicit CloudMaker(uint32_t lines) : rings_(lines)
    {
    }

    // A frame into order of time, then eye, then as its lines hold its points.
    // begin_ns: UTC of the frame's begin. Whether there were more lines than
    // the rings knew.
    bool make(const lum_frame &frame, int64_t begin_ns, Cloud &out);

    const Rings &rings() const
    {
        return rings_;
    }

  private:
    bool show_lines(const lum_frame &frame);
    void take_points(const lum_frame &frame, Cloud &out);
    static void set_first(int64_t begin_ns, Cloud &out);

    Rings rings_;
    std::vector<Point> eyes_[LUM_EYES];
};

} // namespace lumsdk_ros

#endif
