#include "transport/morton.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace bakelight::transport {
namespace {

constexpr double kCells = 0x1p21;

// Two zero bits between any two of the lowest 21.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffffU;
  bits = (bits | bits << 16) & 0x001f0000ff0000ffU;
  bits = (bits | bits << 8) & 0x100f00f00f00f00fU;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3U;
  return (bits | bits << 2) & 0x1249249249249249U;
}

}  // namespace

std::vector<std::uint32_t> mortonOrder(std::span<const formats::Float3> points) {
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const formats::Float3& p : points)
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min<double>(low[c], p[c]);
      high[c] = std::max<double>(high[c], p[c]);
    }
  double side = 0;
  for (std::size_t c = 0; c < 3; ++c) side = std::max(side, high[c] - low[c]);
  const double scale = side > 0 ? kCells / side : 0;

  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    std::uint64_t key = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double cell = std::clamp((points[i][c] - low[c]) * scale, 0.0, kCells - 1);
      key |= spread(static_cast<std::uint64_t>(cell)) << c;
    }
    keys[i] = {key, static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(keys.begin(), keys.end(), [&](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    return points[a.second] != points[b.second] ? points[a.second] < points[b.second] : a.second < b.second;
  });
  std::vector<std::uint32_t> order(points.size());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
  return order;
}

}  // namespace bakelight::transport
