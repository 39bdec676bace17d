// Random numbers that depend on what they are for (seed, element, batch, dimension), never on a thread or on
// the order in which they are drawn.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bakelight::transport {

// Turns each bit of `value` into all bits of the result; a bijection (the finaliser of SplitMix64: Steele,
// Lea & Flood 2014, "Fast splittable pseudorandom number generators").
constexpr std::uint64_t scrambled(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15U;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9U;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebU;
  return value ^ (value >> 31);
}

// Sixteen samples of any number of dimensions. In each dimension pair every cell of a 4 × 4 grid holds one
// point, as does every sixteenth of either axis (correlated multi-jittered: Kensler 2013, "Correlated
// Multi-Jittered Sampling"); in each single dimension every sixteenth of the unit interval does. Which sample
// has which cell is shuffled anew in each dimension, so that they are combined at random. Means over a batch
// are unbiased, and batches are independent.
class StratifiedBatch {
 public:
  static constexpr int kSize = 16;

  StratifiedBatch(std::uint64_t seed, std::uint64_t element, std::uint64_t batch)
      : key_(scrambled(scrambled(scrambled(seed) ^ element) ^ batch)) {}

  // Both in [0, 1). `sample` < kSize. Pairs and single numbers of the same dimension are not independent:
  // give each use a dimension of its own.
  std::array<double, 2> pair(int sample, int dimension) const {
    const std::uint64_t of_dimension = scrambled(key_ ^ static_cast<std::uint64_t>(dimension));
    const unsigned cell = shuffled(static_cast<unsigned>(sample), static_cast<std::uint32_t>(of_dimension));
    const unsigned column = cell % 4, row = cell / 4;
    // Within its column a cell takes the quarter that its row is given, and the other way round.
    const auto bits = static_cast<unsigned>(of_dimension >> 32);
    const unsigned across = ((row ^ (bits & 3)) + (bits >> 2)) & 3;
    const unsigned down = ((column ^ (bits >> 4 & 3)) + (bits >> 6)) & 3;
    const std::uint64_t jitter = jitterOf(of_dimension, sample);
    return {(4 * column + across + unitInterval(jitter >> 32)) / kSize,
            (4 * row + down + unitInterval(jitter & 0xffffffffU)) / kSize};
  }
  double single(int sample, int dimension) const {
    const std::uint64_t of_dimension = scrambled(key_ ^ static_cast<std::uint64_t>(dimension));
    const unsigned cell = shuffled(static_cast<unsigned>(sample), static_cast<std::uint32_t>(of_dimension));
    return (cell + unitInterval(jitterOf(of_dimension, sample) >> 32)) / kSize;
  }

 private:
  static double unitInterval(std::uint64_t bits32) { return static_cast<double>(bits32) * 0x1p-32; }
  static std::uint64_t jitterOf(std::uint64_t of_dimension, int sample) {
    return scrambled(of_dimension + 0xd1342543de82ef95U * static_cast<std::uint64_t>(sample + 1));
  }
  // Kensler's hashed permutation, for sixteen.
  static unsigned shuffled(unsigned i, std::uint32_t p) {
    constexpr unsigned kMask = kSize - 1;
    i ^= p;
    i *= 0xe170893dU;
    i ^= p >> 16;
    i ^= p >> 8;
    i *= 0x0929eb3fU;
    i ^= p >> 23;
    i ^= (i & kMask) >> 1;
    i *= 1 | p >> 27;
    i *= 0x6935fa69U;
    i *= 0x74dcb303U;
    i ^= (i & kMask) >> 2;
    i *= 0x9e501cc3U;
    i ^= (i & kMask) >> 2;
    i *= 0xc860a3dfU;
    return (i + p) & kMask;
  }

  std::uint64_t key_;
};

// Turns the sums of `weights` (none negative) into cumulative probabilities from 0 to 1, one more than
// weights; all 0 without any weight. Returns the total.
inline double accumulateProbabilities(std::span<const double> weights, std::span<double> cumulative) {
  double total = 0;
  cumulative[0] = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) cumulative[i + 1] = total += weights[i];
  if (total > 0)
    for (double& value : cumulative) value /= total;
  return total;
}

struct DrawnInterval {
  std::size_t index;
  double rest;  // where in the interval the number fell, in [0, 1): as good a random number as the first
};
// The interval of `cumulative` (from 0 to 1) that `number` in [0, 1) falls into; never an empty one.
inline DrawnInterval drawInterval(std::span<const double> cumulative, double number) {
  const auto above = std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, number);
  auto index = static_cast<std::size_t>(above - cumulative.begin()) - 1;
  while (index > 0 && cumulative[index + 1] <= cumulative[index]) --index;  // only if rounding ends below 1
  const double width = cumulative[index + 1] - cumulative[index];
  return {index, std::clamp((number - cumulative[index]) / width, 0.0, 1 - 0x1p-53)};
}

}  // namespace bakelight::transport
