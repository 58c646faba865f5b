#include "channel.hpp"

#include <utility>

namespace lumsdk_ros
{

namespace
{

constexpr size_t bytes_max = size_t{64} << 20;

} // namespace

size_t Channel::put(const lum_received *datagrams, size_t count)
{
    size_t dropped = 0;
    {
        const std::lock_guard<std::mutex> guard(lock_);
        for (size_t i = 0; i < count; i++) {
            const lum_received &d = datagrams[i];
            if (d.cut_short) {
                continue; // the session counts it
            }
            if (load_.bytes.size() + d.len > bytes_max) {
                dropped++;
                continue;
            }
            load_.items.push_back({load_.bytes.size(), d.len, d.utc_ns});
            load_.bytes.insert(load_.bytes.end(), d.bytes, d.bytes + d.len);
        }
    }
    news_.notify_one();
    return dropped;
}

void Channel::close()
{
    {
        const std::lock_guard<std::mutex> guard(lock_);
        is_closed_ = true;
    }
    news_.notify_one();
}

bool Channel::take(Load &load, std::chrono::milliseconds patience)
{
    load.items.clear();
    load.bytes.clear();
    std::unique_lock<std::mutex> guard(lock_);
    (void)news_.wait_for(guard, patience,
                         [this] { return is_closed_ || !load_.items.empty(); });
    std::swap(load, load_);
    return !is_closed_ || !load.items.empty();
}

} // namespace lumsdk_ros
