#include "cloud.hpp"

#include <algorithm>

namespace lumsdk_ros
{

namespace
{

bool is_earlier(const Point &a, const Point &b)
{
    return a.time < b.time;
}

} // namespace

bool CloudMaker::show_lines(const lum_frame &frame)
{
    uint32_t highest[2] = {0, 0}; // the second, the highest
    lum_frame_line line = {};
    line.struct_size = sizeof line;
    for (size_t i = 0; lum_frame_get_line(&frame, i, &line); i++) {
        if (line.number >= highest[1]) {
            highest[0] = highest[1];
            highest[1] = line.number;
        } else {
            highest[0] = std::max(highest[0], line.number);
        }
    }
    return rings_.see(highest[0], highest[1]);
}

// Each eye's points by themselves, for these are in order but for stragglers.
void CloudMaker::take_points(const lum_frame &frame, Cloud &out)
{
    const float *x = lum_frame_floats(&frame, LUM_COLUMN_X);
    const float *y = lum_frame_floats(&frame, LUM_COLUMN_Y);
    const float *z = lum_frame_floats(&frame, LUM_COLUMN_Z);
    const float *width = lum_frame_floats(&frame, LUM_COLUMN_PULSE_WIDTH);
    const float *time = lum_frame_floats(&frame, LUM_COLUMN_TIME);
    const uint32_t *line = lum_frame_uint32s(&frame, LUM_COLUMN_LINE);
    const uint16_t *number =
        lum_frame_uint16s(&frame, LUM_COLUMN_RETURN_NUMBER);
    const uint8_t *eye = lum_frame_uint8s(&frame, LUM_COLUMN_EYE);
    out.ringless = 0;
    for (std::vector<Point> &points : eyes_) {
        points.clear();
    }
    for (size_t i = 0; i < lum_frame_count(&frame); i++) {
        Point p = {};
        p.x = x[i];
        p.y = y[i];
        p.z = z[i];
        p.intensity = width[i];
        p.time = time[i];
        p.ring = rings_.of(eye[i], line[i]);
        p.number =
            static_cast<uint8_t>(std::min<uint16_t>(number[i], UINT8_MAX));
        p.eye = eye[i];
        out.ringless += p.ring == Rings::none ? 1 : 0;
        eyes_[eye[i]].push_back(p);
    }
}

// The stamp and the times begin with the earliest point.
void CloudMaker::set_first(int64_t begin_ns, Cloud &out)
{
    const float first = out.points.empty() ? 0.0f : out.points.front().time;
    out.stamp_ns =
        begin_ns + static_cast<int64_t>(static_cast<double>(first) * 1e9);
    for (Point &p : out.points) {
        p.time -= first;
    }
}

bool CloudMaker::make(const lum_frame &frame, int64_t begin_ns, Cloud &out)
{
    const bool has_grown = show_lines(frame);
    take_points(frame, out);
    for (std::vector<Point> &points : eyes_) {
        if (!std::is_sorted(points.begin(), points.end(), is_earlier)) {
            std::stable_sort(points.begin(), points.end(), is_earlier);
        }
    }
    const std::vector<Point> &blue = eyes_[LUM_EYE_BLUE];
    const std::vector<Point> &green = eyes_[LUM_EYE_GREEN];
    out.lines = rings_.lines();
    out.points.resize(blue.size() + green.size());
    (void)std::merge(blue.begin(), blue.end(), green.begin(), green.end(),
                     out.points.begin(), is_earlier);
    set_first(begin_ns, out);
    return has_grown;
}

void take_eye(const Cloud &cloud, unsigned eye, Cloud &out)
{
    out.frame = cloud.frame;
    out.stamp_ns = cloud.stamp_ns;
    out.lines = cloud.lines;
    out.points.clear();
    for (const Point &p : cloud.points) {
        if (p.eye == eye) {
            out.points.push_back(p);
        }
    }
    const float first = out.points.empty() ? 0.0f : out.points.front().time;
    const auto above = static_cast<uint16_t>(eye * cloud.lines);
    out.stamp_ns += static_cast<int64_t>(static_cast<double>(first) * 1e9);
    for (Point &p : out.points) {
        p.time -= first;
        p.ring = static_cast<uint16_t>(p.ring == Rings::none ? Rings::none
                                                             : p.ring - above);
    }
}

} // namespace lumsdk_ros
