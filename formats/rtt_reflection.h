// A radiance transfer texture as a material's reflection (Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance Transfer"):
// what formats/radiance_transfer_texture.h holds, factored for playing and filtered for minification.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/fields.h"
#include "formats/pack_image.h"

namespace bakelight::formats {

struct Pack;

// A level of the pyramid: texels side by side, beginning at `first_texel` of all levels.
struct RttLevel {
  int width = 0, height = 0;
  std::size_t first_texel = 0;
};
// Halved, rounded down, until one texel is left.
std::vector<RttLevel> rttLevels(int width, int height);
std::size_t rttTexelCount(const std::vector<RttLevel>& levels);  // of all

// Radiance of place q towards view v = Σ_k factors_k(q, v) · Σ_i basis_k,i · incident_i, of each color: B of the paper's
// equation 4, factored by principal components, so that the sums over i are taken at vertices and interpolated. In the frames of
// GlossyTransfer, along which the patch lies; albedo and cosines are inside.
struct RttReflection {
  static constexpr const char* kKind = "radiance_transfer_texture";
  void describe(FieldVisitor& fields);

  int order = 0;              // bands of incident radiance; at most the transfer's output_order
  int views = 1;              // a side of the grid of views (transport/hemisphere_grid.h)
  int width = 0, height = 0;  // texels of the finest level
  int components = 0;
  float patch_width = 0;  // on the surface, in its unit: what a pixel covers decides the level
  // (texels of all levels · views²) × components: levels from the finest, texels in rows from the upper left, of each its
  // views row by row, b upwards.
  EncodedTable factors;
  std::vector<float> basis;  // components × 3 (RGB) × order²
  // Heights of what is seen, above the mid-plane in widths of the patch, one for each row of factors: views are then looked up
  // along the relief (transport/rtt_table.h) instead of all at one place. Nothing for what is flat, or not known.
  std::optional<EncodedTable> heights;

  // Where in the patch the surface is. Channels "U", "V" by texture coordinates, 0–1, u to the right, v upwards: looked
  // up, never filtered. The index of an appearance serves those after it that have none.
  std::optional<PackImage> index;
  // Without any: texture coordinates times this, its fraction; v times width/height beside.
  float repeats = 1;

  const float* basisOf(int component) const {
    return &basis[static_cast<std::size_t>(component) * 3 * order * order];
  }
};

// By appearance: the image that it is indexed by; null for texture coordinates, and for other reflections.
std::vector<const PackImage*> rttIndices(const Pack& pack);

}  // namespace bakelight::formats
