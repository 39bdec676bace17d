#include "tools/atlas/flatten/float_rounding.h"

#include <algorithm>
#include <array>
#include <vector>

#include "tools/atlas/exact.h"

namespace bakelight::atlas {
namespace {

constexpr float kGrid = 0x1p-24f;  // spacing of floats below 1
constexpr int kPasses = 8;
constexpr std::array<int, 7> kSteps = {1, 2, 4, 8, 16, 32, 64};
constexpr std::array<std::array<int, 2>, 8> kWays = {
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};

int turn(const Triangle& t, std::span<const formats::Float2> texcoords) {
  const auto at = [&](std::size_t k) { return Vec2(texcoords[t[k]][0], texcoords[t[k]][1]); };
  return orientation(at(0), at(1), at(2));
}

// Tries places around the vertex, nearest first; those that lose a triangle which is fine are no good.
bool nudge(std::uint32_t vertex, std::uint32_t bad, std::span<const std::uint32_t> around,
           std::span<const Triangle> triangles, std::span<formats::Float2> texcoords) {
  const formats::Float2 before = texcoords[vertex];
  std::vector<std::uint32_t> fine;
  for (const std::uint32_t t : around)
    if (turn(triangles[t], texcoords) > 0) fine.push_back(t);
  for (const int step : kSteps)
    for (const auto& way : kWays) {
      const auto shift = [&](std::size_t axis) {
        return std::clamp(before[axis] + static_cast<float>(step * way[axis]) * kGrid, 0.0f, 1.0f);
      };
      texcoords[vertex] = {shift(0), shift(1)};
      const auto isFine = [&](std::uint32_t t) { return turn(triangles[t], texcoords) > 0; };
      if (isFine(bad) && std::all_of(fine.begin(), fine.end(), isFine)) return true;
    }
  texcoords[vertex] = before;
  return false;
}

}  // namespace

std::int64_t nudgeFlipped(std::span<const Triangle> triangles, std::span<formats::Float2> texcoords) {
  std::vector<std::uint32_t> bad;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (turn(triangles[t], texcoords) <= 0) bad.push_back(t);
  if (bad.empty()) return 0;
  std::vector<std::vector<std::uint32_t>> around(texcoords.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (const std::uint32_t v : triangles[t]) around[v].push_back(t);
  std::int64_t nudged = 0;
  for (int pass = 0; pass < kPasses && !bad.empty(); ++pass)
    std::erase_if(bad, [&](std::uint32_t t) {
      if (turn(triangles[t], texcoords) > 0) return true;
      return std::any_of(triangles[t].begin(), triangles[t].end(), [&](std::uint32_t v) {
        const bool moved = nudge(v, t, around[v], triangles, texcoords);
        nudged += moved;
        return moved;
      });
    });
  return nudged;
}

}  // namespace bakelight::atlas
