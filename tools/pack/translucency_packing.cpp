#include "tools/pack/translucency_packing.h"

#include <cmath>
#include <string>
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

void makeTranslucent(formats::Translucency translucency, const std::string& kernels_file,
                     const formats::TensorFile& transfer, const std::string& transfer_file,
                     formats::Pack& pack) {
  if (pack.appearances.size() != 1)
    throw badInput({kernels_file, "", ""},
                   "the mesh has " + std::to_string(pack.appearances.size()) + " materials",
                   "one, which is translucent", "pack what is opaque apart");
  const auto entered = transfer.metadata.find("entered_ior");
  if (entered == transfer.metadata.end())
    throw badInput({transfer_file, "entered_ior", ""}, "the transfer is of all that falls on the surface",
                   "what a medium lets in", "bake it with the material that has the medium");
  constexpr double kRounding = 1e-4;
  if (std::abs(std::stod(entered->second) - static_cast<double>(translucency.eta)) > kRounding)
    throw badInput({transfer_file, "entered_ior", ""}, "it is " + entered->second,
                   std::to_string(translucency.eta) + ", the medium's in " + kernels_file,
                   "bake both with the same material");
  pack.appearances.front().reflection = std::move(translucency);
}

}  // namespace bakelight::packing
