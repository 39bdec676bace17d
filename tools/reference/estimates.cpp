#include "tools/reference/estimates.h"

#include <tbb/blocked_range.h>
#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "transport/random.h"

namespace bakelight::reference {
namespace {

constexpr int kBatchSize = transport::StratifiedBatch::kSize;
constexpr int kFirstBatches = 2;  // the fewest that have a variance
constexpr std::size_t kElementsPerTask = 64;

// A little more than it takes, as the error of a small number of batches is an estimate itself.
int batchesFor(double error, double wanted, int batches) {
  const double needed = 1.1 * batches * (error / wanted) * (error / wanted);
  return static_cast<int>(std::clamp(std::ceil(needed), batches + 1.0, 2.0 * batches));
}

}  // namespace

void BatchMeans::add(const Rgb& batch_mean) {
  Eigen::Array4d value;
  value << batch_mean, 0.2126 * batch_mean[0] + 0.7152 * batch_mean[1] + 0.0722 * batch_mean[2];
  ++count_;
  const Eigen::Array4d difference = value - mean_;
  mean_ += difference / count_;
  squares_ += difference * (value - mean_);
}

Eigen::Array4d BatchMeans::varianceOfAll() const {
  if (count_ < 2) return Eigen::Array4d::Zero();
  return squares_ / (static_cast<double>(count_) * (count_ - 1));
}

RoundsReport runRounds(std::size_t elements, const Effort& effort,
                       const std::function<TraceCounts(std::size_t, int, int)>& trace,
                       const std::function<double()>& relative_error, stage::ProgressStyle progress_style) {
  const auto start = std::chrono::steady_clock::now();
  const int most = std::max(effort.samples / kBatchSize, kFirstBatches);
  RoundsReport report;
  tbb::combinable<TraceCounts> counts;
  int done = 0;
  int wanted = effort.relative_error > 0 ? kFirstBatches : most;
  while (true) {
    stage::Progress progress(progress_style, "round " + std::to_string(report.rounds + 1),
                             elements * static_cast<std::uint64_t>(wanted - done) * kBatchSize, "samples");
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, elements, kElementsPerTask), [&](const auto& range) {
      TraceCounts& here = counts.local();
      for (std::size_t i = range.begin(); i < range.end(); ++i) here += trace(i, done, wanted);
      progress.advance(range.size() * static_cast<std::uint64_t>(wanted - done) * kBatchSize);
    });
    done = wanted;
    ++report.rounds;
    report.relative_error = relative_error();
    if (report.relative_error <= effort.relative_error || done == most) break;
    wanted = std::min(batchesFor(report.relative_error, effort.relative_error, done), most);
  }
  report.samples = done * kBatchSize;
  report.converged = effort.relative_error == 0 || report.relative_error <= effort.relative_error;
  counts.combine_each([&](const TraceCounts& here) { report.counts += here; });
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace bakelight::reference
