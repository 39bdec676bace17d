// Clustered principal components (Sloan et al. 2003): matrices × light of each cluster's mean and basis, and
// their sum by the weights of each vertex. Cost: as many multiply-adds a vertex, coefficient and colour as
// there are weights.
#pragma once

#include "tools/player/operators/matrix_operator.h"
#include "tools/player/operators/table_rows.h"
#include "tools/player/operators/transfer_operator.h"

namespace bakelight::player {

class ClusterOperator final : public TransferOperator {
 public:
  ClusterOperator(const formats::ShTransfer& transfer, const formats::ClusteredOperator& clustered,
                  std::size_t largest_block_bytes);

  void evaluate(const Buffer& light) override;
  const Buffer& transferred() const override { return weights_.values(); }
  std::size_t gpuBytes() const override;
  std::size_t dispatchCount() const override;

 private:
  TableRows weights_;
  MatrixRows basis_;
  Buffer clusters_;  // of each vertex
  Program program_;
};

}  // namespace bakelight::player
