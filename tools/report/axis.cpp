#include "tools/report/axis.h"

#include <algorithm>
#include <cmath>

namespace bakelight::report {
namespace {

// 1, 2 or 5 times a power of ten within the range, or all or fewer of the numbers between.
std::vector<double> logTicks(double low, double high, const std::vector<double>& mantissas, int decade_step) {
  std::vector<double> ticks;
  const int first = static_cast<int>(std::floor(std::log10(low))),
            last = static_cast<int>(std::ceil(std::log10(high)));
  for (int decade = first; decade <= last; ++decade) {
    if (decade % decade_step != 0) continue;
    for (const double mantissa : mantissas) {
      const double tick = mantissa * std::pow(10, decade);
      if (tick >= low && tick <= high) ticks.push_back(tick);
    }
  }
  return ticks;
}

std::vector<double> linearTicks(double low, double high, std::size_t most) {
  for (double decade = std::pow(10, std::floor(std::log10(high - low)) - 1);; decade *= 10)
    for (const double mantissa : {1, 2, 5}) {
      const double step = mantissa * decade;
      const double first = std::ceil(low / step), last = std::floor(high / step);
      if (last - first + 1 > static_cast<double>(most)) continue;
      std::vector<double> ticks;
      for (double i = first; i <= last; ++i) ticks.push_back(i * step);
      return ticks;
    }
}

}  // namespace

Axis::Axis(std::span<const double> values, std::size_t most_ticks) {
  std::vector<double> positive;
  for (const double value : values)
    if (std::isfinite(value) && value > 0) positive.push_back(value);
  if (!positive.empty()) {
    const auto [low, high] = std::minmax_element(positive.begin(), positive.end());
    const double room = std::max(0.12 * std::log(*high / *low), std::log(1.15));
    low_ = *low * std::exp(-room);
    high_ = *high * std::exp(room);
  }
  const std::vector<std::pair<std::vector<double>, int>> densities = {{{1, 1.5, 2, 3, 4, 5, 6, 8}, 1},
                                                                      {{1, 2, 3, 5, 7}, 1},
                                                                      {{1, 2, 5}, 1},
                                                                      {{1, 3}, 1},
                                                                      {{1}, 1},
                                                                      {{1}, 2},
                                                                      {{1}, 4},
                                                                      {{1}, 8}};
  for (const auto& [mantissas, decade_step] : densities) {
    ticks_ = logTicks(low_, high_, mantissas, decade_step);
    if (ticks_.size() <= most_ticks) break;
  }
  if (ticks_.size() < 3) ticks_ = linearTicks(low_, high_, most_ticks);
}

double Axis::position(double value) const {
  if (!(value > low_)) return 0;
  return std::min(std::log(value / low_) / std::log(high_ / low_), 1.0);
}

}  // namespace bakelight::report
