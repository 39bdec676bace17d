// Clustered principal component analysis (Sloan, Hall, Hart & Snyder 2003): vectors of high dimension as
// cluster mean + Σ_k weight_k · basis_k.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace bakelight::transfer {

struct CpcaOptions {
  int clusters = 64;    // at most; a cluster that loses its members is dropped
  int components = 16;  // weights a vector
  int iterations = 12;  // rounds of reassignment to the cluster of least error
};

struct Cpca {
  std::uint32_t cluster_count = 0;
  int components = 0;
  std::vector<std::uint32_t> clusters;  // of each vector
  std::vector<float> weights;           // n × components
  std::vector<float> basis;  // clusters × (1 + components) × dimension: the mean, then orthonormal components
  double relative_error = 0;  // √(Σ|x − x'|² / Σ|x|²)
};

// `vectors` is n × dimension. Fewer vectors than clusters or components is fine: surplus components are zero.
// Deterministic whatever the threads: k-means seeded by farthest points, sums in fixed chunks. `round_done`
// is called after each round. Throws std::invalid_argument for sizes that do not fit or options below 1.
// Cost: iterations × n × dimension × (clusters tried) × components.
Cpca clusteredPca(std::span<const float> vectors, std::size_t dimension, const CpcaOptions& options,
                  const std::function<void()>& round_done = {});

}  // namespace bakelight::transfer
