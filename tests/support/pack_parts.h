// Short words for the parts of packs that tests vary.
#pragma once

#include "formats/pack_contents.h"

namespace bakelight::formats {

enum class Storage { kNone, kMatrix, kVisibility, kCpca };
inline const char* nameOf(Storage storage) {
  return storage == Storage::kNone ? "none" : kOperatorNames[static_cast<std::size_t>(storage) - 1];
}
inline Storage storageOf(const ShTransfer& transfer) {
  return transfer.glossy ? static_cast<Storage>(transfer.glossy->transfer.index() + 1) : Storage::kNone;
}

// Empty tables of a representation, for the caller to fill.
inline GlossyTransfer& makeGlossy(ShTransfer& transfer, Storage storage, int output_order) {
  GlossyTransfer& glossy = transfer.glossy.emplace();
  glossy.output_order = output_order;
  if (storage == Storage::kVisibility) glossy.transfer = VisibilityOperator();
  if (storage == Storage::kCpca) glossy.transfer = ClusteredOperator();
  return glossy;
}

enum class Lobe { kNone, kPhong, kGgx, kTable };
inline const char* nameOf(Lobe lobe) {
  constexpr const char* kNames[] = {"none", "phong", "ggx", "table"};
  return kNames[static_cast<std::size_t>(lobe)];
}

// Any reflection by its numbers; those of other lobes are ignored.
struct MadeReflection {
  Lobe model = Lobe::kNone;
  float exponent = 0, roughness = 0;
  Float3 specular_color = {1, 1, 1};
  BrdfTable table = {};

  operator PackPart() const {
    if (model == Lobe::kPhong) return PhongLobe{exponent, specular_color};
    if (model == Lobe::kGgx) return GgxLobe{roughness, specular_color};
    if (model == Lobe::kTable) return table;
    return LambertReflection();
  }
};

inline ClusteredOperator& clustersOf(ShTransfer& transfer) {
  return std::get<ClusteredOperator>(transfer.glossy->transfer);
}
inline ClusteredOperator& clustersOf(Pack& pack) {
  return clustersOf(pack.sh());
}
inline const ClusteredOperator& clustersOf(const Pack& pack) {
  return std::get<ClusteredOperator>(pack.sh().glossy->transfer);
}

inline PackPart& reflectionOf(Pack& pack) {
  return pack.appearances.front().reflection;
}
template <class Reflection>
Reflection& reflectionAs(Pack& pack) {
  return *reflectionOf(pack).as<Reflection>();
}

}  // namespace bakelight::formats
