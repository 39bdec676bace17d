// Radiance transfer textures as a pack holds them: factored, with a pyramid, and with the map of where they lie.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/btf.h"
#include "formats/btf_table.h"
#include "formats/index_image.h"
#include "formats/material.h"
#include "formats/radiance_transfer_texture.h"
#include "formats/rtt_reflection.h"

namespace bakelight::packing {

// Of materials with meso-structure.
struct PatchSources {
  std::vector<formats::RadianceTransferTexture> textures;
  // Where they lie; nothing: by the mesh's texture coordinates.
  std::optional<formats::IndexImage> id_map;
  // By material: the width of its patch in the mesh's unit.
  std::map<std::string, double> widths;
  // Names that have a material of their own: without a texture of that name they have no patch, whatever the asset's own has.
  std::set<std::string> own_materials = {};
  // By material, "" the asset's own, for transfer in a pixel basis.
  std::map<std::string, std::shared_ptr<const formats::Btf>> btfs = {};
  // Likewise, and before these.
  std::map<std::string, formats::BtfTable> tables = {};
};
// `id_map` may be empty. Throws Error(kBadInput) as the readers of both files.
// Without `rtt` there are no textures.
PatchSources readPatchSources(const std::filesystem::path& rtt, const std::filesystem::path& id_map);

// What materials say of patches: their names, and widths of patches that lie by texture coordinates; an id map brings its own.
void takeMaterials(const formats::Materials& materials, PatchSources& patches);

// Opens the `.btf` files that materials name as their patches' BTFs, where there is no table of theirs. Throws as formats::openBtf.
void takeBtfs(const formats::Materials& materials, PatchSources& patches);

struct RttPackingOptions {
  // Principal components are taken until what they leave is less: relative root mean square over all coefficients, views and
  // texels. 0 takes all.
  double error = 0.04;
  formats::Precision precision = formats::Precision::kFloat16;
  bool relief = true;  // keep heights where the texture has any but zero
};

// What places of a patch send towards views, of each incident value.
struct PatchSamples {
  std::span<const float> values;  // [view][texel][incident value]
  int views = 1, width = 0, height = 0;
  std::size_t incident = 0;  // three colors of each
};
// Places × basis, by principal components.
struct Factored {
  int components = 0;
  std::vector<float> values;  // of the finest level, as FactoredPatch::factors
  std::vector<float>
      basis;  // as FactoredPatch::basis; orthonormal, so what factors lose is lost in what is reflected
  double error = 0;  // relative root mean square that the components leave
  double total = 0;  // Σ value²
};
// As many components as leave less than `error`, by fours; all for 0.
Factored factored(const PatchSamples& source, double error);

struct PackedRtt {
  formats::RttReflection reflection;  // without patch_width, index and repeats
  double error = 0;                   // that the components leave
};

// With all levels (formats/patch_levels.h). `file` for errors.
PackedRtt packRtt(const formats::RadianceTransferTexture& texture, const RttPackingOptions& options,
                  const std::string& file);

// Of the finest level, of each texel its views; empty where the texture has none but zeros or `options` leave them out.
std::vector<float> heightsByTexel(const formats::RadianceTransferTexture& texture,
                                  const RttPackingOptions& options);
// Heights of a texture, for all levels, unless it has none but zeros or `options` leave them out.
std::optional<formats::EncodedTable> reliefOf(const formats::RadianceTransferTexture& texture,
                                              const RttPackingOptions& options, const std::string& file);

// What idmap wrote, in 256 steps. Throws Error(kBadInput) naming file and channel.
formats::PackImage packIndex(const formats::IndexImage& id_map);

}  // namespace bakelight::packing
