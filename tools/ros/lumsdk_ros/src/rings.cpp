#include "rings.hpp"

namespace lumsdk_ros
{

namespace
{

// What the sensor can be set to, and what its Y scan could hold at most.
constexpr uint32_t numbers[] = {64, 640, Rings::lines_max};

} // namespace

Rings::Rings(uint32_t stated)
    : is_stated_(stated != 0), lines_(is_stated_ ? stated : numbers[0])
{
}

bool Rings::see(uint32_t second, uint32_t highest)
{
    const uint32_t before = lines_;
    const bool grows = !is_stated_ && second >= lines_;
    for (const uint32_t number : numbers) {
        if (grows && highest >= lines_ && number > lines_) {
            lines_ = number;
        }
    }
    return lines_ != before;
}

uint16_t Rings::of(unsigned eye, uint32_t line) const
{
    const uint32_t ring = eye * lines_ + line;
    return line < lines_ ? static_cast<uint16_t>(ring) : none;
}

} // namespace lumsdk_ros
