// What a translucent object sends back of what falls on it, on the CPU: the two branches of formats/translucency.h, as the player's
// shaders compute them (Lensch et al. 2002, figure 3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/translucency.h"
#include "formats/triangle_mesh.h"
#include "transport/translucent_tables.h"

namespace bakelight::transport {

using formats::Float3;

class TranslucentResponse {
 public:
  // What contributes: both, or one branch on its own.
  enum class Branches { kBoth, kLocal, kGlobal };

  // Decodes all tables: receivers · 147 · 4 bytes. Throws std::invalid_argument if they do not fit each other.
  explicit TranslucentResponse(const formats::Translucency& translucency);

  std::size_t texelCount() const { return texels_.size(); }
  std::size_t receiverCount() const { return receivers_.size(); }
  // Of each texel, from that of each knot.
  std::vector<Float3> interpolated(std::span<const Float3> at_knots) const;
  // Radiosity below the surface at each receiver; `entering`, one a texel, is what falls on it times what the surface lets in.
  // Throws std::invalid_argument for another number. Cost: receivers · 147 and the matrices' entries; on all TBB threads, same bytes for
  // any number.
  std::vector<Float3> respond(std::span<const Float3> entering, Branches branches = Branches::kBoth) const;
  // Of knots, by factors and blend weights alone.
  std::vector<Float3> atKnots(std::span<const Float3> entering) const;

 private:
  struct Matrix {
    std::vector<std::uint32_t> ends, columns;
    std::vector<float> values;
    std::size_t value_columns = 1;
    std::vector<Float3> times(std::span<const Float3> x) const;
  };
  static Matrix decoded(const formats::SparseRows& rows);

  int resolution_;
  std::vector<std::uint32_t> texels_, receivers_, texel_knots_;
  std::vector<Float3> weights_;  // of the three knots
  std::vector<float> kernels_;
  Gifts gifts_;
  Matrix sharpen_, sharpen_transposed_, near_, spread_, spread_transposed_, far_;
};

}  // namespace bakelight::transport
