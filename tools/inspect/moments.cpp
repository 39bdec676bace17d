#include "tools/inspect/moments.h"

#include <algorithm>
#include <cmath>

namespace bakelight::inspect {

void Moments::add(double value) {
  if (std::isnan(value)) {
    ++nan_;
  } else if (std::isinf(value)) {
    ++infinite_;
  } else {
    minimum_ = finite_ == 0 ? value : std::min(minimum_, value);
    maximum_ = finite_ == 0 ? value : std::max(maximum_, value);
    sum_ += value;
    sum_of_squares_ += value * value;
    ++finite_;
  }
}

double Moments::mean() const {
  return finite_ > 0 ? sum_ / static_cast<double>(finite_) : 0;
}

double Moments::rootMeanSquare() const {
  return finite_ > 0 ? std::sqrt(sum_of_squares_ / static_cast<double>(finite_)) : 0;
}

}  // namespace bakelight::inspect
