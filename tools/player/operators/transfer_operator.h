// Radiance transfer on the GPU: what turns a light into transferred radiance, the light that each vertex
// receives after the object's own shadows and bounces (Sloan et al. 2002, section 5). Runs when the light
// changes. A representation of the transfer is one class behind this one.
#pragma once

#include <cstddef>
#include <memory>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"

namespace bakelight::player {

class TransferOperator {
 public:
  virtual ~TransferOperator() = default;

  // `light` as GpuLight::sh.
  virtual void evaluate(const Buffer& light) = 0;

  // n × output_order² × RGB float32; in the object's frame for visibility, else in the vertex's. Undefined
  // until the first evaluate().
  virtual const Buffer& transferred() const = 0;
  virtual std::size_t gpuBytes() const = 0;
  virtual std::size_t dispatchCount() const = 0;  // of one evaluate()
};

// Uploads the tables of a glossy transfer; throws std::invalid_argument if their sizes do not fit together.
// `largest_block_bytes`: see rowRanges.
std::unique_ptr<TransferOperator> makeTransferOperator(const formats::ShTransfer& transfer,
                                                       std::size_t largest_block_bytes = 0);

}  // namespace bakelight::player
