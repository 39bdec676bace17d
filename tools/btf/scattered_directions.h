// Interpolation between directions of the hemisphere that lie anyhow.
//
// Linear over the Delaunay triangles of the stereographic plane (x, y)/(1 + z), which are those of the sphere, as the
// projection keeps circles. At a direction that was measured the value is what was measured; weights are never
// negative, so that nothing beyond the values appears, neither light nor its lack; a constant comes back to
// rounding, and the error for a smooth function falls with the square of the spacing. Smoother weights
// (Gaussians, moving least squares) would blur the highlights of a set as sparse as these, or overshoot beside
// them. Beyond the outermost directions the value of the nearest place on their border is taken.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "formats/btf.h"
#include "transport/vector_types.h"

namespace bakelight::btf {

using transport::Vec3;

Vec3 vectorOf(const formats::BtfDirection& direction);

class ScatteredDirections {
 public:
  // One or more.
  explicit ScatteredDirections(std::span<const Vec3> directions);

  struct Share {
    int index;
    double weight;
  };
  // Weights above 0 that sum to 1, of at most three directions; z of the direction is not below 0.
  std::vector<Share> shares(const Vec3& direction) const;

 private:
  std::vector<std::array<double, 2>> points_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::array<int, 2>> border_;
};

}  // namespace bakelight::btf
