// R_d of a medium's three colors as kernels and factors ask for it many millions of times: from tables.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <Eigen/Core>
#include <vector>

#include "formats/medium.h"
#include "transport/diffusion.h"

namespace bakelight::kernels {

using Rgb = Eigen::Array3f;  // red, green, blue

// Of a medium in the asset's unit of length.
std::array<transport::DiffuseReflectance, 3> reflectanceOf(const formats::Medium& medium);

// Function of a distance, linear between nodes that are even in log(1 + distance / scale).
class RadialTable {
 public:
  static constexpr int kNodes = 4096;

  RadialTable() = default;
  template <class Function>  // Rgb(double distance)
  RadialTable(double scale, double farthest, const Function& function)
      : inverse_scale_(static_cast<float>(1 / scale)),
        nodes_per_log_(static_cast<float>((kNodes - 1) / std::log1p(farthest / scale))),
        values_(kNodes) {
    for (int i = 0; i < kNodes; ++i)
      values_[static_cast<std::size_t>(i)] =
          function(scale * std::expm1(std::log1p(farthest / scale) * i / (kNodes - 1)));
  }
  Rgb operator()(float distance) const {
    const float place = std::log1p(distance * inverse_scale_) * nodes_per_log_;
    const int node = std::min(static_cast<int>(place), kNodes - 2);
    const float share = std::min(place - static_cast<float>(node), 1.0F);
    const Rgb& from = values_[static_cast<std::size_t>(node)];
    return from + share * (values_[static_cast<std::size_t>(node) + 1] - from);
  }

 private:
  float inverse_scale_ = 1, nodes_per_log_ = 1;
  std::vector<Rgb> values_;
};

class Reflectance {
 public:
  // For distances up to `farthest`, among texels whose sides are from `least_texel` to `greatest_texel`.
  Reflectance(const std::array<transport::DiffuseReflectance, 3>& colors, double farthest, double least_texel,
              double greatest_texel);

  // R_d, in 1/area, as all functions here. Tables err by some 1e-5.
  Rgb exact(float distance) const { return exact_(distance); }
  // R_d from `radius` on, and below it a polynomial of the same value, slope and curvature there: what interpolation between points about
  // that far apart can follow.
  Rgb smoothed(float distance, float radius) const {
    if (distance >= radius) return exact_(distance);
    const float square = distance * distance;
    return constant_(radius) + square * (linear_(radius) + square * quadratic_(radius));
  }
  // R_d as texels of a band and side can carry it (DiffuseReflectance::bandLimited).
  std::uint32_t bandOf(float side) const;
  Rgb betweenTexels(float distance, float side, std::uint32_t band) const;
  // Radius that encloses all but that share of R_d on a plane, of each color, and the share of all light that is beyond one: of the color that has most.
  double reach(double share) const;
  double shareBeyond(double radius) const;
  double farthest() const { return farthest_; }

 private:
  const std::array<transport::DiffuseReflectance, 3>& colors_;
  RadialTable exact_, constant_, linear_, quadratic_;
  // By side of a texel, evenly in its logarithm; of distance, in sides, times the side squared.
  double farthest_, least_texel_, log_step_;
  std::vector<std::vector<Rgb>> bands_;
};

}  // namespace bakelight::kernels
