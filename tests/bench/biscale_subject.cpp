#include "tests/bench/biscale_subject.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <tuple>

#include "formats/material.h"
#include "formats/tensors.h"
#include "patch/read_patch.h"
#include "patch/tiling.h"
#include "tests/support/temporary_folder.h"
#include "tools/pack/packing.h"
#include "tools/rtt/directional.h"
#include "tools/transfer/open_horizon.h"
#include "tools/transfer/pixel_file.h"
#include "tools/transfer/transfer_file.h"
#include "transport/bi_scale_comparison.h"
#include "transport/bi_scale_shading.h"
#include "transport/sh.h"
#include "transport/texture_frames.h"

namespace bakelight::bench {
namespace {

using std::numbers::pi;

struct Extent {
  int across, up;  // patches
};
Extent extentOf(Macro macro) {
  if (macro == Macro::kPlane) return {8, 8};
  return macro == Macro::kCylinder ? Extent{24, 4} : Extent{12, 12};
}

struct Place {
  Vec3 position, normal;
};
// At places across and up, in widths from the middle.
Place placeOn(Macro macro, double across, double up) {
  if (macro == Macro::kPlane) return {kPatchWidth * Vec3(across, 0, -up), Vec3(0, 1, 0)};
  const double radius = 24 * kPatchWidth / (2 * pi);
  if (macro == Macro::kCylinder) {
    const double angle = across * kPatchWidth / radius;
    const Vec3 normal(std::sin(angle), std::cos(angle), 0);
    return {radius * normal + Vec3(0, 0, -up * kPatchWidth), normal};
  }
  const double angle = up * kPatchWidth / radius;
  const Vec3 normal(0, std::cos(angle), std::sin(angle));
  return {-radius * normal + Vec3(across * kPatchWidth, 0, 0), normal};
}

transfer::TransferSettings settingsOf(const TriangleMesh& mesh, const BakeVariant& variant) {
  transfer::TransferSettings settings;
  settings.technique = transfer::Technique::kGlossy;
  settings.storage = transfer::Storage::kMatrix;
  settings.frames = transfer::FrameSource::kTexcoords;
  settings.options.order = settings.options.row_order = variant.order;
  settings.options.transport =
      variant.bounces ? transfer::Transport::kInterreflected : transfer::Transport::kShadowed;
  settings.options = transfer::bakeOptions(settings);
  settings.options.tangents = transport::textureFrames(mesh).tangents;
  return settings;
}

transfer::Transfer bake(const TriangleMesh& mesh, const std::vector<Float3>& albedo,
                        const transfer::TransferOptions& options) {
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  return transfer::bakeTransfer(mesh, albedo, options, silent);
}

formats::Pack packOf(const TriangleMesh& mesh, const rtt::Rtt& rtt, const BakeVariant& variant) {
  const transfer::TransferSettings settings = settingsOf(mesh, variant);
  const std::vector<Float3> albedo = {rtt.figures.mean_albedo};
  transfer::Transfer baked = bake(mesh, albedo, settings.options);
  if (variant.open_horizon) transfer::openHorizons(mesh, settings.options, baked);
  const tests::TemporaryFolder folder;
  transfer::writeTransfer(folder / "transfer.safetensors", mesh, settings, albedo, baked, {});
  packing::PackingOptions options;
  options.material.albedo = albedo.front();
  options.rtt.relief = variant.relief;
  packing::PatchSources patches{{rtt.texture}, {}, {{"", kPatchWidth}}};
  return packing::assemblePack(mesh, formats::readSafetensors(folder / "transfer.safetensors"), nullptr,
                               options, {"mesh", "transfer", "", "material", "rtt"}, patches);
}

rtt::Options optionsOf(const BakeVariant& variant) {
  rtt::Options options;
  options.order = variant.order;
  options.views = variant.views;
  options.resolution = variant.resolution;
  if (!variant.bounces) options.bounces = 0;
  return options;
}

formats::Pack withoutMeso(formats::Pack pack, const Float3& albedo) {
  formats::RttReflection flat = transport::flatReflection(pack.sh().order);
  const std::size_t count = flat.basis.size() / 3;
  for (std::size_t i = 0; i < flat.basis.size(); ++i) flat.basis[i] *= albedo[i / count];
  pack.appearances.front().reflection = flat;
  return pack;
}

}  // namespace

const char* nameOf(Macro macro) {
  return macro == Macro::kPlane ? "plane" : macro == Macro::kCylinder ? "cylinder" : "trough";
}

TriangleMesh macroMesh(Macro macro, int steps) {
  const auto [across, up] = extentOf(macro);
  const int columns = across * steps, rows = up * steps;
  // A unit of texture coordinates is as long both ways.
  const double unit = std::max(across, up);
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double x = static_cast<double>(i) / steps, y = static_cast<double>(j) / steps;
      const Place place = placeOn(macro, x - across / 2.0, y - up / 2.0);
      mesh.positions.push_back(transport::float3(place.position));
      mesh.normals.push_back(transport::float3(place.normal));
      mesh.texcoords.push_back({static_cast<float>(x / unit), static_cast<float>(y / unit)});
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i),
                 c = a + static_cast<std::uint32_t>(columns) + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, a + 1, c + 1}, {a, c + 1, c}});
    }
  return mesh;
}

