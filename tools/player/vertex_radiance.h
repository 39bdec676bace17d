// The light-change half of the player: transfer vectors on the GPU, and a compute shader that turns them and
// a light into the exit radiance of each vertex (Sloan et al. 2002, eq. 8). transport::evaluateDiffuse does
// the same on the CPU.
#pragma once

#include <cstddef>
#include <span>

#include "formats/pack.h"
#include "tools/player/gl_objects.h"
#include "transport/lights.h"

namespace bakelight::player {

class VertexRadiance {
 public:
  // Uploads the table; radiance is undefined until the first evaluate(). The table is bound in pieces of at
  // most `largest_block_bytes` (0: GL_MAX_SHADER_STORAGE_BLOCK_SIZE, which is 128 MiB on llvmpipe). Throws
  // Error(kNotAvailable) if GL is out of memory.
  VertexRadiance(const formats::DiffuseTransfer& transfer, std::size_t vertex_count,
                 std::size_t largest_block_bytes = 0);

  // Cost: n · order² · 3 multiply-adds on the GPU. `light` has at least order² entries (further bands are
  // ignored). Throws Error(kBadInput) if one of them is not finite.
  void evaluate(std::span<const transport::Float3> light);

  // n × RGB float32, albedo left out; to be used as a vertex attribute.
  const Buffer& buffer() const { return radiance_; }
  int dispatchCount() const { return dispatches_; }  // of one evaluate()

 private:
  std::size_t vertex_count_, coefficient_count_, vertices_per_dispatch_;
  int dispatches_;
  Program program_;
  Buffer transfer_, radiance_, light_;
};

}  // namespace bakelight::player
