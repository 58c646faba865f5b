#include "source.hpp"

#include <thread>

namespace lumsdk_ros
{

namespace
{

constexpr int64_t view_ns = 100000000;
constexpr std::chrono::milliseconds patience(20);

class LiveSource : public Source
{
  public:
    LiveSource(const Options &options, const Outlet &outlet, Notes &notes)
        : sensor_(options.endpoint.address), pipeline_(options, outlet),
          notes_(notes), session_(new Session(options, channel_, notes)),
          decoder_([this] { run(); })
    {
    }

    ~LiveSource() override
    {
        session_.reset(); // and with it the laser
        decoder_.join();
    }

    SourceView view() const override
    {
        SourceView view;
        view.pipeline = pipeline_.view();
        view.has_session = true;
        view.session = session_->view();
        view.has_failed = view.session.is_broken || has_failed_;
        return view;
    }

    bool command(const std::string &text) override
    {
        session_->command(text);
        return true;
    }

  private:
    void take(const Load &load)
    {
        for (const Load::Item &item : load.items) {
            pipeline_.take(
                {load.bytes.data() + item.at, item.len, item.time_ns, sensor_});
        }
        if (load.items.empty()) {
            pipeline_.flush();
        }
        const int64_t now_ns = lum_time_monotonic_ns();
        if (now_ns - viewed_ns_ >= view_ns) {
            viewed_ns_ = now_ns;
            pipeline_.make_view();
        }
    }

    void run()
    {
        Load load;
        try {
            while (channel_.take(load, patience)) {
                take(load);
            }
            pipeline_.finish(true);
        } catch (const std::exception &e) {
            notes_.add(Note::error, e.what());
            has_failed_ = true;
        }
    }

    const uint32_t sensor_;
    Channel channel_;
    Pipeline pipeline_;
    Notes &notes_;
    int64_t viewed_ns_ = 0;
    std::atomic<bool> has_failed_{false};
    std::unique_ptr<Session> session_;
    std::thread decoder_;
};

} // namespace

std::unique_ptr<Source> make_live_source(const Options &options,
                                         const Outlet &outlet, Notes &notes)
{
    return std::unique_ptr<Source>(new LiveSource(options, outlet, notes));
}

} // namespace lumsdk_ros
