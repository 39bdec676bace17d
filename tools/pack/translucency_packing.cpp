#include "tools/pack/translucency_packing.h"

#include <utility>

#include "formats/error.h"
#include "formats/part_tensors.h"

namespace bakelight::packing {

formats::Translucency readTranslucency(const std::filesystem::path& path, const formats::TriangleMesh& mesh) {
  formats::PackPart part{formats::Translucency()};
  formats::readPart(part, formats::readSafetensors(path), path.string());
  formats::Translucency translucency = std::move(*part.as<formats::Translucency>());
  if (translucency.knots.size() != mesh.vertexCount())
    throw badInput({path.string(), "knots", ""},
                   "they are of a mesh of " + std::to_string(translucency.knots.size()) + " vertices",
                   std::to_string(mesh.vertexCount()) + ", as the mesh has",
                   "give the mesh that kernels was given");
  return translucency;
}

void makeTranslucent(formats::Translucency translucency, const std::string& file, formats::Pack& pack) {
  if (pack.appearances.size() != 1)
    throw badInput({file, "", ""}, "the mesh has " + std::to_string(pack.appearances.size()) + " materials",
                   "one, which is translucent", "pack what is opaque apart");
  pack.appearances.front().reflection = std::move(translucency);
}

}  // namespace bakelight::packing
