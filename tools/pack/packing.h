// Puts a mesh and the transfer baked for it together as one pack. Pure: structs in, struct out.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "formats/json.h"
#include "formats/material.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"
#include "tools/pack/btf_packing.h"
#include "tools/pack/rtt_packing.h"

namespace bakelight::packing {

// What the stage's files are called, for errors.
struct SourceNames {
  std::string mesh, transfer, brdf, material = "material.json";
  std::string rtt = {}, id_map = {};
};

// How the material's glossy reflection is shown.
enum class ShownReflection {
  kLobe,   // symmetric around the mirror direction
  kTable,  // as the brdf tool projected it
  kNone
};
inline constexpr formats::Word<ShownReflection> kShownReflections[] = {
    {"lobe", ShownReflection::kLobe}, {"table", ShownReflection::kTable}, {"none", ShownReflection::kNone}};

struct PackingOptions {
  std::string name = "asset";
  formats::SurfaceMaterials material;  // of the mesh
  // Of matrices, visibility vectors or weights. The basis of cpca gets half floats instead of 8-bit codes:
  // it is small, and its errors would show at every vertex. Diffuse vectors stay floats.
  formats::Precision precision = formats::Precision::kFloat32;
  ShownReflection reflection = ShownReflection::kLobe;
  RttPackingOptions rtt;
  BtfPackingOptions btf;
  double crease_angle = 60;  // PixelTransfer::crease_angle
};

// What an appearance's radiance transfer texture or BTF became.
struct TextureFigures {
  std::string material;
  int components = 0;
  double error = 0;  // that the components leave (PackedRtt); of a BTF what the pack leaves
  double patch_width = 0;
  // Of a BTF: as PackedBtf.
  double components_error = 0;
  std::size_t value_count = 0, stored_bytes = 0;
};
formats::Json toJson(const std::vector<TextureFigures>& textures);

// `transfer` is the transfer stage's file and `brdf` (null without one) the brdf tool's; docs/FORMATS.md has
// both. Throws Error(kBadInput) naming tensor or key if one says something that a pack of this version cannot
// hold, if a shape does not fit the mesh, or if it was baked for another mesh or another albedo than the
// material's; at /reflection or /brdf if reflection, transfer and table do not go together: a reflection
// needs matrices, matrices need a reflection, and "table" needs `brdf`, or materials that are tables. There is
// an appearance for each material that a triangle has, with the radiance transfer texture of its name if `patches` have one; vertices stay as the transfer file has them, to be put
// in order by orderByMaterial. The pack itself is judged by formats::encodePack.
formats::Pack assemblePack(formats::TriangleMesh mesh, const formats::TensorFile& transfer,
                           const formats::TensorFile* brdf, const PackingOptions& options,
                           const SourceNames& files, const PatchSources& patches = {},
                           std::vector<TextureFigures>* textures = nullptr);

// Triangles and vertices in the order of the pack's appearances; a vertex that two of them share becomes two.
// Vertices without a triangle are dropped then, and counted; with one appearance nothing changes.
std::size_t orderByMaterial(formats::Pack& pack);

// Throws Error(kBadInput) at /position_bits or /normal_bits: 0, or 8–30 and 6–30.
void checkOptions(const formats::PackOptions& options);

// By section of the matrices: √(Σ(decoded − original)² / Σ original²), what the precision costs. Empty for a
// diffuse pack. `pack` must be assemblePack's of this `transfer`.
std::map<std::string, double> precisionErrors(const formats::Pack& pack, const formats::TensorFile& transfer);

}  // namespace bakelight::packing
