// Tables of arbitrary numbers for passes whose sums are checked.
#pragma once

#include <cstddef>
#include <random>
#include <vector>

namespace bakelight::player {

// In [-1, 1], the same for the same seed.
inline std::vector<float> randomValues(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> values(count);
  for (float& value : values) value = uniform(random);
  return values;
}

}  // namespace bakelight::player
