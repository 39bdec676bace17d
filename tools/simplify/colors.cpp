#include "tools/simplify/colors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "formats/error.h"
#include "formats/materials.h"
#include "tools/simplify/albedo_map.h"
#include "transport/surface_query.h"

namespace bakelight::simplify {

using formats::Float3;
using formats::MeshImport;
using formats::TriangleMesh;
using transport::vec3;

namespace {

// Samples sit at the centroids of kSplits² congruent parts of each triangle.
constexpr int kSplits = 4;

std::vector<Vec3> sampleWeights() {
  std::vector<Vec3> weights;
  for (int i = 0; i < kSplits; ++i)
    for (int j = 0; i + j < kSplits; ++j) {
      const auto at = [&](double u, double v) { weights.push_back(Vec3(1 - u - v, u, v)); };
      at((i + 1.0 / 3) / kSplits, (j + 1.0 / 3) / kSplits);
      if (i + j + 1 < kSplits) at((i + 2.0 / 3) / kSplits, (j + 2.0 / 3) / kSplits);
    }
  return weights;
}

// Where albedo comes from.
class Source {
 public:
  Source(const MeshImport& import, const std::string& file, std::vector<std::string>& notes)
      : import_(import), surface_(workingMesh(import.mesh)), map_of_material_(import.material_textures) {
    const std::vector<std::size_t> triangles = formats::trianglesOfMaterials(import.mesh);
    std::vector<int> map_of_texture(import.textures.size(), kNone);
    for (std::size_t m = 0; m < map_of_material_.size(); ++m) {
      int& map = map_of_material_[m];
      if (map == kNone || (m < triangles.size() && triangles[m] == 0)) continue;  // or not in use
      const auto texture = static_cast<std::size_t>(map);
      if (map_of_texture[texture] == kNone) {
        map_of_texture[texture] = static_cast<int>(maps_.size());
        const formats::AlbedoTexture& from = import.textures[texture];
        maps_.emplace_back(readAlbedoTexture(from, file, notes), from.wrap_u, from.wrap_v);
      }
      map = map_of_texture[texture];
    }
  }

  // The place that a point of a triangle with that normal and material takes its colour from. `near`: that of
  // a point near by, if known; it changes no answer.
  ClosestPoint closest(const Vec3& position, const Vec3& normal, std::optional<std::uint32_t> material,
                       std::optional<std::uint32_t> near) const {
    ClosestPoint point = surface_.closestFacing(position, normal, material, near);
    if (!point.valid) point = surface_.closest(position, material);  // the source is inside out here
    if (!point.valid) point = surface_.closest(position);
    return point;
  }

  // The mean over an area around the point.
  Vec3 colorAt(const ClosestPoint& point, double area) const {
    const auto& corners = import_.mesh.triangles[point.triangle];
    Vec3 color = Vec3::Ones();
    if (!import_.mesh.colors.empty()) {
      color.setZero();
      for (int k = 0; k < 3; ++k) color += point.barycentric[k] * vec3(import_.mesh.colors[corners[k]]);
    }
    const AlbedoMap* map = mapOf(point.triangle);
    if (map == nullptr) return color;
    double u = 0, v = 0;
    for (int k = 0; k < 3; ++k) {
      u += point.barycentric[k] * import_.texture_lookups[corners[k]][0];
      v += point.barycentric[k] * import_.texture_lookups[corners[k]][1];
    }
    return color.cwiseProduct(map->colorAt(u, v, areaOnTexture(point.triangle, area)));
  }

 private:
  static constexpr int kNone = -1;

  const AlbedoMap* mapOf(std::uint32_t triangle) const {
    const auto& materials = import_.mesh.triangle_materials;
    const std::size_t material = materials.empty() ? 0 : materials[triangle];
    if (material >= map_of_material_.size() || map_of_material_[material] == kNone) return nullptr;
    return &maps_[static_cast<std::size_t>(map_of_material_[material])];
  }

  // What share of the texture an area of the triangle has.
  double areaOnTexture(std::uint32_t triangle, double area) const {
    const auto& [a, b, c] = import_.mesh.triangles[triangle];
    const auto &s = import_.texture_lookups[a], &t = import_.texture_lookups[b],
               &u = import_.texture_lookups[c];
    const double across = (t[0] - s[0]) * (u[1] - s[1]) - (t[1] - s[1]) * (u[0] - s[0]);
    const double surface = surface_.mesh().areaVector(triangle).norm();
    return surface > 0 ? std::abs(across) * area / surface : 0;
  }

