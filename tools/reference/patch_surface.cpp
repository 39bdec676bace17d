#include "tools/reference/patch_surface.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "patch/read_patch.h"
#include "patch/tiling.h"
#include "transport/surface_points.h"
#include "transport/texture_frames.h"

namespace bakelight::reference {
namespace {

using formats::Triangle;
using formats::TriangleMesh;

// The faces of one material, with the vertices they have.
TriangleMesh facesOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& of_triangle,
                     std::uint32_t material, std::vector<std::uint32_t>& sources) {
  TriangleMesh part;
  std::map<std::uint32_t, std::uint32_t> numbers;
  sources.clear();
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    if (!of_triangle.empty() && of_triangle[t] != material) continue;
    Triangle triangle = mesh.triangles[t];
    for (std::uint32_t& v : triangle) {
      const auto [found, is_new] = numbers.try_emplace(v, static_cast<std::uint32_t>(sources.size()));
      if (is_new) sources.push_back(v);
      v = found->second;
    }
    part.triangles.push_back(triangle);
  }
  for (const std::uint32_t v : sources) {
    part.positions.push_back(mesh.positions[v]);
    if (!mesh.normals.empty()) part.normals.push_back(mesh.normals[v]);
    if (!mesh.texcoords.empty()) part.texcoords.push_back(mesh.texcoords[v]);
  }
  return part;
}

void append(const TriangleMesh& part, const std::vector<formats::Float3>& albedo, std::uint32_t material,
            Surface& whole) {
  const auto base = static_cast<std::uint32_t>(whole.mesh.vertexCount());
  const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  add(whole.mesh.positions, part.positions);
  add(whole.mesh.normals, part.normals);
  add(whole.mesh.texcoords, part.texcoords);
  whole.mesh.texcoords.resize(whole.mesh.vertexCount(), {0, 0});
  add(whole.material.vertex_albedo, albedo);
  for (const auto& [a, b, c] : part.triangles) whole.mesh.triangles.push_back({base + a, base + b, base + c});
  whole.material.of_triangle.resize(whole.mesh.triangleCount(), material);
}

void warnOf(const patch::TiledSurface& tiled, const std::string& mesh_file, const std::string& name,
            std::vector<std::string>& notes) {
  const std::string of = name.empty() ? "" : " of " + name;
  if (tiled.broken_edges > 0)
    notes.push_back(
        mesh_file + ": the patch" + of + " is cut at " + std::to_string(tiled.broken_edges) +
        " edges, where its texture coordinates do not continue it; a patch that an id map lays out "
        "is another picture");
  if (tiled.bare_triangles > 0)
    notes.push_back(mesh_file + ": " + std::to_string(tiled.bare_triangles) + " triangles" + of +
                    " have no area, in space or in texture coordinates, and no patch");
}

}  // namespace

bool hasPatches(const formats::Materials& materials) {
  const auto has = [](const formats::Material& material) {
    return material.patch && material.patch->hasSurface();
  };
  return has(materials.base) || std::any_of(materials.by_name.begin(), materials.by_name.end(),
                                            [&](const auto& named) { return has(named.second); });
}

PatchedSurface withPatches(const Surface& given, const formats::Materials& materials,
                           const std::string& mesh_file) {
  PatchedSurface result{{{}, given.material, given.model, given.tables}, {}};
  Surface& surface = result.surface;
  surface.translucency = given.translucency;
  surface.material.vertex_albedo.clear();
  surface.material.of_triangle.clear();
  surface.textures.resize(given.material.names.size());
  const double radius = transport::boundingSphere(given.mesh).radius;
  double thinnest = radius;
  std::vector<std::uint32_t> sources;
  for (std::uint32_t number = 0; number < given.material.names.size(); ++number) {
    const TriangleMesh part = facesOf(given.mesh, given.material.of_triangle, number, sources);
    if (part.triangleCount() == 0) continue;
    const std::string& name = given.material.names[number];
    const formats::Material& material = materials.of(name);
    if (!material.patch || !material.patch->hasSurface()) {
      std::vector<formats::Float3> albedo;
      for (const std::uint32_t v : sources)
        albedo.push_back(given.material.vertex_albedo.empty() ? given.material.albedo
                                                              : given.material.vertex_albedo[v]);
      append(part, albedo, number, surface);
      continue;
    }
    auto geometry = std::make_shared<patch::PatchGeometry>(patch::readPatch(material));
    result.notes.insert(result.notes.end(), geometry->notes.begin(), geometry->notes.end());
    // Of the whole mesh, as packs have it.
    const transport::PatchRepeats repeats = given.mesh.texcoords.empty()
                                                ? transport::PatchRepeats{}
                                                : transport::patchRepeats(given.mesh, material.patch->width);
    const double width = repeats.width;
    const patch::TiledSurface tiled = patch::tiled(*geometry, part, {repeats.repeats, width}, mesh_file);
    warnOf(tiled, mesh_file, name, result.notes);
    append(tiled.mesh, tiled.mesh.colors, number, surface);
    thinnest = std::min(thinnest, width);
    if (!geometry->texture.values.empty()) {
      geometry->mesh = {};
      surface.textures[number] = std::move(geometry);
    }
  }
  // What is small beside the whole is not small beside a patch.
  if (radius > 0) surface.bias = transport::kDefaultBias * thinnest / radius;
  return result;
}

}  // namespace bakelight::reference
