#include "tests/bench/roofline.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/roofline.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace bakelight::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, 16>;
using Vector = hn::Vec<Floats>;
constexpr Floats kFloats;
constexpr std::size_t kLanes = hn::MaxLanes(Floats());

float sumOf(const float* values, std::size_t count) {
  constexpr std::size_t kSums = 4;  // hides the latency of an addition
  Vector sums[kSums] = {hn::Zero(kFloats), hn::Zero(kFloats), hn::Zero(kFloats), hn::Zero(kFloats)};
  for (std::size_t i = 0; i < count; i += kSums * kLanes)
#pragma GCC unroll 4
    for (std::size_t s = 0; s < kSums; ++s)
      sums[s] = hn::Add(sums[s], hn::Load(kFloats, values + i + s * kLanes));
  return hn::GetLane(hn::SumOfLanes(kFloats, hn::Add(hn::Add(sums[0], sums[1]), hn::Add(sums[2], sums[3]))));
}

// Returns the lanes of all chains.
std::size_t runChains(std::size_t steps, float* result) {
  constexpr std::size_t kChains = 12;
  Vector sums[kChains];
#pragma GCC unroll 12
  for (std::size_t c = 0; c < kChains; ++c) sums[c] = hn::Set(kFloats, static_cast<float>(c));
  const Vector factor = hn::Set(kFloats, 0.5f), term = hn::Set(kFloats, 0.25f);
  for (std::size_t step = 0; step < steps; ++step)
#pragma GCC unroll 12
    for (std::size_t c = 0; c < kChains; ++c) sums[c] = hn::MulAdd(sums[c], factor, term);
  Vector total = sums[0];
#pragma GCC unroll 12
  for (std::size_t c = 1; c < kChains; ++c) total = hn::Add(total, sums[c]);
  *result = hn::GetLane(hn::SumOfLanes(kFloats, total));
  return kChains * kLanes;
}

const char* nameOfTarget() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace bakelight::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bakelight {

HWY_EXPORT(sumOf);
HWY_EXPORT(runChains);
HWY_EXPORT(nameOfTarget);

double readSum(std::span<const float> buffer) {
  constexpr std::size_t kChunk = 64 << 10;  // floats: 256 KiB, as much as a range of the evaluator's tiles
  const std::size_t chunks = (buffer.size() + kChunk - 1) / kChunk;
  std::vector<float> sums(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kChunk;
    sums[chunk] = HWY_DYNAMIC_DISPATCH(sumOf)(&buffer[begin], std::min(kChunk, buffer.size() - begin));
  });
  double total = 0;
  for (const float sum : sums) total += sum;
  return total;
}

double multiplyAddChains(std::size_t steps, float& sink) {
  const int threads = tbb::this_task_arena::max_concurrency();
  // Several pieces a thread, so that a thread that starts late does not hold up the rest.
  constexpr int kPieces = 8;
  std::vector<float> results(threads * kPieces);
  std::atomic<std::size_t> lanes{0};
  tbb::parallel_for(
      std::size_t{0}, results.size(),
      [&](std::size_t piece) { lanes += HWY_DYNAMIC_DISPATCH(runChains)(steps / kPieces, &results[piece]); },
      tbb::simple_partitioner());
  for (const float result : results) sink += result;
  return static_cast<double>(lanes) * static_cast<double>(steps / kPieces);
}

const char* instructionSet() {
  return HWY_DYNAMIC_DISPATCH(nameOfTarget)();
}

}  // namespace bakelight
#endif
