// A visibility vector a vertex: an operator is made of the light and of the triple product of spherical
// harmonics, once for all vertices, and applied to each vector (Sloan et al. 2002, section 5, in the object's
// frame). Cost: output_order² · (output_order + order − 1)² multiply-adds a vertex and colour.
#pragma once

#include "tools/player/operators/table_rows.h"
#include "tools/player/operators/transfer_operator.h"

namespace bakelight::player {

class VisibilityOperator final : public TransferOperator {
 public:
  VisibilityOperator(const formats::ShTransfer& transfer, const formats::VisibilityOperator& visibility,
                     std::size_t largest_block_bytes);

  void evaluate(const Buffer& light) override;
  const Buffer& transferred() const override { return rows_.values(); }
  std::size_t gpuBytes() const override;
  std::size_t dispatchCount() const override { return rows_.dispatchCount(); }

 private:
  void prepareGather(const formats::ShTransfer& transfer);
  void gatherOperator() const;

  TableRows rows_;
  Program program_;
  std::size_t cell_count_ = 0;
  Program operator_program_;
  Buffer entries_, cell_ends_,
      operator_;  // the triple product sorted for a gather, and what a light makes of it
};

// Visibility vectors as float32 matrices in the local frame, for reflection by a table, whose rows are no
// rotations of one another. Cost: a rotation of output_order² × order² values a vertex.
formats::ShTransfer matricesFromVisibility(const formats::Pack& pack);

}  // namespace bakelight::player
