#include "cloud.hpp"

#include <algorithm>
#include <limits>

namespace lumsdk_ros
{

namespace
{

// More than both eyes can have in a frame of 640 lines, all returns counted.
constexpr size_t eye_points_max = size_t{1} << 23;

// A line that lasts longer is two.
constexpr int64_t period_max_ns = 100000000;

bool is_earlier(const Point &a, const Point &b)
{
    return a.time < b.time;
}

Point make_point(const lum_sample &s, unsigned eye, uint32_t line)
{
    Point p = {};
    p.x = s.x;
    p.y = s.y;
    p.z = s.z;
    p.intensity = s.pulse_width;
    p.time = static_cast<float>(s.pixel);
    p.ring = static_cast<uint16_t>(std::min<uint32_t>(line, UINT16_MAX));
    p.number =
        static_cast<uint8_t>(std::min<uint16_t>(s.return_number, UINT8_MAX));
    p.eye = static_cast<uint8_t>(eye);
    return p;
}

int64_t pixel_ns(const Point &point, int64_t period_ns)
{
    return static_cast<int64_t>(point.time) * period_ns / LUM_LINE_PIXELS;
}

} // namespace

void Frame::clear()
{
    for (Eye &eye : eyes_) {
        eye.lines.clear();
        eye.points.clear();
    }
}

size_t Frame::add(const lum_line &line, const lum_sample *samples, size_t count,
                  int64_t clock_ns, int64_t offset_ns)
{
    Eye &eye = eyes_[line.eye];
    const size_t room = eye_points_max - eye.points.size();
    const size_t taken = std::min(room, count);
    for (size_t i = 0; i < taken; i++) {
        eye.points.push_back(make_point(samples[i], line.eye, line.number));
    }
    eye.lines.push_back({clock_ns, line.number, eye.points.size()});
    offset_ns_ = offset_ns;
    return count - taken;
}

// How long a line lasts: the median of what lies between neighbours of this
// frame, lost lines between them allowed for.
int64_t Frame::line_period_ns() const
{
    std::vector<int64_t> periods;
    for (const Eye &eye : eyes_) {
        for (size_t i = 1; i < eye.lines.size(); i++) {
            const Line &a = eye.lines[i - 1];
            const Line &b = eye.lines[i];
            if (b.number > a.number && b.clock_ns > a.clock_ns) {
                periods.push_back((b.clock_ns - a.clock_ns) /
                                  (b.number - a.number));
            }
        }
    }
    if (periods.empty()) {
        return 0;
    }
    const auto middle =
        periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
    std::nth_element(periods.begin(), middle, periods.end());
    return std::min(*middle, period_max_ns);
}

// The earliest point, or where there is none, the earliest line.
int64_t Frame::find_first(int64_t period_ns) const
{
    int64_t point_ns = std::numeric_limits<int64_t>::max();
    int64_t line_ns = point_ns;
    for (const Eye &eye : eyes_) {
        size_t begin = 0;
        for (const Line &line : eye.lines) {
            line_ns = std::min(line_ns, line.clock_ns);
            if (line.end > begin) { // a line's first point is its earliest
                point_ns = std::min(point_ns,
                                    line.clock_ns +
                                        pixel_ns(eye.points[begin], period_ns));
            }
            begin = line.end;
        }
    }
    const bool has_point = point_ns != std::numeric_limits<int64_t>::max();
    return has_point ? point_ns : line_ns;
}

void Frame::set_times(Eye &eye, int64_t period_ns, int64_t first_ns)
{
    size_t i = 0;
    for (const Line &line : eye.lines) {
        const int64_t from_ns = line.clock_ns - first_ns;
        for (; i < line.end; i++) {
            const int64_t at_ns = from_ns + pixel_ns(eye.points[i], period_ns);
            eye.points[i].time =
                static_cast<float>(static_cast<double>(at_ns) * 1e-9);
        }
    }
    if (!std::is_sorted(eye.points.begin(), eye.points.end(), is_earlier)) {
        std::stable_sort(eye.points.begin(), eye.points.end(), is_earlier);
    }
}

bool Frame::show_lines(Rings &rings) const
{
    uint32_t highest[2] = {0, 0}; // the second, the highest
    for (const Eye &eye : eyes_) {
        for (const Line &line : eye.lines) {
            if (line.number >= highest[1]) {
                highest[0] = highest[1];
                highest[1] = line.number;
            } else {
                highest[0] = std::max(highest[0], line.number);
            }
        }
    }
    return rings.see(highest[0], highest[1]);
}

// How many have none.
size_t Frame::set_rings(Eye &eye, unsigned index, const Rings &rings)
{
    size_t ringless = 0;
    for (Point &p : eye.points) {
        p.ring = rings.of(index, p.ring);
        ringless += p.ring == Rings::none ? 1 : 0;
    }
    return ringless;
}

bool Frame::finish(Rings &rings, Cloud &out)
{
    const bool has_grown = show_lines(rings);
    const int64_t period_ns = line_period_ns();
    const int64_t first_ns = find_first(period_ns);
    out.ringless = 0;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        out.ringless += set_rings(eyes_[i], i, rings);
        set_times(eyes_[i], period_ns, first_ns);
    }
    const std::vector<Point> &blue = eyes_[LUM_EYE_BLUE].points;
    const std::vector<Point> &green = eyes_[LUM_EYE_GREEN].points;
    out.stamp_ns = first_ns + offset_ns_;
    out.lines = rings.lines();
    out.points.resize(blue.size() + green.size());
    (void)std::merge(blue.begin(), blue.end(), green.begin(), green.end(),
                     out.points.begin(), is_earlier);
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
        p.ring = static_cast<uint16_t>(
            p.ring == Rings::none ? Rings::none : p.ring - above);
    }
}

} // namespace lumsdk_ros
