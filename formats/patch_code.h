// How a pack stores the finest level of a factored patch in some hundredths of its bytes: a cosine transform over places and views,
// steps of one size for all coefficients, and an entropy coder that knows what lies around each. Factors are by an orthonormal basis
// and the transform is orthonormal, too, so the squared error of what is reflected is that of the coefficients, and one step for all spends
// bits where they lessen it most: weak components and high frequencies get none (reverse water-filling).
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/file.h"

namespace bakelight::formats {

struct FactoredPatch;

// Values in the order of FactoredPatch::factors at the finest level: texels in rows, of each its views² row by row, of each its components.
struct PatchValuesShape {
  int width = 0, height = 0, views = 1, components = 1;
  std::size_t count() const { return static_cast<std::size_t>(width) * height * views * views * components; }
};

// Finds the step for an error, and encodes. Tiles of at most 64 × 64 texels are transformed on their own, so a patch of any size costs
// the same a texel. Holds the coefficients as floats.
class PatchEncoder {
 public:
  // std::invalid_argument if `values` are not shape.count().
  PatchEncoder(std::span<const float> values, const PatchValuesShape& shape);

  // Σ (decoded − value)² by that step.
  double squaredError(float step) const;
  // The largest step with at most that squared error, within 0.2 %; `squared_error` above 0.
  float stepFor(double squared_error) const;
  Bytes encode(float step) const;

 private:
  PatchValuesShape shape_;
  std::vector<float> coefficients_;  // tile by tile
};

// Throws Error(kBadInput) naming `file` and `what` if the bytes are not a code of that shape.
std::vector<float> decodePatchValues(std::span<const std::byte> bytes, float step,
                                     const PatchValuesShape& shape, const std::string& file,
                                     const std::string& what);

// Makes factors and heights of a patch that has a code, with all levels; others stay as they are. Throws as decodePatchValues.
void expandPatch(FactoredPatch& patch, const std::string& file);

}  // namespace bakelight::formats
