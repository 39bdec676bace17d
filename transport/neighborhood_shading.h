// What falls on receivers around an object, from its neighborhood transfer: what the player's shaders compute, on the CPU.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "formats/neighborhood.h"
#include "formats/triangle_mesh.h"
#include "transport/lights.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// The points of a ground as vertices, two triangles a cell, upwards counter-clockwise, in the object's space.
formats::TriangleMesh groundMesh(const formats::GroundTransfer& ground);
// Rows of its table with the open plane's own light: what leaves a white plane per unit light coefficient, as transfer vectors.
std::vector<float> groundVectors(const formats::Neighborhood& neighborhood);

// A ground fades out before it ends: 1 up to kFadeStart of the way from its middle to its border along an ellipse, 0 on it.
struct GroundFade {
  std::array<float, 2> middle = {0, 0}, half_size = {1, 1};  // x, z
  double opacityAt(double x, double z) const;
};
inline constexpr double kFadeStart = 0.5;
GroundFade fadeOf(const formats::GroundTransfer& ground);

// The ground under a light.
class GroundShading {
 public:
  // Throws std::invalid_argument if there is no ground, or its table does not fit it.
  explicit GroundShading(const formats::Neighborhood& neighborhood);

  // In the object's frame, at least order² coefficients; `near`, empty or as many, counts as if from far away. Throws std::invalid_argument for fewer.
  void setLight(std::span<const Float3> distant, std::span<const Float3> near);
  // Irradiance ÷ π, linear over the triangles of groundMesh. Beyond the grid: that of its border.
  Float3 radiosityAt(double x, double z) const;
  const std::vector<Float3>& vertexRadiosity() const { return radiosity_; }
  const GroundFade& fade() const { return fade_; }

  // Radiance of a ground of that albedo, premultiplied by its opacity, along a ray in the object's space; nothing where it does not meet the upper side.
  formats::Float4 seen(const Vec3& eye, const Vec3& direction, const Float3& albedo) const;

 private:
  formats::GroundTransfer ground_;  // without its table
  int order_, channels_;
  std::vector<float> vectors_;
  std::vector<Float3> radiosity_;
  GroundFade fade_;
};

// Space around an object under a light.
class VolumeShading {
 public:
  // Throws std::invalid_argument if there is no volume, or its table does not fit it.
  explicit VolumeShading(const formats::Neighborhood& neighborhood);

  // As GroundShading::setLight. Cost: points × channels · 18 · order² multiply-adds, on all TBB threads.
  void setLight(std::span<const Float3> distant, std::span<const Float3> near);
  // Irradiance ÷ π on a receiver at a point, with a normal (unit), in the object's frame, by the coefficients that are kept: the change interpolated between eight points, none beyond the
  // grid, that of the lowest points below it.
  Float3 radiosityAt(const Vec3& position, const Vec3& normal) const;

 private:
  formats::VolumeTransfer volume_;  // without its table
  int order_, channels_;
  std::vector<float> matrices_;
  std::vector<Float3> light_;    // 18
  std::vector<Float3> changes_;  // points × 18
};

}  // namespace bakelight::transport
