// The directions that every point of a bake shares, with the basis tabulated, and the sums over them.
//
// What picks directions is compiled for several instruction sets, without fused multiply-adds, so each of them gives
// the same bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transport/ray_scene.h"
#include "transport/row_sums.h"

namespace bakelight::transfer {

using formats::Float3;

// Zonal factors of the clamped cosine, or of that times what enters a surface of an index of refraction above 0.
std::vector<double> cosineFactors(int order, double entered_ior);

// One fixed set of directions of equal weight over the sphere.
class Quadrature {
 public:
  // Sets of different `turn` are the same one, turned at random; 0 is as it is.
  Quadrature(int order, int count, std::uint32_t turn = 0);

  std::size_t size() const { return directions_.size(); }
  double weight() const { return weight_; }          // 4π / count, steradians
  std::size_t rowSize() const { return row_size_; }  // order² in whole tiles; zeros behind
  const transport::RayBundle& directions() const { return directions_; }
  const float* row(std::uint32_t direction) const { return &basis_[direction * row_size_]; }

  // Σ over the chosen directions of weight · basis. Only the tiles that hold the first `coefficients` are
  // summed.
  void accumulate(std::span<const std::uint32_t> chosen, std::span<const float> weights,
                  std::size_t coefficients, std::span<double> sums) const;

 private:
  std::size_t row_size_;
  transport::RayBundle directions_;
  std::vector<float> basis_;
  double weight_;
};

// The directions above a tangent plane, compacted.
struct Hemisphere {
  transport::RayBundle rays;
  std::vector<std::uint32_t> directions;
  std::vector<float> cosines;
  std::size_t count = 0;  // the arrays hold that many; they are larger

  explicit Hemisphere(std::size_t size) : rays(size), directions(size), cosines(size) {}
  void collect(const Quadrature& quadrature, const Float3& normal);
  // Cosines times what enters a surface of that index of refraction.
  void enter(double relative_ior);
  std::span<const std::uint32_t> usedDirections() const { return std::span(directions).first(count); }
  std::span<const float> usedCosines() const { return std::span(cosines).first(count); }
};

}  // namespace bakelight::transfer
