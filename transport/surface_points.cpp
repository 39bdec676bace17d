#include "transport/surface_points.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "transport/camera.h"
#include "transport/mesh_topology.h"

namespace bakelight::transport {

using formats::TriangleMesh;

namespace {

std::vector<std::uint8_t> onCrease(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = coincidentVertices(mesh);
  std::vector<std::uint8_t> crease_place(mesh.vertexCount(), 0), crease(mesh.vertexCount(), 0);
  for (std::size_t v = 0; v < place.size(); ++v)
    if (mesh.normals[v] != mesh.normals[place[v]]) crease_place[place[v]] = 1;
  for (std::size_t v = 0; v < place.size(); ++v) crease[v] = crease_place[place[v]];
  return crease;
}

// Mean of the centroids of the triangles at each vertex, from the vertex.
std::vector<Vec3> towardsTriangles(const TriangleMesh& mesh) {
  std::vector<Vec3> mean(mesh.vertexCount(), Vec3::Zero());
  std::vector<int> count(mesh.vertexCount(), 0);
  for (const auto& triangle : mesh.triangles) {
    Vec3 centroid = Vec3::Zero();
    for (const auto v : triangle) centroid += vec3(mesh.positions[v]) / 3;
    for (const auto v : triangle) mean[v] += centroid - vec3(mesh.positions[v]), ++count[v];
  }
  for (std::size_t v = 0; v < mean.size(); ++v)
    if (count[v] > 0) mean[v] /= count[v];
  return mean;
}

}  // namespace

float surfaceOffset(const TriangleMesh& mesh, double bias) {
  const BoundingSphere bounds = boundingSphere(mesh);
  const double farthest_coordinate = bounds.center.cwiseAbs().maxCoeff() + bounds.radius;
  return static_cast<float>(
      std::max(bias * bounds.radius, 4 * std::numeric_limits<float>::epsilon() * farthest_coordinate));
}

std::vector<SurfacePoint> frontPoints(const TriangleMesh& mesh, double bias) {
  const float offset = surfaceOffset(mesh, bias);
  const std::vector<std::uint8_t> crease = onCrease(mesh);
  const std::vector<Vec3> inward = towardsTriangles(mesh);
  std::vector<SurfacePoint> points(mesh.vertexCount());
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v].normal = mesh.normals[v];
    for (std::size_t c = 0; c < 3; ++c)
      points[v].origin[c] = mesh.positions[v][c] + offset * mesh.normals[v][c];
    const double distance = inward[v].norm();
    if (crease[v] == 0 || distance == 0) continue;
    const Vec3 moved = vec3(points[v].origin) + inward[v] * std::min(offset / distance, 0.25);
    points[v].origin = float3(moved);
  }
  return points;
}

SmoothPoint smoothPoint(const TriangleMesh& mesh, std::uint32_t triangle, double u, double v, double side) {
  const formats::Triangle& corners = mesh.triangles[triangle];
  std::array<double, 3> weights = {std::max(1 - u - v, 0.0), std::max(u, 0.0), std::max(v, 0.0)};
  for (const double sum = weights[0] + weights[1] + weights[2]; double& weight : weights) weight /= sum;
  SmoothPoint point{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (std::size_t i = 0; i < 3; ++i) {
    point.position += weights[i] * vec3(mesh.positions[corners[i]]);
    point.normal += weights[i] * vec3(mesh.normals[corners[i]]);
  }
  const double length = point.normal.norm();
  if (length > 1e-6) {
    point.normal *= side / length;
  } else {
    const Vec3 a = vec3(mesh.positions[corners[0]]);
    point.normal =
        side *
        (vec3(mesh.positions[corners[1]]) - a).cross(vec3(mesh.positions[corners[2]]) - a).normalized();
  }
  point.lifted = point.position;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 vertex_normal = side * vec3(mesh.normals[corners[i]]);
    const double below = (point.position - vec3(mesh.positions[corners[i]])).dot(vertex_normal);
    point.lifted -= weights[i] * std::min(0.0, below) * vertex_normal;
  }
  return point;
}

}  // namespace bakelight::transport
