// A transfer matrix a vertex. Cost: output_order² · order² multiply-adds a vertex and colour.
#pragma once

#include "tools/player/operators/table_rows.h"
#include "tools/player/operators/transfer_operator.h"

namespace bakelight::player {

// Rows of matrices × light, of vertices or of whatever else has matrices.
class MatrixRows {
 public:
  // `matrices`: rows × (channels · output_order² · order²).
  MatrixRows(const formats::ShTransfer& transfer, const formats::EncodedTable& matrices,
             std::size_t largest_block_bytes);

  // The light is bound as uniform block 0.
  void run() const;
  const TableRows& rows() const { return rows_; }

 private:
  TableRows rows_;
  Program program_;
};

class MatrixOperator final : public TransferOperator {
 public:
  MatrixOperator(const formats::ShTransfer& transfer, const formats::MatrixOperator& matrices,
                 std::size_t largest_block_bytes);

  void evaluate(const Buffer& light) override;
  const Buffer& transferred() const override { return matrices_.rows().values(); }
  std::size_t gpuBytes() const override { return matrices_.rows().gpuBytes(); }
  std::size_t dispatchCount() const override { return matrices_.rows().dispatchCount(); }

 private:
  MatrixRows matrices_;
};

}  // namespace bakelight::player
