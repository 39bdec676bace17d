#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "tools/mesomesh/synthesis/appearance.h"

namespace bakelight::mesomesh {
namespace {

// Similar places closer than this many steps are the same feature, which its neighbors propose already.
constexpr double kApartSteps = 3;

struct Place {
  Appearance appearance;
  std::int16_t x, y;
};

int squaredDistance(const Appearance& a, const Appearance& b) {
  int sum = 0;
  for (int d = 0; d < kAppearanceSize; ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

int apart(int a, int b, int side, bool periodic) {
  const int distance = std::abs(a - b);
  return periodic ? std::min(distance, side - distance) : distance;
}

}  // namespace

// Exact: places are sorted by their first component, in which a search walks outwards until that alone is
// further than the best.
void AppearanceLevel::findSimilar(int count) {
  const double most_apart = std::min(width_, height_) / 4.0;
  const double apart_texels = std::min(kApartSteps * static_cast<double>(step_) / kOneTexel, most_apart);
  const double apart_squared = apart_texels * apart_texels;
  std::vector<Place> places;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const FixedPoint at = {x << kFixedBits, y << kFixedBits};
      Place place{{}, static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
      std::copy_n(appearance(at), kAppearanceSize, place.appearance.begin());
      places.push_back(place);
    }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.appearance[0] < b.appearance[0]; });

  similar_count_ = count;
  similar_.resize(places.size() * static_cast<std::size_t>(count));
  const auto size = static_cast<std::ptrdiff_t>(places.size());
  tbb::parallel_for(std::ptrdiff_t{0}, size, [&](std::ptrdiff_t own) {
    const Place& place = places[own];
    std::array<const Place*, 8> chosen = {&place};
    const auto eligible = [&](const Place& other, int already) {
      if (!contains({other.x << kFixedBits, other.y << kFixedBits})) return false;
      for (int c = 0; c < already; ++c) {
        const double across = apart(other.x, chosen[c]->x, width_, periodic_);
        const double up = apart(other.y, chosen[c]->y, height_, periodic_);
        if (across * across + up * up < apart_squared || chosen[c] == &other) return false;
      }
      return true;
    };
    auto* list = similar_.data() + (static_cast<std::size_t>(place.y) * width_ + place.x) * count;
    for (int k = 0; k < count; ++k) {
      int best = std::numeric_limits<int>::max();
      const Place* best_place = &place;
      const auto consider = [&](const Place& other) {
        const int distance = squaredDistance(place.appearance, other.appearance);
        if (distance < best && eligible(other, k + 1)) best = distance, best_place = &other;
      };
      bool below = true, above = true;
      for (std::ptrdiff_t away = 1; below || above; ++away) {
        for (const bool up : {false, true}) {
          bool& open = up ? above : below;
          const std::ptrdiff_t other = up ? own + away : own - away;
          if (!open) continue;
          open = other >= 0 && other < size;
          if (!open) continue;
          const int first = places[other].appearance[0] - place.appearance[0];
          if (first * first >= best)
            open = false;
          else
            consider(places[other]);
        }
      }
      chosen[static_cast<std::size_t>(k) + 1] = best_place;
      list[k] = {static_cast<std::uint16_t>(best_place->x), static_cast<std::uint16_t>(best_place->y)};
    }
  });
}

}  // namespace bakelight::mesomesh
