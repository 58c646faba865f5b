// What a thread that must not wait has to say; another one says it.
#ifndef LUMSDK_ROS_NOTES_HPP
#define LUMSDK_ROS_NOTES_HPP

#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace lumsdk_ros
{

struct Note {
    enum Kind {
        info,
        warning,
        error,
        answer // to a command: for its topic too
    };
    Kind kind;
    std::string text;
};

class Notes
{
  public:
    void add(Note::Kind kind, std::string text)
    {
        const std::lock_guard<std::mutex> guard(lock_);
        if (notes_.size() < notes_max) {
            notes_.push_back({kind, std::move(text)});
        }
    }

    std::vector<Note> take()
    {
        const std::lock_guard<std::mutex> guard(lock_);
        return std::exchange(notes_, {});
    }

  private:
    static constexpr size_t notes_max = 1000;

    std::mutex lock_;
    std::vector<Note> notes_;
};

} // namespace lumsdk_ros

#endif
