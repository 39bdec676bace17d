#include "tools/transfer/pixel_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/tensor_writer.h"
#include "tools/transfer/scratch_array.h"

namespace bakelight::transfer {

using formats::ElementType;

namespace {

constexpr std::size_t kVerticesPerBlock = 1024;

}  // namespace

PixelFileFigures writePixelTransfer(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                                    const PixelOptions& options, stage::Progress& progress) {
  const PixelBaker baker(mesh, options);
  ScratchArray codes(path), columns(path), row_offsets(path);
  PixelFileFigures figures;
  figures.vertices = mesh.vertexCount();
  std::uint64_t rows = 0;
  const std::uint64_t zero = 0;
  row_offsets.append(std::as_bytes(std::span(&zero, 1)));
  for (std::size_t first = 0; first < mesh.vertexCount(); first += kVerticesPerBlock) {
    PixelBlock block =
        baker.bake({first, std::min(first + kVerticesPerBlock, mesh.vertexCount())}, &progress);
    figures.add(block.figures);
    for (std::uint64_t& offset : block.rows.row_offsets) offset += figures.entries;
    const auto ends = std::span<const std::uint64_t>(block.rows.row_offsets).subspan(1);
    row_offsets.append(std::as_bytes(ends));
    columns.append(std::as_bytes(std::span(block.rows.columns)));
    codes.append(std::as_bytes(std::span(block.rows.codes)));
    rows += ends.size();
    figures.entries += block.rows.codes.size();
  }

  const std::map<std::string, formats::TensorShape> shapes = {
      {"codes", {ElementType::kUint8, {figures.entries}}},
      {"columns", {ElementType::kUint16, {figures.entries}}},
      {"row_offsets", {ElementType::kInt64, {rows + 1}}},
      {"normals", {ElementType::kFloat32, {mesh.vertexCount(), 3}}},
      {"tangents", {ElementType::kFloat32, {mesh.vertexCount(), 4}}}};
  const std::map<std::string, std::string> metadata = {
      {"technique", "pixel"},
      {"basis", "cube_map"},
      {"transport", options.shadows ? "shadowed" : "unshadowed"},
      {"cube_side", std::to_string(options.cube_side)},
      {"local_side", std::to_string(options.local_side)},
      {"subsamples", std::to_string(options.subsamples)},
      {"cosine", "outside"},
      {"mesh_hash", formats::geometryHash(mesh)}};
  formats::TensorWriter writer(path, shapes, metadata);
  const auto copy = [&](const char* name, const ScratchArray& array) {
    array.replay([&](std::span<const std::byte> part) { writer.append(name, part); });
  };
  copy("codes", codes);
  copy("columns", columns);
  copy("row_offsets", row_offsets);
  writer.append("normals", std::as_bytes(std::span(mesh.normals)));
  writer.append("tangents", std::as_bytes(baker.tangents()));
  writer.finish();
  return figures;
}

PixelOptions pixelOptions(const TransferSettings& settings) {
  if (settings.options.transport == Transport::kInterreflected)
    throw badInput(
        {"", "", "/transport"},
        "transfer in a pixel basis is integers that count what is seen, which have no room for bounces",
        "\"shadowed\" or \"unshadowed\"", "basis sh holds interreflection");
  if (settings.near_field)
    throw badInput({"", "", "/near_field"}, "transfer in a pixel basis is for distant light only", "false",
                   "basis sh has near fields");
  if (settings.options.fit != Fit::kVertices)
    throw badInput({"", "", "/fit"}, "transfer in a pixel basis counts what each vertex sees", "\"vertices\"",
                   "basis sh can be fitted");
  if (settings.isGlossy())
    throw badInput({"", "", "/technique"},
                   "transfer in a pixel basis has no matrices of spherical harmonics beside it",
                   "\"diffuse\"", "leave technique out: this basis serves any reflection");
  PixelOptions options = settings.pixel;
  options.shadows = settings.options.transport != Transport::kUnshadowed;
  options.bias = settings.options.bias;
  return options;
}

void report(const PixelOptions& options, const PixelFileFigures& figures, double bake_s, stage::Run& run) {
  const auto share = [](std::uint64_t part, std::uint64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const auto cells = static_cast<std::uint64_t>(options.local_side) * options.local_side;
  const std::uint64_t rows = figures.vertices * cells;
  const auto texels = static_cast<std::uint64_t>(6) * options.cube_side * options.cube_side;
  run.stat("vertices", figures.vertices);
  run.stat("rows", rows);
  run.stat("columns", texels);
  run.stat("entries", figures.entries);
  run.stat("entry_share", share(figures.entries, rows * texels));
  run.stat("dense_float_bytes", rows * texels * sizeof(float));
  run.stat("csr_bytes", figures.entries * 3 + (rows + 1) * sizeof(std::uint64_t));
  run.stat("bake_s", bake_s);
  run.stat("rays", figures.rays);
  run.stat("rays_per_s", bake_s > 0 ? static_cast<double>(figures.rays) / bake_s : 0.0);
  run.stat("blocked_ray_share", share(figures.blocked_rays, figures.rays));
  run.stat("fully_blocked_vertices", figures.fully_blocked_vertices);
  run.stat("buried_vertices", figures.buried_vertices);
  run.stat("filled_vertices", figures.filled_vertices);
  if (options.shadows && figures.rays > 0 && figures.blocked_rays == 0)
    run.warn("nothing blocks any ray: transport \"unshadowed\" gives the same result without rays");
  if (figures.fully_blocked_vertices > figures.vertices / 2)
    run.warn("most vertices see no light at all: is the mesh closed and turned inside out?");
}

}  // namespace bakelight::transfer
