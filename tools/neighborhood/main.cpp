// neighborhood: what an object does to the light around it.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>

#include "formats/error.h"
#include "formats/material.h"
#include "formats/mesh_ply.h"
#include "formats/neighborhood.h"
#include "formats/part_tensors.h"
#include "tools/neighborhood/neighborhood.h"
#include "tools/stage/stage.h"
#include "transport/ray_scene.h"

using namespace bakelight;

namespace {

struct Settings {
  bool ground = true;
  int ground_cells = 64;
  double ground_reach = 2;
  int volume_cells = 0;
  double volume_reach = 1;
  neighborhood::Options options;
};

// The diffuse vectors of a transfer file, with the albedo that light bounced off, or else the material's.
neighborhood::Emitted readEmitted(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                                  const std::string& mesh_file, const std::filesystem::path& material_path) {
  const std::string file = path.string();
  const formats::TensorFile tensors = formats::readSafetensors(path);
  const formats::Tensor& vectors = tensors.require("transfer", formats::ElementType::kFloat32, 3, file);
  if (tensors.requireMetadata("mesh_hash", file) != formats::geometryHash(mesh))
    throw badInput({file, "metadata mesh_hash", ""}, "it was baked for another mesh than " + mesh_file,
                   formats::geometryHash(mesh), "bake transfer again, for this mesh");
  if (tensors.metadata.contains("entered_ior"))
    throw badInput({file, "metadata entered_ior", ""},
                   "the object is translucent, and what leaves it is not in its transfer",
                   "transfer of an opaque object");
  const auto order = static_cast<int>(std::lround(std::sqrt(static_cast<double>(vectors.shape[2]))));
  if (vectors.shape[0] != mesh.vertexCount() || (vectors.shape[1] != 1 && vectors.shape[1] != 3) ||
      order < 1 || order > formats::kMaxOrder ||
      static_cast<std::uint64_t>(order) * static_cast<std::uint64_t>(order) != vectors.shape[2])
    throw badInput({file, "tensor transfer", ""}, "it has another shape",
                   std::to_string(mesh.vertexCount()) + " × 1 or 3 × order²");
  const formats::SurfaceMaterials surface = formats::materialsOn(
      mesh, formats::readMaterialsOrDefault(material_path), mesh_file, material_path.string());
  std::vector<formats::Float3> albedo = surface.vertex_albedo;
  if (albedo.empty()) albedo = {surface.albedo};
  return neighborhood::emittedBy(vectors.as<float>(), order, static_cast<int>(vectors.shape[1]),
                                 mesh.vertexCount(), albedo);
}

formats::EncodedTable tableOf(const neighborhood::Table& baked, std::size_t columns) {
  return formats::encodeTable(baked.values, columns, formats::Precision::kFloat32, "neighborhood", "table");
}

// Of the light at the ground's border, from which on its end is seen in a shadow.
constexpr double kSeenChange = 0.03;

// The largest share of an even sky's light that a row takes away or adds; of the open plane's irradiance, or of all light at a point.
double largestChange(const neighborhood::Table& table, std::size_t columns, std::size_t block,
                     const auto& isAsked) {
  constexpr double kUniform = 3.5449077018110318;  // √(4π): the coefficient of an even sky of radiance 1
  double largest = 0;
  for (std::size_t row = 0; row * columns < table.values.size(); ++row)
    for (std::size_t k = 0; isAsked(row) && k < columns; k += block)
      largest = std::max(largest, std::abs(static_cast<double>(table.values[row * columns + k])) * kUniform);
  return largest;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, material_path, transfer_path, neighborhood_path;
  Settings settings;
  stage::Tool tool("neighborhood",
                   "What an object does to the light around it: its shadow and the light that it reflects, "
                   "on a ground and in space.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh with normals, as simplify writes it")
      .input("material", "material", material_path,
             "what the mesh is made of: its albedo colours the light that it reflects",
             {.required = false, .parts = {"albedo"}})
      .input("transfer", "tensors", transfer_path,
             "what the object sends out: safetensors file of transfer, in spherical harmonics")
      .output("neighborhood", "tensors", neighborhood_path, "safetensors file for pack (docs/FORMATS.md)")
      .parameter("ground", settings.ground, "a plane that the object stands on")
      .parameter("ground_cells", settings.ground_cells, {4, 1024}, "",
                 "cells along the plane, three fifths of them below the object's bounding box")
      .parameter("ground_reach", settings.ground_reach, {0.1, 20}, "",
                 "how far the plane goes beyond the object, in radii of its bounding sphere")
      .parameter("volume_cells", settings.volume_cells, {0, 128}, "",
                 "cells along the longest side of the space that receivers move in; 0: no such space")
      .parameter("volume_reach", settings.volume_reach, {0.1, 20}, "",
                 "how far that space goes beyond the object, likewise")
      .parameter("directions", settings.options.directions, {64, 65536}, "",
                 "rays a point, over the directions in which the object may be")
      .executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    if (!settings.ground && settings.volume_cells == 0)
      throw badInput({"", "", "/ground"}, "there is neither a ground nor a volume", "one of them",
                     "set ground, or volume_cells above 0");
    const formats::TriangleMesh mesh = formats::readPly(mesh_path);
    transport::requireTraceableScale(mesh, mesh_path.string());
    const neighborhood::Emitted emitted = readEmitted(transfer_path, mesh, mesh_path.string(), material_path);
    const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
    const auto start = std::chrono::steady_clock::now();
    const auto size = static_cast<std::size_t>(emitted.order) * static_cast<std::size_t>(emitted.order);
    const std::size_t columns = static_cast<std::size_t>(emitted.channels) * size;

    // A pack's file ends at 4 GiB, and all of a table is held at once.
    const auto requireRoom = [&](std::size_t points, std::size_t row, const std::string& parameter) {
      constexpr double kMostBytes = 4.0 * (std::size_t{1} << 30);
      const double bytes = static_cast<double>(points) * static_cast<double>(row * sizeof(float));
      if (bytes > kMostBytes)
        throw badInput({"", "", "/" + parameter},
                       std::to_string(points) + " points would take " +
                           std::to_string(static_cast<std::uint64_t>(bytes / 1e9)) + " GB",
                       "at most 4 GiB", "fewer cells, or transfer of a lower order");
    };

    formats::Neighborhood result;
    result.order = emitted.order;
    result.channels = emitted.channels;
    std::uint64_t rays = 0;
    if (settings.ground) {
      const neighborhood::GroundGrid grid =
          neighborhood::groundGrid(mesh, bounds, settings.ground_cells, settings.ground_reach);
      const std::size_t across = grid.x.size(), points = across * grid.z.size();
      requireRoom(points, columns, "ground_cells");
      stage::Progress progress = run.progress("ground", points, "points");
      const neighborhood::Table baked =
          neighborhood::groundTransfer(mesh, emitted, grid, settings.options, progress);
      result.ground = formats::GroundTransfer{grid.level, grid.x, grid.z, tableOf(baked, columns)};
      rays += baked.rays;
      run.stat("ground_points", points);
      run.stat("ground_bytes", points * columns * sizeof(float));
      const double edge_change = largestChange(baked, columns, size, [&](std::size_t row) {
        const std::size_t x = row % across;
        return x == 0 || x + 1 == across || row < across || row + across >= points;
      });
      run.stat("ground_edge_change", edge_change);
      if (edge_change > kSeenChange)
        run.warn("the ground ends where the object still changes " +
                 std::to_string(std::lround(100 * edge_change)) +
                 " % of the light on it, so its shadow is cut off: raise ground_reach");
    }
    if (settings.volume_cells > 0) {
      auto axes = neighborhood::volumeGrid(mesh, bounds, settings.volume_cells, settings.volume_reach);
      const std::size_t points = axes[0].size() * axes[1].size() * axes[2].size();
      requireRoom(points, formats::kReceivedCoefficients * columns, "volume_cells");
      stage::Progress progress = run.progress("volume", points, "points");
      const neighborhood::Table baked =
          neighborhood::volumeTransfer(mesh, emitted, axes, settings.options, progress);
      result.volume =
          formats::VolumeTransfer{std::move(axes), tableOf(baked, formats::kReceivedCoefficients * columns)};
      rays += baked.rays;
      run.stat("volume_points", points);
      run.stat("volume_inside_points", baked.inside_points);
      run.stat("volume_bytes", points * formats::kReceivedCoefficients * columns * sizeof(float));
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    run.stat("order", emitted.order);
    run.stat("channels", emitted.channels);
    run.stat("rays", rays);
    run.stat("bake_s", seconds);
    formats::PackPart part(std::move(result));
    formats::TensorFile tensors = formats::tensorsOf(part);
    tensors.metadata["mesh_hash"] = formats::geometryHash(mesh);
    formats::writeSafetensors(neighborhood_path, tensors);
  });
}
