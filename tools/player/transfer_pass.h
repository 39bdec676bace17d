// Transfer matrices on the GPU, in any of their storages, and the compute shaders that turn them and a light
// into transferred radiance: what each vertex receives after the object's own shadows and bounces (Sloan et
// al. 2002, section 5). Runs when the light changes.
#pragma once

#include <cstddef>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl_objects.h"
#include "tools/player/gpu_table.h"

namespace bakelight::player {

class TransferPass {
 public:
  // Uploads the tables of a glossy transfer; throws std::invalid_argument if their sizes do not fit together.
  // `largest_block_bytes`: see rowRanges.
  explicit TransferPass(const formats::ShTransfer& transfer, std::size_t largest_block_bytes = 0);

  // `light` is a light buffer (gpu_light.h). Multiply-adds of one vertex, for each colour: output_order²
  // times order² (matrices), (output_order + order − 1)² (visibility), or weights (clusters).
  void evaluate(const Buffer& light);

  // n × output_order² × RGB float32; in the object's frame for visibility, else in the vertex's. Undefined
  // until the first evaluate().
  const Buffer& buffer() const { return transferred_; }
  std::size_t gpuBytes() const;
  std::size_t dispatchCount() const;  // of one evaluate()

 private:
  void prepareVisibility(const formats::ShTransfer& transfer);
  void prepareClusters(const formats::ShTransfer& transfer, const formats::ClusteredOperator& clustered,
                       std::size_t largest_block_bytes);
  void evaluateOperator() const;
  std::size_t itemsOfRow() const;
  void runRows(const Program& program, const GpuTable& table, const std::vector<RowRange>& ranges,
               const Buffer& result) const;

  enum class Kind { kMatrices, kVisibility, kClusters } kind_ = Kind::kMatrices;
  std::size_t row_coefficients_;
  GpuTable table_;
  std::vector<RowRange> ranges_;
  Program program_;
  Buffer transferred_;
  // Visibility: Γ sorted for a gather, and the operator that the light makes of it.
  std::size_t cell_count_ = 0;
  Program operator_program_;
  Buffer entries_, cell_ends_, operator_;
  // Clusters: the clusters' matrices, and what they make of the light.
  GpuTable basis_;
  std::vector<RowRange> basis_ranges_;
  Program basis_program_;
  Buffer clusters_, projected_;
};

}  // namespace bakelight::player
