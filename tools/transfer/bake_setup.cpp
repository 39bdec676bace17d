#include "tools/transfer/bake_setup.h"

#include <algorithm>
#include <stdexcept>

#include "formats/error.h"
#include "transport/camera.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using formats::TriangleMesh;
using transport::coefficientCount;

namespace {

bool isGray(const Float3& color) {
  return color[0] == color[1] && color[1] == color[2];
}

std::vector<Float3> albedoOfVertices(const TriangleMesh& mesh, std::span<const Float3> albedo) {
  if (albedo.size() == mesh.vertexCount()) return {albedo.begin(), albedo.end()};
  if (albedo.size() > 1) throw std::invalid_argument("one albedo, or one a vertex, is needed");
  return std::vector<Float3>(mesh.vertexCount(), albedo.empty() ? Float3{1, 1, 1} : albedo.front());
}

std::optional<VirtualSphere> virtualSphere(const TriangleMesh& mesh, double radius) {
  if (radius == 0) return std::nullopt;
  if (radius <= 1) throw std::invalid_argument("the virtual sphere must enclose the object");
  const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
  if (bounds.radius == 0)
    throw badInput({"", "mesh", "/near_field"}, "the mesh has no extent, so no virtual sphere is around it",
                   "vertices at two places or more", "leave near_field out");
  return VirtualSphere{bounds.center, radius * bounds.radius};
}

}  // namespace

BakeSetup::BakeSetup(const TriangleMesh& own_mesh, std::span<const Float3> own_albedo,
                     const TransferOptions& own_options)
    : mesh(own_mesh),
      options(own_options),
      coefficients(coefficientCount(own_options.order)),
      albedo(albedoOfVertices(own_mesh, own_albedo)),
      sphere(virtualSphere(own_mesh, own_options.sphere_radius)) {
  if (interreflected() && options.glossy == Glossy::kVisibility)
    throw std::invalid_argument("a visibility vector cannot hold interreflection");
  if (!options.tangents.empty() && options.tangents.size() != mesh.vertexCount())
    throw std::invalid_argument("there must be a tangent a vertex, or none");
  if (options.entered_ior > 0 && (interreflected() || options.glossy != Glossy::kNone))
    throw std::invalid_argument("what enters a medium is diffuse transfer without bounces");
  if (fitted() && options.glossy != Glossy::kNone)
    throw std::invalid_argument("transfer matrices are those at the vertices");
  if (options.original != nullptr && interreflected())
    throw std::invalid_argument("light that bounces off the original is not known");
  channels = interreflected() && !std::all_of(albedo.begin(), albedo.end(), isGray) ? 3 : 1;
  const int visibility_order = options.glossy == Glossy::kNone ? 0 : options.row_order + options.order - 1;
  visibility_size = coefficientCount(visibility_order);
  if (options.transport == Transport::kUnshadowed) return;

  fronts = frontPoints(mesh, options.bias);
  if (interreflected()) sides_from_behind = sidesFromBehind(mesh);
  scene = std::make_unique<transport::RayScene>(mesh);
  pass = std::make_unique<ShadowPass>(mesh, *scene,
                                      ShadowOptions{options.order, visibility_order, sphere, interreflected(),
                                                    options.entered_ior, interreflected() && needsMatrices()},
                                      options.directions);
  if (interreflected()) memory = planMemory(*this);
}

std::vector<formats::Float4> BakeSetup::tangents() const {
  return options.tangents.empty() ? vertexTangents(mesh) : options.tangents;
}

std::size_t BakeSetup::matrixSize() const {
  return coefficientCount(options.row_order) * coefficients;
}

}  // namespace bakelight::transfer
