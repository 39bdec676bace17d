#include "transport/directions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>

namespace bakelight::transport {
namespace {

constexpr int kCurveBits = 10;  // a grid of 1024 × 1024 cells

// Position of cell (x, y) along the Hilbert curve: every step of the curve goes to an adjacent cell.
std::uint32_t hilbertIndex(std::uint32_t x, std::uint32_t y) {
  std::uint32_t index = 0;
  for (std::uint32_t side = 1u << (kCurveBits - 1); side > 0; side /= 2) {
    const std::uint32_t right = (x & side) ? 1 : 0, upper = (y & side) ? 1 : 0;
    index += side * side * ((3 * right) ^ upper);
    if (upper == 0) {
      if (right == 1) {
        x = (1u << kCurveBits) - 1 - x;
        y = (1u << kCurveBits) - 1 - y;
      }
      std::swap(x, y);
    }
  }
  return index;
}

std::uint32_t curvePosition(const Vec3& direction) {
  // Octahedral map of the sphere to [-1, 1]²
  const double norm1 = direction.lpNorm<1>();
  double a = direction.x() / norm1, b = direction.y() / norm1;
  if (direction.z() < 0) {
    const double folded = (1 - std::abs(b)) * (a < 0 ? -1 : 1);
    b = (1 - std::abs(a)) * (b < 0 ? -1 : 1);
    a = folded;
  }
  const auto cell = [](double t) {
    const double scaled = (t + 1) / 2 * (1 << kCurveBits);
    return static_cast<std::uint32_t>(std::clamp(scaled, 0.0, (1 << kCurveBits) - 1.0));
  };
  return hilbertIndex(cell(a), cell(b));
}

}  // namespace

std::vector<Vec3> sphereDirections(int count) {
  std::vector<Vec3> lattice(count);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count;
    // Fraction of a turn by multiples of the golden ratio's inverse; taken modulo 1 before the cosine to keep
    // its digits.
    const double turn = std::fmod(i * (std::numbers::phi - 1), 1.0), angle = 2 * std::numbers::pi * turn;
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    lattice[i] = Vec3(r * std::cos(angle), r * std::sin(angle), z);
  }
  std::vector<std::uint32_t> position(count);
  std::transform(lattice.begin(), lattice.end(), position.begin(), curvePosition);
  std::vector<int> sequence(count);
  std::iota(sequence.begin(), sequence.end(), 0);
  std::stable_sort(sequence.begin(), sequence.end(), [&](int a, int b) { return position[a] < position[b]; });

  std::vector<Vec3> sorted(count);
  std::transform(sequence.begin(), sequence.end(), sorted.begin(), [&](int i) { return lattice[i]; });
  return sorted;
}

DirectionGap largestGap(std::span<const Vec3> directions) {
  constexpr int kSamples = 40000;  // of the sphere, less than 1° apart
  DirectionGap gap;
  double least = 2;
  for (const Vec3& sample : sphereDirections(kSamples)) {
    if (sample.z() < 0) continue;
    double nearest = -1;
    for (const Vec3& direction : directions) nearest = std::max(nearest, sample.dot(direction));
    if (nearest < least) least = nearest, gap.direction = sample;
  }
  gap.angle_rad = std::acos(std::clamp(least, -1.0, 1.0));
  return gap;
}

}  // namespace bakelight::transport
