// R_d of a medium's three colors as kernels and factors ask for it many millions of times: from tables. Where the medium varies, a place
// among uniform ones, which comes from the way that light takes (transport/medium_field.h).
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <Eigen/Core>
#include <vector>

#include "formats/medium.h"
#include "transport/diffusion.h"
#include "transport/medium_field.h"

namespace bakelight::kernels {

using Rgb = Eigen::Array3f;  // red, green, blue

using transport::Vec3;
using Place = transport::MediumField::Place;

// Of a medium without its veins, in the asset's unit of length: of one color, and of all.
transport::ScatteringCoefficients coefficientsOf(const formats::Medium& medium, std::size_t color);
std::array<transport::DiffuseReflectance, 3> reflectanceOf(const formats::Medium& medium);

// Function of a distance for each of some media, linear between nodes that are even in log(1 + distance / scale).
template <class Value>
class RadialTable {
 public:
  static constexpr int kNodes = 4096;

  RadialTable() = default;
  template <class Function>  // Value(double distance, std::size_t medium); at the same time for several media
  RadialTable(double scale, double farthest, std::size_t media, const Function& function)
      : inverse_scale_(static_cast<float>(1 / scale)),
        nodes_per_log_(static_cast<float>((kNodes - 1) / std::log1p(farthest / scale))),
        media_(media),
        values_(kNodes * media) {
    tbb::parallel_for(std::size_t{0}, media, [&](std::size_t medium) {
      for (std::size_t i = 0; i < kNodes; ++i)
        values_[i * media_ + medium] = function(
            scale * std::expm1(std::log1p(farthest / scale) * static_cast<double>(i) / (kNodes - 1)), medium);
    });
  }
  Value operator()(float distance, const Place& place) const {
    const float at = std::log1p(distance * inverse_scale_) * nodes_per_log_;
    const int node = std::min(static_cast<int>(at), kNodes - 2);
    const float share = std::min(at - static_cast<float>(node), 1.0F);
    const Value* from = &values_[static_cast<std::size_t>(node) * media_ + place.node];
    return between(from, from + media_, share, place);
  }
  // Of rows of media: by `share` of the second, and by the place among media.
  static Value between(const Value* first, const Value* second, float share, const Place& place) {
    const Value value = first[0] + share * (second[0] - first[0]);
    if (place.share == 0) return value;
    return value + place.share * (first[1] + share * (second[1] - first[1]) - value);
  }

 private:
  float inverse_scale_ = 1, nodes_per_log_ = 1;
  std::size_t media_ = 1;
  std::vector<Value> values_;
};

class Reflectance {
 public:
  // For distances up to `farthest`, among texels whose sides are from `least_texel` to `greatest_texel`. `field` outlives this.
  Reflectance(const transport::MediumField& field, double farthest, double least_texel,
              double greatest_texel);

  // What is asked for between two points needs the way's.
  Place along(const Vec3& from, const Vec3& to) const { return field_.along(from, to); }
  Place along(const Eigen::Vector3f& from, const Eigen::Vector3f& to) const {
    return field_.isUniform() ? Place() : field_.along(from.cast<double>(), to.cast<double>());
  }
  bool isUniform() const { return field_.isUniform(); }

  // R_d, in 1/area, as all functions here. Tables err by some 1e-5.
  Rgb exact(float distance, const Place& place) const { return exact_(distance, place); }
  // Of all media and colors.
  float greatest(float distance) const;
  // R_d from `radius` on, and below it a polynomial of the same value, slope and curvature there: what interpolation between points about
  // that far apart can follow.
  Rgb smoothed(float distance, float radius, const Place& place) const {
    if (distance >= radius) return exact_(distance, place);
    const float square = distance * distance;
    const Polynomial p = inner_(radius, place);
    return p.col(0) + square * (p.col(1) + square * p.col(2));
  }
  // R_d as texels of a band and side can carry it (DiffuseReflectance::bandLimited).
  std::uint32_t bandOf(float side) const;
  Rgb betweenTexels(float distance, float side, std::uint32_t band, const Place& place) const;
  // Radius that encloses all but that share of R_d on a plane, of each color and medium, and the share of all light that is beyond one: of
  // those that have most.
  double reach(double share) const;
  double shareBeyond(double radius) const;
  double farthest() const { return farthest_; }

 private:
  const transport::MediumField& field_;
  using Polynomial = Eigen::Array33f;  // a column for each power of the squared distance
  RadialTable<Rgb> exact_;
  RadialTable<Polynomial> inner_;  // of a radius
  // By side of a texel, evenly in its logarithm; of distance, in sides, and then of media; times the side squared.
  double farthest_, least_texel_, log_step_;
  std::vector<std::vector<Rgb>> bands_;
};

}  // namespace bakelight::kernels
