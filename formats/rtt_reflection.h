// A radiance transfer texture as a material's reflection (Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance Transfer"):
// what formats/radiance_transfer_texture.h holds, factored for playing and filtered for minification.
#pragma once

#include <cstddef>

#include "formats/factored_patch.h"

namespace bakelight::formats {

// B of the paper's equation 4. In the frames of GlossyTransfer, along which the patch lies.
struct RttReflection : FactoredPatch {
  static constexpr const char* kKind = "radiance_transfer_texture";
  void describe(FieldVisitor& fields);

  int order = 0;  // bands of incident radiance; at most the transfer's output_order

  const float* basisOf(int component) const {
    return &basis[static_cast<std::size_t>(component) * 3 * order * order];
  }
};

}  // namespace bakelight::formats
