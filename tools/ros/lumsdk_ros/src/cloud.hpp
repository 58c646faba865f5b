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
    uint16_t ring;   // of Rings; the line, until Frame::finish()
    uint8_t number;  // of the return
    uint8_t eye;     // 0 blue, 1 green
};

static_assert(sizeof(Point) == 24, "as the message's fields say");
static_assert(offsetof(Point, intensity) == 12 && offsetof(Point, time) == 16 &&
                  offsetof(Point, ring) == 20 && offsetof(Point, number) == 22 &&
                  offsetof(Point, eye) == 23,
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

// A frame that is being put together.
class Frame
{
  public:
    void clear();

    // clock_ns: of the line's first pixel. offset_ns: what makes UTC of the
    // clock, as far as it is known now. Returns points left out for want of
    // room.
    size_t add(const lum_line &line, const lum_sample *samples, size_t count,
               int64_t clock_ns, int64_t offset_ns);

    // Into order of time, then eye, then as the lines hold them. Whether there
    // were more lines than rings knew.
    bool finish(Rings &rings, Cloud &out);

  private:
    struct Line {
        int64_t clock_ns;
        uint32_t number;
        size_t end; // of its points in those of the eye
    };
    struct Eye {
        std::vector<Line> lines;
        std::vector<Point> points; // time: the pixel, until finish()
    };

    bool show_lines(Rings &rings) const;
    static size_t set_rings(Eye &eye, unsigned index, const Rings &rings);
    int64_t line_period_ns() const;
    int64_t find_first(int64_t period_ns) const;
    static void set_times(Eye &eye, int64_t period_ns, int64_t first_ns);

    Eye eyes_[LUM_EYES];
    int64_t offset_ns_ = 0;
};

} // namespace lumsdk_ros

#endif
