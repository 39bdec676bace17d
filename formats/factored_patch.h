// A patch of meso-structure that a surface wears, factored for playing and filtered for minification: what radiance transfer textures
// (formats/rtt_reflection.h) and BTFs (formats/btf_reflection.h) have in common.
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

struct ReliefCode {
  float step = 0;
  IntegerArray heights{1, {}};
};
// What a pack stores in place of factors and heights (formats/patch_code.h).
struct PatchCode {
  float step = 0;                             // between levels of coefficients
  Precision precision = Precision::kFloat16;  // of the factors that are made of it
  IntegerArray factors{1, {}};
  std::optional<ReliefCode> relief;
};

// Radiance of place q towards view v = Σ_k factors_k(q, v) · Σ_i basis_k,i · incident_i, of each color: by principal components, so that
// the sums over i are taken at vertices and interpolated. Albedo and cosines are inside.
struct FactoredPatch {
  int views = 1;              // a side of the grid of views (transport/hemisphere_grid.h)
  int width = 0, height = 0;  // texels of the finest level
  int components = 0;
  float patch_width = 0;  // on the surface, in its unit: what a pixel covers decides the level
  // (texels of all levels · views²) × components: levels from the finest, texels in rows from the upper left, of each its
  // views row by row, b upwards.
  EncodedTable factors;
  std::vector<float> basis;  // components × 3 (RGB) × incident values
  // Heights of what is seen, above the mid-plane in widths of the patch, one for each row of factors: views are then looked up
  // along the relief (transport/patch_lookup.h) instead of all at one place. Nothing for what is flat, or not known.
  std::optional<EncodedTable> heights;
  // If there, the pack stores it in place of both, which are made of it when the pack is opened.
  std::optional<PatchCode> code;

  // Where in the patch the surface is. Channels "U", "V" by texture coordinates, 0–1, u to the right, v upwards: looked
  // up, never filtered. The index of an appearance serves those after it that have none.
  std::optional<PackImage> index;
  // Without any: texture coordinates times this, its fraction; v times width/height beside.
  float repeats = 1;

 protected:
  // All of the above; `incident` values are reflected.
  void describePatch(FieldVisitor& fields, std::size_t incident, std::size_t most_components);
};

// By appearance: the image that it is indexed by; null for texture coordinates, and for other reflections.
std::vector<const PackImage*> patchIndices(const Pack& pack);

}  // namespace bakelight::formats
