#include "source.hpp"

#include <ros/subscriber.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <thread>

namespace lumsdk_ros
{

namespace
{

constexpr uint32_t batches_queued = 500;
constexpr size_t waiting_max = 1000;
constexpr std::chrono::milliseconds patience(50);

class BagSource : public Source
{
  public:
    BagSource(const ros::NodeHandle &handle, const Options &options,
              const Outlet &outlet, Notes &notes)
        : options_(options), notes_(notes), pipeline_(options, outlet),
          merger_([this](const Packet &p) { take(p); },
                  [this] {
                      pipeline_.finish(false);
                      has_shift_ = false;
                  }),
          thread_([this] { run(); })
    {
        ros::NodeHandle node(handle);
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            raw_[eye] = node.subscribe(raw_topics[eye], batches_queued,
                                       &BagSource::take_message, this,
                                       ros::TransportHints().tcpNoDelay());
        }
    }

    ~BagSource() override
    {
        for (ros::Subscriber &s : raw_) {
            s.shutdown();
        }
        {
            const std::lock_guard<std::mutex> guard(lock_);
            stop_ = true;
        }
        news_.notify_one();
        thread_.join();
    }

    SourceView view() const override
    {
        SourceView view;
        view.pipeline = pipeline_.view();
        view.has_merger = true;
        view.has_failed = has_failed_;
        const std::lock_guard<std::mutex> guard(lock_);
        view.merger = counts_;
        view.messages_dropped = dropped_;
        return view;
    }

    bool command(const std::string &) override
    {
        return false;
    }

  private:
    void take_message(const PacketsConstPtr &message)
    {
        {
            const std::lock_guard<std::mutex> guard(lock_);
            if (waiting_.size() >= waiting_max) {
                dropped_++;
                return;
            }
            waiting_.push_back(message);
        }
        news_.notify_one();
    }

    void take(Packet packet)
    {
        if (!has_shift_) {
            has_shift_ = true;
            shift_ns_ =
                options_.shifts_to_now ? lum_time_utc_ns() - packet.time_ns : 0;
        }
        packet.time_ns += shift_ns_;
        if (!options_.has_sensor || packet.sensor == options_.sensor) {
            pipeline_.take_again(packet);
        }
    }

    // False: it is time to end.
    bool wait(std::deque<PacketsConstPtr> &out)
    {
        std::unique_lock<std::mutex> guard(lock_);
        (void)news_.wait_for(guard, patience,
                             [this] { return stop_ || !waiting_.empty(); });
        out.swap(waiting_);
        counts_ = merger_.counts();
        return !stop_;
    }

    void run()
    {
        std::deque<PacketsConstPtr> messages;
        try {
            while (wait(messages)) {
                for (const PacketsConstPtr &m : messages) {
                    merger_.take(m, lum_time_monotonic_ns());
                }
                messages.clear();
                merger_.tick(lum_time_monotonic_ns());
                pipeline_.make_view();
            }
        } catch (const std::exception &e) {
            notes_.add(Note::error, e.what());
            has_failed_ = true;
        }
    }

    const Options options_;
    Notes &notes_;
    Pipeline pipeline_;
    Merger merger_;
    bool has_shift_ = false;
    int64_t shift_ns_ = 0;
    std::atomic<bool> has_failed_{false};
    ros::Subscriber raw_[LUM_EYES];

    mutable std::mutex lock_; // guards what follows
    std::condition_variable news_;
    std::deque<PacketsConstPtr> waiting_;
    MergerCounts counts_;
    uint64_t dropped_ = 0;
    bool stop_ = false;

    std::thread thread_;
};

} // namespace

std::unique_ptr<Source> make_bag_source(const ros::NodeHandle &node,
                                        const Options &options,
                                        const Outlet &outlet, Notes &notes)
{
    return std::unique_ptr<Source>(new BagSource(node, options, outlet, notes));
}

} // namespace lumsdk_ros
