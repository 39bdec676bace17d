// Near emitters, sampled by area × power.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/distant_light_sampler.h"
#include "transport/light_rig.h"

namespace bakelight::reference {

using transport::Rgb;
using transport::Vec3;

// Both sides shine alike in all directions, so power is luminance × area.
class EmitterSampler {
 public:
  // `emitters` is in the world (transport::emitterMesh).
  explicit EmitterSampler(const transport::EmitterMesh& emitters);

  bool isLit() const { return !cumulative_power_.empty() && cumulative_power_.back() > 0; }
  Rgb radiance(std::uint32_t triangle) const { return triangles_[triangle].radiance; }

  struct Sample {
    Vec3 position;
    std::uint32_t triangle;
  };
  // The image of a point of the unit square. Not to be called if !isLit().
  Sample sample(double u, double v) const;

  // How densely sample() visits a point of `triangle`, per solid angle as seen from `distance` along
  // `direction` (unit); infinite edge-on.
  double densityPerSr(std::uint32_t triangle, const Vec3& direction, double distance) const;

 private:
  struct Triangle {
    Vec3 corner, edge1, edge2, normal;
    Rgb radiance;
    double density_per_area = 0;
  };
  std::vector<Triangle> triangles_;
  std::vector<double> cumulative_power_;  // from 0 to 1
};

}  // namespace bakelight::reference
