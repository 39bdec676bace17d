// Range and moments of a list of values, the ones that are not finite counted apart.
#pragma once

#include <cstddef>
#include <cstdint>

namespace bakelight::inspect {

class Moments {
 public:
  void add(double value);

  std::uint64_t finiteCount() const { return finite_; }
  std::uint64_t nanCount() const { return nan_; }
  std::uint64_t infiniteCount() const { return infinite_; }
  // Of the finite values; 0 if there is none.
  double minimum() const { return minimum_; }
  double maximum() const { return maximum_; }
  double mean() const;
  double rootMeanSquare() const;

 private:
  std::uint64_t finite_ = 0, nan_ = 0, infinite_ = 0;
  double minimum_ = 0, maximum_ = 0, sum_ = 0, sum_of_squares_ = 0;
};

}  // namespace bakelight::inspect
