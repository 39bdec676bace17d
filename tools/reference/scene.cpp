#include "tools/reference/scene.h"

#include <algorithm>
#include <stdexcept>
#include <type_traits>

#include "formats/error.h"
#include "transport/frame.h"
#include "transport/near_light.h"
#include "transport/surface_points.h"

namespace bakelight::reference {
namespace {

using formats::TriangleMesh;
using transport::Float3;
using transport::vec3;

// The mesh, turned about the middle of `bounds`; its colors are what media reflect, where that is the albedo.
TriangleMesh meshInWorld(const TriangleMesh& object, const std::vector<Float3>& reflectance,
                         const formats::FrameSettings& frame, const transport::BoundingSphere& bounds) {
  if (object.triangleCount() == 0)
    throw badInput({"", "mesh", ""}, "the mesh has no triangles", "a mesh to look at");
  if (object.normals.size() != object.vertexCount())
    throw badInput({"", "normals", ""}, "the mesh has no normal for each vertex", "a unit normal a vertex",
                   "run the mesh through simplify, which makes them");
  TriangleMesh mesh;
  mesh.positions = object.positions;
  mesh.normals = object.normals;
  mesh.texcoords = object.texcoords;
  mesh.triangles = object.triangles;
  mesh.colors = reflectance;
  const Eigen::Matrix3d world_from_object = transport::worldFromObject(frame);
  if (world_from_object.isIdentity(0)) return mesh;
  transport::turnAbout(bounds.center, world_from_object, mesh.positions);
  transport::turnAbout(Vec3::Zero(), world_from_object, mesh.normals);
  return mesh;
}

std::vector<Float3> frontOrigins(const TriangleMesh& mesh, double bias) {
  std::vector<Float3> origins;
  for (const auto& point : transport::frontPoints(mesh, bias)) origins.push_back(point.origin);
  return origins;
}

TriangleMesh joined(const TriangleMesh& mesh, const TriangleMesh& other) {
  TriangleMesh whole;
  whole.positions = mesh.positions;
  whole.triangles = mesh.triangles;
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  whole.positions.insert(whole.positions.end(), other.positions.begin(), other.positions.end());
  for (const auto& [a, b, c] : other.triangles) whole.triangles.push_back({first + a, first + b, first + c});
  return whole;
}

// And a diffuse one behind them.
std::vector<Glossy> materialsOf(const Surface& surface) {
  std::vector<Glossy> materials;
  for (std::size_t i = 0; i < surface.material.reflections.size(); ++i) {
    auto table = surface.tables.find(surface.material.names[i]);
    if (table == surface.tables.end()) table = surface.tables.find("");
    materials.push_back(glossyOf(surface.material.reflections[i], surface.model,
                                 table == surface.tables.end() ? nullptr : &table->second));
  }
  materials.emplace_back();
  return materials;
}

// simplify gives no vertex to two materials.
std::vector<std::uint32_t> materialOfVertices(const Surface& surface) {
  const std::vector<std::uint32_t>& of_triangle = surface.material.of_triangle;
  std::vector<std::uint32_t> of_vertex(of_triangle.empty() ? 0 : surface.mesh.vertexCount());
  for (std::size_t t = 0; t < of_triangle.size(); ++t)
    for (const std::uint32_t vertex : surface.mesh.triangles[t]) of_vertex[vertex] = of_triangle[t];
  return of_vertex;
}

// What meshInWorld does, undone.
Eigen::Isometry3d objectFromWorld(const formats::FrameSettings& frame,
                                  const transport::BoundingSphere& bounds) {
  return Eigen::Translation3d(bounds.center) *
         Eigen::Isometry3d(transport::worldFromObject(frame).transpose()) *
         Eigen::Translation3d(-bounds.center);
}

// `Transport` of each medium, by material; null where there is none.
template <class Transport>
std::vector<std::unique_ptr<const Transport>> transportIn(const Surface& surface, const TriangleMesh& mesh,
                                                          const transport::RayScene& rays,
                                                          const Eigen::Isometry3d& object_from_world) {
  const std::vector<std::uint32_t>& of_triangle = surface.material.of_triangle;
  std::vector<std::unique_ptr<const Transport>> of_materials;
  for (std::size_t i = 0; i < surface.material.media.size(); ++i) {
    const std::optional<formats::Medium>& medium = surface.material.media[i];
    of_materials.push_back(nullptr);
    if (!medium) continue;
    std::vector<std::uint8_t> of_medium;
    for (const std::uint32_t material : of_triangle) of_medium.push_back(material == i ? 1 : 0);
    // A name that no face has any more.
    if (!of_medium.empty() && std::find(of_medium.begin(), of_medium.end(), 1) == of_medium.end()) continue;
    if (std::is_same_v<Transport, RandomWalk> && medium->reflectance == formats::ReflectanceSource::kAlbedo)
      throw badInput(
          {"", surface.material.names[i], "/medium/reflectance"},
          "the albedo says what the surface reflects, and nothing about the medium inside, through "
          "which random walks go",
          "\"coefficients\"", "trace it by diffusion: --translucency diffusion");
    try {
      of_materials.back() =
          std::make_unique<Transport>(*medium, mesh, std::move(of_medium), rays, object_from_world);
    } catch (const std::invalid_argument& problem) {
      throw badInput({"", surface.material.names[i], "/medium"}, problem.what());
    }
  }
  return of_materials;
}

}  // namespace

Scene::Scene(const Surface& surface, const formats::LightRig& rig, const formats::FrameSettings& frame,
             const transport::BoundingSphere& bounds)
    : Scene(surface, rig, frame, bounds, transport::emitterMesh(rig, bounds, frame.time_s)) {}

Scene::Scene(const Surface& surface, const formats::LightRig& rig, const formats::FrameSettings& frame,
             const transport::BoundingSphere& bounds, const transport::EmitterMesh& emitters)
    : mesh_(meshInWorld(surface.mesh, surface.material.medium_reflectance, frame, bounds)),
      vertex_origins_(frontOrigins(mesh_, surface.bias)),
      albedo_(vec3(surface.material.albedo)),
      vertex_albedo_(surface.material.vertex_albedo),
      materials_(materialsOf(surface)),
      textures_(surface.textures),
      material_of_triangle_(surface.material.of_triangle),
      material_of_vertex_(materialOfVertices(surface)),
      distant_(rig, transport::worldFromLight(frame)),
      emitters_(emitters),
      ray_mesh_(joined(mesh_, emitters.mesh)),
      rays_(ray_mesh_),
      emitter_rays_(emitters.mesh),
      punctual_(transport::placedPunctualLights(rig, bounds, frame.time_s)),
      offset_(transport::surfaceOffset(mesh_, surface.bias)),
      subsurfaces_(surface.translucency == Translucency::kDiffusion
                       ? transportIn<Subsurface>(surface, mesh_, rays_, objectFromWorld(frame, bounds))
                       : decltype(subsurfaces_)()),
      random_walks_(surface.translucency == Translucency::kRandomWalk
                        ? transportIn<RandomWalk>(surface, mesh_, rays_, objectFromWorld(frame, bounds))
                        : decltype(random_walks_)()) {}

Rgb Scene::albedoOf(std::uint32_t vertex) const {
  return vertex_albedo_.empty() ? albedo_ : Rgb(vec3(vertex_albedo_[vertex]).array());
}

Rgb Scene::textureAt(std::uint32_t material, const formats::Float2& texcoord) const {
  if (material >= textures_.size() || textures_[material] == nullptr) return Rgb::Ones();
  return vec3(textures_[material]->textureAt(texcoord[0], texcoord[1])).array();
}

ShadingPoint Scene::pointAt(const transport::Hit& hit) const {
  const formats::Triangle& corners = mesh_.triangles[hit.triangle];
  const double u = hit.u, v = hit.v;
  const std::array<double, 3> weights = {1 - u - v, u, v};
  Rgb albedo = vertex_albedo_.empty() ? albedo_ : Rgb::Zero();
  if (!vertex_albedo_.empty())
    for (std::size_t i = 0; i < 3; ++i) albedo += weights[i] * albedoOf(corners[i]);
  Rgb reflectance = Rgb::Ones();
  if (!mesh_.colors.empty()) {
    reflectance.setZero();
    for (std::size_t i = 0; i < 3; ++i) reflectance += weights[i] * vec3(mesh_.colors[corners[i]]).array();
  }
  const std::uint32_t material = material_of_triangle_.empty() ? 0 : material_of_triangle_[hit.triangle];
  if (!textures_.empty()) {
    formats::Float2 place = {0, 0};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < 2; ++c)
        place[c] += static_cast<float>(weights[i]) * mesh_.texcoords[corners[i]][c];
    albedo *= textureAt(material, place);
  }
  const transport::SmoothPoint point =
      transport::smoothPoint(mesh_, hit.triangle, u, v, hit.back_face ? -1 : 1);
  return {point.lifted + offset_ * point.normal,
          point.normal,
          albedo,
          material,
          point.position,
          hit.triangle,
          hit.back_face,
          reflectance};
}

ShadingPoint Scene::pointAtVertex(std::uint32_t vertex) const {
  const std::uint32_t material = material_of_vertex_.empty() ? 0 : material_of_vertex_[vertex];
  Rgb albedo = albedoOf(vertex);
  if (!textures_.empty()) albedo *= textureAt(material, mesh_.texcoords[vertex]);
  ShadingPoint point = {vec3(vertex_origins_[vertex]), vec3(mesh_.normals[vertex]).normalized(), albedo,
                        material, vec3(mesh_.positions[vertex])};
  if (!mesh_.colors.empty()) point.reflectance = vec3(mesh_.colors[vertex]).array();
  return point;
}

}  // namespace bakelight::reference
