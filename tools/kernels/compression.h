// Kernels as sums of few (the paper's section 7 names principal components).
#pragma once

#include <cstddef>
#include <vector>

namespace bakelight::kernels {

struct CompressedKernels {
  int components = 0;
  std::vector<float> weights;  // rows × components
  std::vector<float> basis;    // components × columns, the largest first; without a mean of their own
  double error = 0;            // root of the sum of squared differences ÷ that of the squares
};

// The fewest components with at most that relative error; 0 components where that would take more numbers than the kernels have.
// Cost: rows · columns².
CompressedKernels compress(const std::vector<float>& rows, std::size_t columns, double error);

}  // namespace bakelight::kernels
