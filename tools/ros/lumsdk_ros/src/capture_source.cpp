#include "source.hpp"

#include <atomic>
#include <stdexcept>
#include <thread>

namespace lumsdk_ros
{

namespace
{

constexpr int64_t second_ns = 1000000000;
constexpr int64_t slice_ns = second_ns / 20; // of a wait
constexpr int64_t ahead_ns = second_ns / 500;
constexpr int64_t view_ns = second_ns / 10;

struct CloseCapture {
    void operator()(lum_capture *capture) const
    {
        lum_capture_close(capture);
    }
};

using Capture = std::unique_ptr<lum_capture, CloseCapture>;

Capture open_capture(const std::string &path)
{
    lum_error error = {""};
    lum_capture *capture = nullptr;
    if (lum_capture_open(path.c_str(), &capture, &error) != 0) {
        throw std::runtime_error("~source: " + std::string(error.text));
    }
    return Capture(capture);
}

// Whether a capture brings a text of this kind (docs/formats.md, "Provenance").
bool has_text(const lum_capture *capture, const std::string &kind)
{
    const std::string mark = "# lumsdk " + kind + " ";
    for (size_t s = 0; s < lum_capture_source_count(capture); s++) {
        for (size_t i = 0; i < lum_capture_comment_count(capture, s); i++) {
            size_t len = 0;
            const char *text = lum_capture_comment(capture, s, i, &len);
            if (len > mark.size() &&
                mark.compare(0, mark.size(), text, mark.size()) == 0) {
                return true;
            }
        }
    }
    return false;
}

class CaptureSource : public Source
{
  public:
    CaptureSource(const Options &options, const Outlet &outlet, Notes &notes)
        : options_(options), outlet_(outlet), notes_(notes),
          pipeline_(options, outlet), capture_(open_capture(options.source))
    {
        warn_of_text("calibration", options.has_calibration);
        warn_of_text("profile", options.has_profile);
        thread_ = std::thread([this] { run(); });
    }

    ~CaptureSource() override
    {
        stop_ = true;
        thread_.join();
    }

    SourceView view() const override
    {
        SourceView view;
        view.pipeline = pipeline_.view();
        view.has_ended = has_ended_;
        view.has_failed = has_failed_;
        return view;
    }

    bool command(const std::string &) override
    {
        return false;
    }

  private:
    // The transforms are out before it is open.
    void warn_of_text(const std::string &kind, bool is_given)
    {
        if (!is_given && has_text(capture_.get(), kind)) {
            notes_.add(Note::warning,
                       options_.source + " has a " + kind +
                           " of its own, which this node does not use: give "
                           "it by ~" +
                           kind);
        }
    }

    // Once: a loop meets the same again.
    void warn_of_records(const lum_demux *demux, const std::string &broken)
    {
        lum_error text = {""};
        has_warned_ = true;
        if (lum_capture_damaged(capture_.get(), &text) != 0) {
            notes_.add(Note::warning, text.text);
        }
        if (!broken.empty()) {
            notes_.add(Note::warning, broken);
        }
        for (size_t i = 0;
             lum_capture_remark(capture_.get(), demux, 0, i, &text); i++) {
            notes_.add(Note::warning, options_.source + ": " + text.text);
        }
    }

    void run()
    {
        try {
            while (!stop_ && !outlet_.has_audience()) {
                lum_time_sleep_until(lum_time_monotonic_ns() + slice_ns);
            }
            play();
            while (!stop_ && options_.loops && pipeline_.view().packets != 0) {
                capture_ = open_capture(options_.source);
                play();
            }
            has_ended_ = true;
        } catch (const std::exception &e) {
            notes_.add(Note::error, e.what());
            has_failed_ = true;
        }
    }

    void play()
    {
        lum_record record;
        lum_error error = {""};
        int status = 0;
        has_time_ = false;
        while (!stop_ && (status = lum_capture_next(capture_.get(), &record,
                                                    &error)) == 1) {
            wait_for(record.time_ns);
            record.time_ns += shift_ns_;
            pipeline_.take(record, lum_capture_interface(capture_.get()));
        }
        const lum_demux *demux = pipeline_.end();
        if (!has_warned_) {
            warn_of_records(demux, status < 0 ? error.text : "");
        }
        pipeline_.finish(true);
        if (!stop_ && pipeline_.view().decoder.clouds == 0) {
            notes_.add(Note::warning, options_.source +
                                          " holds no frame of the sensor; "
                                          "lumdump tells what is in it");
        }
    }

    // Until the capture's time has come.
    void wait_for(int64_t time_ns)
    {
        const int64_t now_ns = lum_time_monotonic_ns();
        if (!has_time_) {
            has_time_ = true;
            first_ns_ = time_ns;
            began_ns_ = now_ns;
            shift_ns_ =
                options_.shifts_to_now ? lum_time_utc_ns() - time_ns : 0;
        }
        if (now_ns - viewed_ns_ >= view_ns) {
            viewed_ns_ = now_ns;
            pipeline_.make_view();
        }
        if (options_.speed <= 0.0) {
            return;
        }
        const auto since = static_cast<double>(time_ns - first_ns_);
        const int64_t due_ns =
            began_ns_ + static_cast<int64_t>(since / options_.speed);
        for (int64_t at_ns = now_ns; !stop_ && due_ns - at_ns > ahead_ns;
             at_ns = lum_time_monotonic_ns()) {
            lum_time_sleep_until(std::min(due_ns, at_ns + slice_ns));
        }
    }

    const Options options_;
    const Outlet &outlet_;
    Notes &notes_;
    Pipeline pipeline_;
    Capture capture_;
    bool has_time_ = false;
    bool has_warned_ = false;
    int64_t first_ns_ = 0;
    int64_t began_ns_ = 0;
    int64_t shift_ns_ = 0;
    int64_t viewed_ns_ = 0;
    std::atomic<bool> stop_{false};
    std::atomic<bool> has_ended_{false};
    std::atomic<bool> has_failed_{false};
    std::thread thread_;
};

} // namespace

std::unique_ptr<Source> make_capture_source(const Options &options,
                                            const Outlet &outlet, Notes &notes)
{
    return std::unique_ptr<Source>(new CaptureSource(options, outlet, notes));
}

} // namespace lumsdk_ros