  const MeshImport& import_;
  SurfaceQuery surface_;
  std::vector<AlbedoMap> maps_;
  std::vector<int> map_of_material_;
};

// Where the materials' own textures are looked up, which a texture transform may have moved; elsewhere the
// mesh's texture coordinates.
std::vector<formats::Float2> lookupsOfAll(const MeshImport& source) {
  const TriangleMesh& mesh = source.mesh;
  std::vector<formats::Float2> lookups = mesh.texcoords.empty() ? source.texture_lookups : mesh.texcoords;
  if (source.texture_lookups.empty()) return lookups;
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const std::size_t material = mesh.triangle_materials[t];
    if (material >= source.material_textures.size() || source.material_textures[material] < 0) continue;
    for (const std::uint32_t v : mesh.triangles[t]) lookups[v] = source.texture_lookups[v];
  }
  return lookups;
}

}  // namespace

std::vector<std::string> replaceAlbedo(MeshImport& source, const std::filesystem::path& texture,
                                       const std::string& file) {
  if (source.mesh.texcoords.empty() && source.texture_lookups.empty())
    throw badInput({file, "", ""}, "has no texture coordinates, so a texture cannot be put on it",
                   "a mesh with texture coordinates", "leave the texture out, or unwrap the mesh");
  std::vector<std::string> notes;
  if (!source.textures.empty())
    notes.push_back(texture.string() + " replaces the mesh's own " + std::to_string(source.textures.size()) +
                    (source.textures.size() == 1 ? " texture" : " textures"));
  if (!source.mesh.colors.empty()) notes.push_back(texture.string() + " replaces the mesh's own colours");
  source.texture_lookups = lookupsOfAll(source);
  source.mesh.colors.clear();
  source.textures = {{texture.string(), texture}};
  source.material_textures.assign(std::max<std::size_t>(source.mesh.material_names.size(), 1), 0);
  return notes;
}

CarriedAlbedo carryAlbedo(const MeshImport& source, const TriangleMesh& simplified, const std::string& file) {
  CarriedAlbedo result;
  if (source.textures.empty() && source.mesh.colors.empty()) return result;
  const Source original(source, file, result.notes);
  const WorkingMesh target = workingMesh(simplified);
  const std::vector<Vec3> weights = sampleWeights();
  std::vector<std::array<Vec3, 3>> shares(target.triangles.size());  // of each triangle, for its corners
  std::vector<double> areas(target.triangles.size());
  tbb::parallel_for(std::size_t{0}, target.triangles.size(), [&](std::size_t t) {
    const Vec3 area = target.areaVector(t);
    areas[t] = area.norm() / 2;
    shares[t].fill(Vec3::Zero());
    std::optional<std::uint32_t> material;
    if (!target.materials.empty() && !source.mesh.triangle_materials.empty()) material = target.materials[t];
    std::optional<std::uint32_t> near;  // where the triangle is the source's own, that one
    for (const Vec3& w : weights) {
      const Vec3 position =
          w[0] * target.corner(t, 0) + w[1] * target.corner(t, 1) + w[2] * target.corner(t, 2);
      const ClosestPoint point = original.closest(position, area, material, near);
      near = point.triangle;
      const double sample_area = areas[t] / static_cast<double>(weights.size());
      const Vec3 color = original.colorAt(point, sample_area) / static_cast<double>(weights.size());
      for (int k = 0; k < 3; ++k) shares[t][k] += w[k] * color;
    }
  });

  std::vector<Vec3> sum(simplified.vertexCount(), Vec3::Zero());
  std::vector<double> weight(simplified.vertexCount(), 0.0);
  for (std::size_t t = 0; t < target.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = target.triangles[t][k];
      sum[v] += areas[t] * shares[t][k];
      weight[v] += areas[t] / 3;
    }
  result.colors.resize(simplified.vertexCount(), Float3{0, 0, 0});
  for (std::size_t v = 0; v < result.colors.size(); ++v)
    if (weight[v] > 0) result.colors[v] = transport::float3((sum[v] / weight[v]).cwiseMax(0.0).cwiseMin(1.0));
  return result;
}

}  // namespace bakelight::simplify