MacroPoint macroPoint(Macro macro, int steps, double across, double up) {
  const auto [columns, rows] = extentOf(macro);
  const double x = (columns / 2.0 + across) * steps, y = (rows / 2.0 + up) * steps;
  const double column = std::floor(x), row = std::floor(y), right = x - column, above = y - row;
  const auto cell = static_cast<std::uint32_t>(row * columns * steps + column);
  const bool lower = right >= above;
  return {{2 * cell + (lower ? 0 : 1), static_cast<float>(lower ? right - above : right),
           static_cast<float>(lower ? above : above - right)},
          placeOn(macro, across, up).position,
          placeOn(macro, across, up).normal};
}

patch::PatchGeometry patchOf(const std::string& name) {
  const std::filesystem::path file = std::filesystem::path(BAKELIGHT_PATCHES_DIR) / (name + ".json");
  return patch::readPatch(formats::readMaterials(file).base);
}

const rtt::Rtt& rttOf(const std::string& patch_name, const BakeVariant& variant) {
  static std::map<std::tuple<std::string, int, int, int, bool>, rtt::Rtt> made;
  const auto [found, is_new] =
      made.try_emplace({patch_name, variant.order, variant.views, variant.resolution, variant.bounces});
  if (is_new) found->second = rtt::makeRtt(patchOf(patch_name), optionsOf(variant), [] {});
  return found->second;
}

Packs packsOf(const std::string& patch_name, Macro macro, const BakeVariant& variant) {
  const rtt::Rtt& rtt = rttOf(patch_name, variant);
  Packs packs{packOf(macroMesh(macro, variant.macro_steps), rtt, variant), {}, {}};
  packs.macro_only = withoutMeso(packs.bi_scale, rtt.figures.mean_albedo);
  packs.meso_only = transport::withEffects(packs.bi_scale, transport::BiScaleEffects::kNoMacro);
  return packs;
}

formats::Pack allFrequencyPackOf(const std::string& patch_name, Macro macro, const BakeVariant& variant) {
  const TriangleMesh mesh = macroMesh(macro, variant.macro_steps);
  transfer::PixelOptions pixel;
  pixel.tangents = transport::textureFrames(mesh).tangents;
  const tests::TemporaryFolder folder;
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  transfer::writePixelTransfer(folder / "transfer.safetensors", mesh, pixel, silent);
  packing::PackingOptions options;
  options.rtt.relief = variant.relief;
  packing::PatchSources patches{{rttOf(patch_name, variant).texture}, {}, {{"", kPatchWidth}}};
  patches.btfs[""] = rtt::makeBtf(patchOf(patch_name), optionsOf(variant), {}, patch_name, [] {}).btf;
  return packing::assemblePack(mesh, formats::readSafetensors(folder / "transfer.safetensors"), nullptr,
                               options, {"mesh", "transfer", "", "material", "rtt"}, patches);
}

reference::Surface truthOf(const std::string& patch_name, Macro macro) {
  // Smooth enough that its facets do not count beside what is measured.
  const TriangleMesh mesh = macroMesh(macro, macro == Macro::kPlane ? 1 : 4);
  const patch::PatchGeometry geometry = patchOf(patch_name);
  reference::Surface surface{
      patch::tiled(geometry, mesh, patch::tilingOf(mesh, kPatchWidth), nameOf(macro)).mesh, {}};
  surface.material.vertex_albedo = surface.mesh.colors;
  surface.material.reflections = {geometry.reflection};
  return surface;
}

}  // namespace bakelight::bench
