// Clustered principal components (Sloan, Hall, Hart & Snyder 2003) of a transfer matrix's rows, as sparse as they are: row ≈ its cluster's mean + Σ
// weight · component.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "formats/pixel_transfer.h"

namespace bakelight::compression {

struct ClusterOptions {
  int clusters = 32;   // at most
  int components = 8;  // each cluster's
  int rounds = 8;      // of assigning rows to the cluster of least error, the components growing in number
};

struct RowClusters {
  static constexpr std::int32_t kNone = -1;
  int cube_side = 32, components = 0;
  std::vector<std::int32_t> clusters;  // of each row; kNone for rows without an entry
  std::vector<float> weights;          // rows × components
  std::vector<Eigen::MatrixXf> bases;  // columns × (1 + components): the mean, then orthonormal components
};

// Of codes ÷ subsamples². Seeds are drawn by squared distance from fixed numbers; the same whatever the threads. Cost: rounds ×
// entries × clusters × components. Throws std::invalid_argument for options below 1 (components: 0).
RowClusters clusterRows(const formats::PixelCodes& codes, const ClusterOptions& options);

}  // namespace bakelight::compression
