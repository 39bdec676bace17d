// An axis of a plot: its range and where its ticks stand.
#pragma once

#include <span>
#include <vector>

namespace bakelight::report {

class Axis {
 public:
  // Logarithmic, with room around the positive values; values of 0 stand at its low end. At most `most_ticks`
  // (≥ 2) ticks at round numbers.
  Axis(std::span<const double> values, std::size_t most_ticks);

  // 0 at the low end, 1 at the high end; values beyond them are clamped.
  double position(double value) const;
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  double low_ = 1, high_ = 10;
  std::vector<double> ticks_;
};

}  // namespace bakelight::report
