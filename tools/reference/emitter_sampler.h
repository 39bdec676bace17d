// Near emitters, sampled by what a surface point receives of them.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/reference/distant_light_sampler.h"
#include "transport/light_rig.h"

namespace bakelight::reference {

using transport::Vec3;

// Both sides shine alike in all directions, so power is luminance × area. Up to 64 neighbouring triangles of
// one radiance make a cluster; a point draws one by power × largest cosine ÷ distance² (as light hierarchies
// do: Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights"), then a place on it by area. Clusters
// wholly below the surface are never drawn. Cost: linear in the clusters.
class EmitterSampler {
 public:
  // `emitters` is in the world (transport::emitterMesh).
  explicit EmitterSampler(const transport::EmitterMesh& emitters);

  Rgb radiance(std::uint32_t triangle) const { return triangles_[triangle].radiance; }

  struct Sample {
    Vec3 direction = Vec3::UnitY();  // unit, from the point
    double distance = 0;
    std::uint32_t triangle = 0;
    double density_per_sr = 0;  // 0 if nothing shines above the surface, or edge-on
  };
  // The image of a point of the unit square, for a surface at `origin`.
  Sample sample(const Vec3& origin, const Vec3& normal, double u, double v) const;

  // How densely sample() visits a point of `triangle` that lies at `distance` along `direction` (unit).
  double densityPerSr(const Vec3& origin, const Vec3& normal, std::uint32_t triangle, const Vec3& direction,
                      double distance) const;

 private:
  struct Triangle {
    Vec3 corner, edge1, edge2, normal;
    Rgb radiance;
    std::uint32_t cluster;
  };
  struct Cluster {
    Vec3 center = Vec3::Zero();
    double radius = 0, power = 0, area = 0;
    std::size_t first = 0;
    std::vector<double> cumulative_area;  // of its triangles, from 0 to 1
  };
  void addCluster(std::size_t first, std::size_t end);
  double weight(const Cluster& cluster, const Vec3& origin, const Vec3& normal) const;
  double densityOnTriangle(const Triangle& triangle, const Vec3& direction, double distance) const;

  std::vector<Triangle> triangles_;
  std::vector<Cluster> clusters_;
};

}  // namespace bakelight::reference
