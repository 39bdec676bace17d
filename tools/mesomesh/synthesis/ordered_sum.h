// Sums over many elements that are the same for any number of threads.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace bakelight::mesomesh {

// Of value(0) to value(count − 1): fixed blocks side by side, then block after block.
template <class Value>
double orderedSum(std::size_t count, const Value& value) {
  constexpr std::size_t kBlock = 16384;
  std::vector<double> sums((count + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t block) {
    double sum = 0;
    for (std::size_t i = block * kBlock; i < std::min(count, (block + 1) * kBlock); ++i) sum += value(i);
    sums[block] = sum;
  });
  double total = 0;
  for (const double sum : sums) total += sum;
  return total;
}

}  // namespace bakelight::mesomesh
