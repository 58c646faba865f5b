// Numbers of rings: a ring is one line of one eye.
#ifndef LUMSDK_ROS_RINGS_HPP
#define LUMSDK_ROS_RINGS_HPP

#include <cstdint>

namespace lumsdk_ros
{

// The blue eye's ring is the line, the green eye's the line and the number of
// lines. That number is stated, or else 64 until a frame shows that there are
// more; it never falls again, so that no number of a ring has two meanings.
class Rings
{
  public:
    static constexpr uint32_t lines_max = 32767;
    static constexpr uint16_t none = UINT16_MAX; // of a line beyond the number

    // stated: the number of lines; 0: it is not.
    explicit Rings(uint32_t stated);

    uint32_t lines() const
    {
        return lines_;
    }

    // The two highest lines of a frame, of both eyes together. One alone beyond
    // the number can be of a damaged packet. Whether the number has grown.
    bool see(uint32_t second, uint32_t highest);

    uint16_t of(unsigned eye, uint32_t line) const;

  private:
    bool is_stated_;
    uint32_t lines_;
};

} // namespace lumsdk_ros

#endif
