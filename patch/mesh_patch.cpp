#include "patch/mesh_patch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "formats/error.h"
#include "patch/creased_normals.h"

namespace bakelight::patch {
namespace {

using formats::TriangleMesh;

constexpr double kMostPeriods = 4, kMostDepth = 100;

struct Box {
  std::array<double, 3> low, high;
  double extent(std::size_t axis) const { return high[axis] - low[axis]; }
};

Float3 turned(const Float3& v, formats::PatchMesh::Up up) {
  return up == formats::PatchMesh::Up::kZ ? v : Float3{v[0], -v[2], v[1]};
}

// Of what is used.
Box boundsOf(const TriangleMesh& mesh) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle)
      for (std::size_t c = 0; c < 3; ++c) {
        box.low[c] = std::min<double>(box.low[c], mesh.positions[v][c]);
        box.high[c] = std::max<double>(box.high[c], mesh.positions[v][c]);
      }
  return box;
}

std::array<double, 2> periodOf(const Box& box, const formats::PatchMesh& settings, const std::string& file) {
  const std::array<double, 2> period = settings.period.value_or(std::array{box.extent(0), box.extent(1)});
  for (std::size_t c = 0; c < 2; ++c) {
    if (!(period[c] > 0))
      throw badInput({file, "", ""}, "the mesh has no extent across the patch",
                     "a surface in x and y, with z (or y, with \"up\": \"y\") out of it",
                     "turn the mesh, or give the patch's \"period\"");
    if (box.extent(c) > kMostPeriods * period[c])
      throw badInput({file, "", ""},
                     fmt::format("the mesh is {:.4g} wide, and its period {:.4g}", box.extent(c), period[c]),
                     "at most 4 periods", "give the patch's \"period\" in the mesh's own unit");
  }
  if (box.extent(2) > kMostDepth * period[0])
    throw badInput(
        {file, "", ""},
        fmt::format("the mesh is {:.4g} deep, and its period {:.4g} wide", box.extent(2), period[0]),
        "at most 100 widths", "check which axis points out of the patch (\"up\")");
  return period;
}

// The mesh and its mirror image at the far side of the patch.
void addMirrored(TriangleMesh& mesh, std::size_t axis, float side) {
  const auto base = static_cast<std::uint32_t>(mesh.vertexCount());
  for (std::uint32_t v = 0; v < base; ++v) {
    Float3 position = mesh.positions[v], normal = mesh.normals[v];
    position[axis] = 2 * side - position[axis], normal[axis] = -normal[axis];
    mesh.positions.push_back(position);
    mesh.normals.push_back(normal);
    if (!mesh.colors.empty()) mesh.colors.push_back(Float3(mesh.colors[v]));
  }
  const std::size_t triangles = mesh.triangleCount();
  for (std::size_t t = 0; t < triangles; ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    mesh.triangles.push_back({base + a, base + c, base + b});
  }
}

}  // namespace

PatchGeometry meshPatch(const TriangleMesh& given, const formats::PatchMesh& settings, bool periodic,
                        const std::string& file) {
  if (given.triangleCount() == 0) throw badInput({file, "", ""}, "it has no triangles", "a mesh with some");
  TriangleMesh mesh;
  mesh.triangles = given.triangles;
  mesh.colors = given.colors;
  for (const Float3& p : given.positions) mesh.positions.push_back(turned(p, settings.up));
  for (const Float3& n : given.normals) mesh.normals.push_back(turned(n, settings.up));
  const Box box = boundsOf(mesh);
  const std::array<double, 2> period = periodOf(box, settings, file);
  const std::array<double, 3> origin = {box.low[0], box.low[1], (box.low[2] + box.high[2]) / 2};
  for (Float3& p : mesh.positions)
    for (std::size_t c = 0; c < 3; ++c) p[c] = static_cast<float>((p[c] - origin[c]) / period[0]);
  PatchGeometry geometry;
  geometry.aspect = period[1] / period[0];
  const double copies = periodic ? 1 : 2;
  geometry.period_x = copies, geometry.period_y = copies * geometry.aspect;
  // Creases do not care for what a mirror image would continue.
  geometry.mesh = mesh.normals.empty() ? withCreasedNormals(mesh, 1, geometry.aspect) : std::move(mesh);
  if (!periodic) {
    addMirrored(geometry.mesh, 0, 1);
    addMirrored(geometry.mesh, 1, static_cast<float>(geometry.aspect));
  }
  return geometry;
}

}  // namespace bakelight::patch
