// The numbers of rings, without ROS.
#include "rings.hpp"

#include <cstdio>
#include <cstdlib>

using lumsdk_ros::Rings;

namespace
{

void check(bool is_so, const char *what)
{
    if (!is_so) {
        std::fprintf(stderr, "rings: not so: %s\n", what);
        std::exit(1);
    }
}

void unstated()
{
    Rings rings(0);
    check(!rings.see(62, 63) && rings.lines() == 64, "64 lines at first");
    check(rings.of(0, 63) == 63 && rings.of(1, 0) == 64, "green's follow");
    check(!rings.see(63, 64) && rings.lines() == 64, "one line may be damaged");
    check(!rings.see(63, 9000) && rings.lines() == 64, "wherever it is");
    check(rings.of(0, 64) == Rings::none && rings.of(1, 9000) == Rings::none,
          "it has no ring");
    check(rings.see(64, 64) && rings.lines() == 640, "two lines count");
    check(!rings.see(638, 639) && rings.of(1, 639) == 1279, "640 lines");
    check(!rings.see(62, 63) && rings.of(1, 0) == 640, "it does not fall");
    check(rings.see(640, 641) && rings.lines() == 32767, "more than 640");
    check(rings.of(1, 32766) == 65533, "the highest that a scan can have");
    check(rings.of(0, 32767) == Rings::none && rings.of(1, 32767) == Rings::none,
          "a line beyond it");
    check(!rings.see(65534, 65535) && rings.of(0, 65535) == Rings::none,
          "no scan has it");
}

void stated()
{
    Rings rings(640);
    check(!rings.see(62, 63) && rings.of(1, 0) == 640, "as it is stated");
    check(!rings.see(998, 999) && rings.of(1, 0) == 640, "it stays");
    check(rings.of(0, 640) == Rings::none, "and what is beyond has none");
    check(Rings(64).of(1, 63) == 127 && Rings(64).of(0, 64) == Rings::none,
          "64 of them");
    check(Rings(Rings::lines_max).of(1, Rings::lines_max - 1) < Rings::none,
          "no line's ring is the number that stands for none");
}

} // namespace

int main()
{
    unstated();
    stated();
    return 0;
}
