// Estimates of many mean values at once, refined until they are good enough as a whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "tools/reference/distant_light_sampler.h"
#include "tools/reference/trace_counts.h"
#include "tools/stage/progress.h"

namespace bakelight::reference {

// Mean and variance from the means of independent batches (Welford's update). Luminance is kept as a fourth
// component, since its variance needs the colours' covariances.
class BatchMeans {
 public:
  void add(const Rgb& batch_mean);

  int batches() const { return count_; }
  Rgb mean() const { return mean_.head<3>(); }
  double luminance() const { return mean_[3]; }
  // Of the mean, not of a sample; 0 below two batches.
  Rgb variance() const { return varianceOfAll().head<3>(); }
  double luminanceVariance() const { return varianceOfAll()[3]; }

 private:
  Eigen::Array4d varianceOfAll() const;

  Eigen::Array4d mean_ = Eigen::Array4d::Zero(), squares_ = Eigen::Array4d::Zero();
  int count_ = 0;
};

struct Effort {
  double relative_error = 0.01;  // 0: take exactly `samples`
  int samples = 4096;            // of an element; rounded down to whole batches, at least two
};

struct RoundsReport {
  double relative_error = 0;
  int samples = 0, rounds = 0;  // samples of each element
  bool converged = true;        // false if `samples` ended it before the relative error was reached
  TraceCounts counts;
  double seconds = 0;
};

// Calls trace(element, first batch, end) for all elements, in parallel, in rounds that double the batches, or
// come to as many as the error of the last round asks for, until relativeError() is small enough. `trace`
// returns what it took.
//
// That the error is looked at in order to stop biases nothing worth speaking of: one figure stops all
// elements together, it is an average over them, and which way a single element errs has hardly a part in it.
RoundsReport runRounds(std::size_t elements, const Effort& effort,
                       const std::function<TraceCounts(std::size_t, int, int)>& trace,
                       const std::function<double()>& relative_error, stage::ProgressStyle progress);

}  // namespace bakelight::reference
