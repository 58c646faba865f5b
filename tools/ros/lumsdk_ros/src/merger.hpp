// Messages of the raw topics to packets in their order.
#ifndef LUMSDK_ROS_MERGER_HPP
#define LUMSDK_ROS_MERGER_HPP

#include "packet.hpp"

#include <lumsdk_ros/Packets.h>

#include <deque>
#include <functional>

namespace lumsdk_ros
{

struct MergerCounts {
    uint64_t lost = 0;    // batches of an eye that did not come, at least
    uint64_t refused = 0; // messages that contradict themselves
    uint64_t streams = 0; // begun
};

// Two topics come in two connections: which is ahead is chance. A packet goes
// out when both have told all that came before it; an eye of which nothing
// comes is waited for only so long.
class Merger
{
  public:
    using Output = std::function<void(const Packet &)>;
    using End = std::function<void()>;

    // end: the packets before and after it do not belong together.
    Merger(Output output, End end);

    // now_ns: monotonic.
    void take(const PacketsConstPtr &message, int64_t now_ns);

    // Time goes on; to be called several times a second.
    void tick(int64_t now_ns);

    const MergerCounts &counts() const
    {
        return counts_;
    }

  private:
    struct Eye {
        std::deque<PacketsConstPtr> queue;
        size_t next = 0;    // packet of the first message
        size_t next_at = 0; // where it begins in data
        bool has_begun = false;
        bool has_ended = false;
        uint64_t end = 0; // all before this number is here
        int64_t heard_ns = 0;
    };

    bool is_good(const Packets &m) const;
    void note(Eye &eye, const Packets &m, int64_t now_ns);
    uint64_t limit(int64_t now_ns) const;
    static bool first_of(const Eye &eye, uint64_t &number);
    void drop_empty(Eye &eye);
    void put_out(Eye &eye);
    void put_out_below(uint64_t number);
    void end_stream();

    Output output_;
    End end_;
    Eye eyes_[LUM_EYES];
    int64_t began_ns_ = 0;
    MergerCounts counts_;
};

} // namespace lumsdk_ros

#endif
