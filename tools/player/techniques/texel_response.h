// How light that enters a translucent object comes out of it (formats/translucency.h), on the GPU pass by pass: illumination,
// distribution, throughput, filter and combination (Lensch et al. 2002, figure 3). transport::TranslucentResponse is the same on the CPU.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/operators/sparse_product.h"

namespace bakelight::player {

class TexelResponse {
 public:
  // Kernels are expanded to half floats. The pack may go. Throws std::invalid_argument if its tables do not fit each other, and
  // Error(kNotAvailable) for an atlas that this OpenGL cannot hold. `largest_block_bytes`: see rowRanges.
  explicit TexelResponse(const formats::Pack& pack, std::size_t largest_block_bytes = 0);

  // All passes. `at_vertices`: RGB float32 a vertex, exit radiance of a white surface by transfer vectors that hold what the surface lets
  // in. `others`: RGB float32 a texel in the order of Translucency::texels, what further lights send into it; may be null.
  void respond(const Buffer& at_vertices, const Buffer* others);

  // RGBA float32, side² texels, rows from the top: radiosity below the surface, and 1 where there is any, else 0.
  const Texture& radiosity() const { return radiosity_; }
  std::size_t gpuBytes() const;

 private:
  struct Pass {
    Program program;
    std::vector<RowRange> ranges;  // of work items
  };
  void illuminate(const Buffer& at_vertices, const Buffer* others) const;
  void distribute() const;
  void multiply() const;
  void filter() const;
  void combine() const;
  void requireRoom(const formats::Translucency& translucency) const;

  int side_;  // of the atlas
  std::size_t texel_count_, receiver_count_;
  GpuTable weights_, kernels_;
  Buffer vertices_, knots_, places_, receivers_, gift_ends_, gifts_;
  Buffer entering_;              // RGB float32 a texel
  Texture picture_, radiosity_;  // the same in the atlas, with a margin
  Buffer power_, at_knots_, spare_, far_, spare_far_,
      near_;  // RGB and padding: of knots, far knots, receivers
  Pass illumination_, distribution_, filter_, combination_;
  SparseProduct sharpen_transposed_, near_factors_, sharpen_;
  struct Far {
    SparseProduct gather, factors, spread;
  };
  std::optional<Far> far_factors_;
};

}  // namespace bakelight::player
