// Diffuse shading: transfer vectors on the GPU, and a compute shader that turns them and a light into the
// exit radiance of each vertex (Sloan et al. 2002, eq. 8). Runs when the light changes.
#pragma once

#include <cstddef>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"

namespace bakelight::player {

// What diffuse light is multiplied by.
struct Albedo {
  formats::Float3 base_color = {1, 1, 1};
  const Buffer* vertex_colors = nullptr;  // n × RGB float32, or null
};

class DiffusePass {
 public:
  // `table` is the vectors or near_field vectors of a transfer with `channels` and `order`, and
  // outlives the pass. If `adds`, evaluate() adds to another pass's radiance. `largest_block_bytes`: see
  // rowRanges.
  DiffusePass(const GpuTable& table, int order, int channels, const Albedo& albedo, bool adds,
              std::size_t largest_block_bytes = 0);

  // `light` is a GpuLight::sh, `added` the buffer() of another pass, null unless the pass adds.
  // Cost: n · order² · 3 multiply-adds on the GPU.
  void evaluate(const Buffer& light, const Buffer* added = nullptr);

  // n × RGB float32, albedo included; fit for a vertex attribute and for shader storage. Undefined until the
  // first evaluate().
  const Buffer& buffer() const { return radiance_; }
  std::size_t dispatchCount() const { return ranges_.size(); }  // of one evaluate()

 private:
  const GpuTable& table_;
  Albedo albedo_;
  std::vector<RowRange> ranges_;
  Program program_;
  Buffer radiance_;
};

}  // namespace bakelight::player
