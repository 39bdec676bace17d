#include "patch/periodic_places.h"

#include <algorithm>
#include <array>
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
      : periods_{period_x, period_y}, cell_(kCells * kTolerance * std::max(period_x, period_y)) {}

  std::uint32_t firstAt(const Vec3& position, std::uint32_t vertex) {
    // A place beside its cell's wall may be found in the next cell.
    std::array<std::array<std::int64_t, 2>, 3> cells;
    std::array<int, 3> count;
    for (std::size_t c = 0; c < 3; ++c) {
      const double at = wrapped(position[static_cast<Eigen::Index>(c)], c) / cell_;
      const double cell = std::floor(at), rest = at - cell;
      cells[c][0] = cellOf(cell, c);
      cells[c][1] = cellOf(rest < 0.5 ? cell - 1 : cell + 1, c);
      count[c] = rest * kCells < 1 || (1 - rest) * kCells < 1 ? 2 : 1;
    }
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i)
          if (const auto found = first_.find(keyOf(cells[0][i], cells[1][j], cells[2][k]));
              found != first_.end())
            return found->second;
    first_.emplace(keyOf(cells[0][0], cells[1][0], cells[2][0]), vertex);
    return vertex;
  }

 private:
  static constexpr double kTolerance = 1e-6, kCells = 8;  // a cell is so many tolerances wide

  double wrapped(double at, std::size_t axis) const {
    return axis < 2 ? at - periods_[axis] * std::floor(at / periods_[axis]) : at;
  }
  // What lies beyond the period is at its other end.
  std::int64_t cellOf(double cell, std::size_t axis) const {
    if (axis == 2) return static_cast<std::int64_t>(cell);
    return static_cast<std::int64_t>(std::floor(wrapped((cell + 0.5) * cell_, axis) / cell_));
  }
  static std::uint64_t keyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
    constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15ULL;
    return (static_cast<std::uint64_t>(x) * kOdd + static_cast<std::uint64_t>(y)) * kOdd +
           static_cast<std::uint64_t>(z);
  }

  std::array<double, 2> periods_;
  double cell_;
  std::unordered_map<std::uint64_t, std::uint32_t> first_;
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
