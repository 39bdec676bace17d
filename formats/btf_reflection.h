// A bidirectional texture function as a material's reflection, in the directional basis of transfer in a pixel basis
// (formats/pixel_transfer.h), for light of all frequencies.
#pragma once

#include <cstddef>

#include "formats/factored_patch.h"

namespace bakelight::formats {

// Incident values are radiance × solid angle in the cells of the hemisphere grid, in the frame of the vertex, along which the patch
// lies; a value of the BTF is the mean over a cell of what leaves under a directional light of unit irradiance normal to itself, so
// cosines are inside.
struct BtfReflection : FactoredPatch {
  static constexpr const char* kKind = "btf";
  void describe(FieldVisitor& fields);

  int lights = 8;  // a side of the grid of cells: the transfer's local_side
  // Relative RMS that components, code and precision leave at the finest level, over all views, lights, texels and colors; and all these
  // values as half floats ÷ the bytes of code, basis and heights.
  float error = 0, storage_ratio = 0;

  std::size_t cells() const { return static_cast<std::size_t>(lights) * lights; }
  // cells of red, of green, of blue
  const float* basisOf(int component) const {
    return &basis[static_cast<std::size_t>(component) * 3 * cells()];
  }
};

}  // namespace bakelight::formats
