// The numbers of a glTF file. Private to the glTF reader.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "formats/gltf_document.h"

namespace bakelight::formats {

// Elements of `components` numbers each, one after the other. Normalised integers are 0–1 or −1–1.
struct GltfNumbers {
  std::size_t components = 0;
  std::vector<double> values = {};
  double code_range = 0;  // the largest value of integers that are not normalised; else 0

  std::size_t count() const { return components == 0 ? 0 : values.size() / components; }
};

enum class GltfType { kScalar = 1, kVector2 = 2, kVector3 = 3, kVector4 = 4, kMatrix4 = 16 };

// How many elements the accessor whose index stands at `reference` has.
std::size_t accessorCount(GltfDocument& document, const JsonReader& reference);

// Any component type, stride and offset, sparse or not; without a view all zero. Throws Error(kBadInput) with
// the pointer into the accessor if its type is none of `types`, if it has not `expected_count` elements
// (where that is given), or if it reaches beyond its view.
GltfNumbers readNumbers(GltfDocument& document, const JsonReader& reference,
                        std::initializer_list<GltfType> types,
                        std::optional<std::size_t> expected_count = std::nullopt);

// Unsigned integers. Throws as readNumbers, and for one that is not below `limit` (of `what`: "vertex"), or
// is the primitive restart value of its type.
std::vector<std::uint32_t> readIndices(GltfDocument& document, const JsonReader& reference, std::size_t limit,
                                       const char* what);

}  // namespace bakelight::formats
