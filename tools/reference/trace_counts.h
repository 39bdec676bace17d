// What tracing took and what it lost.
#pragma once

#include <cstdint>

namespace bakelight::reference {

struct TraceCounts {
  std::uint64_t rays = 0;
  std::uint64_t walks = 0;       // through media
  std::uint64_t open_walks = 0;  // that left the mesh through a hole: what they would have brought is lost
  std::uint64_t cut_walks = 0;   // that came to the most events: lost too

  TraceCounts& operator+=(const TraceCounts& other) {
    rays += other.rays;
    walks += other.walks;
    open_walks += other.open_walks;
    cut_walks += other.cut_walks;
    return *this;
  }
};

}  // namespace bakelight::reference
