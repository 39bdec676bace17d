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
#include "tools/kernels/point.h"
#include "transport/diffusion.h"
#include "transport/medium_field.h"

namespace bakelight::kernels {

using Rgb = Eigen::Array3f;  // red, green, blue

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
  // `by_color`: colors, which are rows of Value, have places of their own.
  template <class Function>  // Value(double distance, std::size_t medium); at the same time for several media
  RadialTable(double scale, double farthest, std::size_t media, bool by_color, const Function& function)
      : by_color_(by_color),
        inverse_scale_(static_cast<float>(1 / scale)),
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
    const Value* from = &values_[static_cast<std::size_t>(node) * media_];
    return between(from, from + media_, share, place, by_color_);
  }
  // Of rows of media: by `share` of the second, and by the place among media.
  static Value between(const Value* first, const Value* second, float share, const Place& place,
                       bool by_color) {
    if (by_color) return betweenByColor(first, second, share, place);
    first += place.node[0], second += place.node[0];
    const Value value = first[0] + share * (second[0] - first[0]);
    if (place.share[0] == 0) return value;
    return value + place.share[0] * (first[1] + share * (second[1] - first[1]) - value);
  }

 private:
  static Value betweenByColor(const Value* first, const Value* second, float share, const Place& place) {
    Value value;
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto color = static_cast<std::size_t>(c);
      const Value *a = first + place.node[color], *b = second + place.node[color];
      const float of_second = place.share[color];
      value.row(c) = (1 - of_second) * ((1 - share) * a[0].row(c) + share * b[0].row(c)) +
                     of_second * ((1 - share) * a[1].row(c) + share * b[1].row(c));
    }
    return value;
  }

  bool by_color_ = false;
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
  Place along(const Point& from, const Point& to) const {
    if (field_.isUniform()) return {};
    if (!field_.isOfSurface()) return field_.along(from.position, to.position);
    return field_.along(*from.around, *to.around, (from.position - to.position).norm());
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
