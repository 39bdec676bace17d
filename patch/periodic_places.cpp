#include "patch/periodic_places.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "transport/vector_types.h"

namespace bakelight::patch {
namespace {

using transport::Vec3;

// First vertices by their places, modulo the periods.
class Places {
 public:
  Places(double period_x, double period_y)
      : period_x_(period_x), period_y_(period_y), cell_(1e-6 * std::max(period_x, period_y)) {}

  std::uint32_t firstAt(const Vec3& position, std::uint32_t vertex) {
    const Vec3 place(wrapped(position.x(), period_x_), wrapped(position.y(), period_y_), position.z());
    // One that lies beside the cell's wall, or the period's, is found from the next cell.
    for (int k = 0; k < 27; ++k) {
      const Vec3 shifted = place + cell_ * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const auto found = cells_.find(keyOf(shifted));
      if (found != cells_.end()) return found->second;
    }
    cells_.emplace(keyOf(place), vertex);
    return vertex;
  }

 private:
  static double wrapped(double at, double period) { return at - period * std::floor(at / period); }
  std::uint64_t keyOf(const Vec3& place) const {
    std::uint64_t key = 0;
    const Vec3 inside(wrapped(place.x(), period_x_), wrapped(place.y(), period_y_), place.z());
    for (int c = 0; c < 3; ++c)
      key = key * 0x9e3779b97f4a7c15ULL +
            static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(inside[c] / cell_)));
    return key;
  }

  double period_x_, period_y_, cell_;
  std::unordered_map<std::uint64_t, std::uint32_t> cells_;
};

}  // namespace

std::vector<std::uint32_t> periodicPlaces(const formats::TriangleMesh& mesh, double period_x,
                                          double period_y) {
  Places places(period_x, period_y);
  std::vector<std::uint32_t> first(mesh.vertexCount());
  for (std::uint32_t v = 0; v < first.size(); ++v)
    first[v] = places.firstAt(transport::vec3(mesh.positions[v]), v);
  return first;
}

}  // namespace bakelight::patch
