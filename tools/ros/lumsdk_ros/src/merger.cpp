#include "merger.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace lumsdk_ros
{

namespace
{

// The longest wait for an eye.
constexpr int64_t patience_ns = 500000000;

} // namespace

Merger::Merger(Output output, End end)
    : output_(std::move(output)), end_(std::move(end))
{
}

bool Merger::is_good(const Packets &m) const
{
    const size_t count = m.places.size();
    const size_t bytes =
        std::accumulate(m.lengths.begin(), m.lengths.end(), size_t{0});
    return m.eye < LUM_EYES && m.begin <= m.end && m.stamps.size() == count &&
           m.lengths.size() == count && m.data.size() == bytes &&
           std::is_sorted(m.places.begin(), m.places.end()) &&
           (count == 0 || m.places.back() < m.end - m.begin);
}

void Merger::note(Eye &eye, const Packets &m, int64_t now_ns)
{
    if (eye.has_begun && m.begin > eye.end) {
        counts_.lost++;
    }
    eye.has_begun = true;
    eye.has_ended = m.last;
    eye.end = m.end;
    eye.heard_ns = now_ns;
}

void Merger::take(const PacketsConstPtr &message, int64_t now_ns)
{
    if (!is_good(*message)) {
        counts_.refused++;
        return;
    }
    Eye &eye = eyes_[message->eye];
    if (eye.has_begun && (eye.has_ended || message->begin < eye.end)) {
        end_stream();
    }
    if (!eyes_[LUM_EYE_BLUE].has_begun && !eyes_[LUM_EYE_GREEN].has_begun) {
        began_ns_ = now_ns;
        counts_.streams++;
    }
    note(eye, *message, now_ns);
    eye.queue.push_back(message);
    tick(now_ns);
}

// Up to where both eyes, or the one that speaks, have told all.
uint64_t Merger::limit(int64_t now_ns) const
{
    uint64_t least = std::numeric_limits<uint64_t>::max();
    uint64_t most = 0;
    for (const Eye &eye : eyes_) {
        const int64_t heard_ns = eye.has_begun ? eye.heard_ns : began_ns_;
        const bool is_waited_for =
            !eye.has_ended && now_ns - heard_ns < patience_ns;
        most = std::max(most, eye.end);
        if (is_waited_for) {
            least = std::min(least, eye.end);
        }
    }
    return std::min(least, most);
}

void Merger::tick(int64_t now_ns)
{
    const bool has_begun =
        eyes_[LUM_EYE_BLUE].has_begun || eyes_[LUM_EYE_GREEN].has_begun;
    if (!has_begun) {
        return;
    }
    put_out_below(limit(now_ns));
    const Eye &blue = eyes_[LUM_EYE_BLUE];
    const Eye &green = eyes_[LUM_EYE_GREEN];
    const bool is_late =
        now_ns - std::max(blue.heard_ns, green.heard_ns) >= patience_ns;
    if ((blue.has_ended && green.has_ended) ||
        (is_late && (blue.has_ended || green.has_ended))) {
        end_stream();
    }
}

void Merger::drop_empty(Eye &eye)
{
    while (!eye.queue.empty() && eye.next == eye.queue.front()->places.size()) {
        eye.queue.pop_front();
        eye.next = 0;
        eye.next_at = 0;
    }
}

bool Merger::first_of(const Eye &eye, uint64_t &number)
{
    if (eye.queue.empty()) {
        return false;
    }
    const Packets &m = *eye.queue.front();
    number = m.begin + m.places[eye.next];
    return true;
}

void Merger::put_out(Eye &eye)
{
    const Packets &m = *eye.queue.front();
    Packet packet = {};
    packet.bytes = m.data.data() + eye.next_at;
    packet.len = m.lengths[eye.next];
    packet.time_ns = static_cast<int64_t>(m.stamps[eye.next].toNSec());
    packet.sensor = m.sensor;
    output_(packet);
    eye.next_at += packet.len;
    eye.next++;
}

void Merger::put_out_below(uint64_t number)
{
    Eye &blue = eyes_[LUM_EYE_BLUE];
    Eye &green = eyes_[LUM_EYE_GREEN];
    for (;;) {
        uint64_t b = number;
        uint64_t g = number;
        drop_empty(blue);
        drop_empty(green);
        (void)first_of(blue, b);
        (void)first_of(green, g);
        if (std::min(b, g) >= number) {
            return;
        }
        put_out(b < g ? blue : green);
    }
}

void Merger::end_stream()
{
    put_out_below(std::numeric_limits<uint64_t>::max());
    for (Eye &eye : eyes_) {
        eye = Eye();
    }
    end_();
}

} // namespace lumsdk_ros
