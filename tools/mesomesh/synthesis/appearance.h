// What the surroundings of each place of an exemplar look like, at the spacing of one level of synthesis
// (Lefebvre & Hoppe 2006, "Appearance-space texture synthesis").
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/mesomesh/synthesis/exemplar.h"

namespace bakelight::mesomesh {

// Coordinates in texels, with 16 bits after the point: coordinates that are shifted around a surface come
// back to the bit, and differ on no machine. A whole number is the middle of a texel.
using Fixed = std::int32_t;
using FixedPoint = std::array<Fixed, 2>;
constexpr int kFixedBits = 16;
constexpr Fixed kOneTexel = Fixed{1} << kFixedBits;
constexpr Fixed kHalfTexel = kOneTexel / 2;

constexpr int kAppearanceSize = 8;  // numbers that describe a place
using Appearance = std::array<std::int16_t, kAppearanceSize>;
// Within ± this, so that the squared differences of four appearances fit 32 bits.
constexpr int kAppearanceLimit = 2047;

class AppearanceLevel {
 public:
  // `step`: spacing of the level's vertices in texels. Windows of 5 × 5 at that spacing are taken from the
  // exemplar after a Gaussian has removed what the spacing cannot hold, and described by 8 principal
  // components, four times a texel where the step is below two, twice where below four. `similar`: how many
  // places like it are found for each texel, besides itself. Cost: texels · (200 · channels) and, for
  // similar places, at worst texels² (a sorted list ends most searches early).
  AppearanceLevel(const Exemplar& exemplar, double step, int similar, bool finest = true);

  int width() const { return width_; }
  int height() const { return height_; }
  bool periodic() const { return periodic_; }
  Fixed step() const { return step_; }
  double retainedVariance() const { return retained_variance_; }
  // Mean squared distance of a place to the mean, in units of the table.
  double variance() const { return variance_; }
  // Places in each texel's list of similar ones, itself not counted.
  int similarCount() const { return similar_count_; }

  // The place in the table that is nearest to `at`, which may lie outside of the exemplar by up to
  // lookupReach(); deltaOf() moves such a place.
  const std::int16_t* appearance(FixedPoint at) const {
    return table_.data() +
           kAppearanceSize * (static_cast<std::ptrdiff_t>(cell(at[1]) + pad_) * stride_ + cell(at[0]) + pad_);
  }
  std::ptrdiff_t deltaOf(FixedPoint offset) const {
    return kAppearanceSize * (static_cast<std::ptrdiff_t>(cell(offset[1])) * stride_ + cell(offset[0]));
  }
  Fixed lookupReach() const { return lookup_reach_; }
  // Side length of a cell of the table: closer places are told apart by nothing.
  Fixed cellSize() const { return Fixed{1} << cell_bits_; }

  // Texels like this one, by falling likeness, apart from it and from each other.
  std::span<const std::array<std::uint16_t, 2>> similar(int x, int y) const {
    return {similar_.data() + (static_cast<std::size_t>(y) * width_ + x) * similar_count_,
            static_cast<std::size_t>(similar_count_)};
  }

  // Where coordinates may lie: [least, greatest] without period.
  FixedPoint least() const { return least_; }
  FixedPoint greatest() const { return greatest_; }
  bool contains(FixedPoint at) const {
    return periodic_ ||
           (at[0] >= least_[0] && at[1] >= least_[1] && at[0] <= greatest_[0] && at[1] <= greatest_[1]);
  }
  // The same place of a periodic exemplar within [0, side); otherwise mirrored at
  // the border of what may be taken.
  FixedPoint admitted(FixedPoint at) const {
    return {admitted(at[0], width_ << kFixedBits, 0), admitted(at[1], height_ << kFixedBits, 1)};
  }

 private:
  // At either end as often as needed; clamped, many would meet at the border.
  static Fixed mirrored(Fixed at, Fixed least, Fixed greatest) {
    if (at >= least && at <= greatest) return at;
    const Fixed span = greatest - least;
    Fixed beyond = (at - least) % (2 * span);
    if (beyond < 0) beyond += 2 * span;
    return least + (beyond > span ? 2 * span - beyond : beyond);
  }
  Fixed admitted(Fixed at, Fixed period, std::size_t axis) const {
    if (!periodic_) return mirrored(at, least_[axis], greatest_[axis]);
    if (at < 0) at += period;
    if (at >= period) at -= period;
    if (at >= 0 && at < period) return at;
    at %= period;
    return at < 0 ? at + period : at;
  }
  int cell(Fixed at) const { return (at + (Fixed{1} << (cell_bits_ - 1))) >> cell_bits_; }
  void findSimilar(int count);

  int width_, height_;
  bool periodic_;
  Fixed step_ = 0;
  int cell_bits_ = kFixedBits;
  int pad_ = 0, stride_ = 0;  // cells
  Fixed lookup_reach_ = 0;
  FixedPoint least_ = {0, 0}, greatest_ = {0, 0};
  double retained_variance_ = 1, variance_ = 0;
  std::vector<std::int16_t> table_;
  int similar_count_ = 0;
  std::vector<std::array<std::uint16_t, 2>> similar_;
};

}  // namespace bakelight::mesomesh
