#include "tools/transfer/surface_points.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

#include "transport/mesh_topology.h"
#include "transport/texture_frames.h"

namespace bakelight::transfer {

using formats::Float4;
using formats::Triangle;
using formats::TriangleMesh;
using transport::float3;
using transport::Vec3;
using transport::vec3;

SurfacePoint backPoint(const TriangleMesh& mesh, const SurfacePoint& front, std::uint32_t vertex) {
  SurfacePoint back;
  for (std::size_t c = 0; c < 3; ++c) {
    back.normal[c] = -front.normal[c];
    back.origin[c] = 2 * mesh.positions[vertex][c] - front.origin[c];
  }
  return back;
}

namespace {

// Corners turned so that the smallest place comes first: the same for each way to write a triangle.
struct PlacedTriangle {
  Triangle places, corners;
};
PlacedTriangle placed(const Triangle& triangle, std::span<const std::uint32_t> place, bool reversed) {
  Triangle corners = triangle;
  if (reversed) std::swap(corners[1], corners[2]);
  const auto smaller = [&](std::uint32_t a, std::uint32_t b) { return place[a] < place[b]; };
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end(), smaller), corners.end());
  return {{place[corners[0]], place[corners[1]], place[corners[2]]}, corners};
}

}  // namespace

std::vector<Triangle> sidesFromBehind(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = transport::coincidentVertices(mesh);
  const std::vector<std::uint8_t> open = transport::openTriangles(mesh, place);
  const auto vertex_count = static_cast<std::uint32_t>(mesh.vertexCount());
  // By places; the first in the mesh of those at the same ones comes first.
  struct Front {
    Triangle places;
    std::uint32_t triangle;
    bool operator<(const Front& other) const {
      return std::tie(places, triangle) < std::tie(other.places, other.triangle);
    }
  };
  std::vector<Front> fronts(mesh.triangleCount());
  tbb::parallel_for(std::size_t{0}, fronts.size(), [&](std::size_t t) {
    fronts[t] = {placed(mesh.triangles[t], place, false).places, static_cast<std::uint32_t>(t)};
  });
  tbb::parallel_sort(fronts.begin(), fronts.end());
  std::vector<Triangle> sides(mesh.triangleCount());
  tbb::parallel_for(std::size_t{0}, sides.size(), [&](std::size_t t) {
    const Triangle& triangle = mesh.triangles[t];
    const Triangle reversed = placed(triangle, place, true).places;
    const auto twin = std::lower_bound(fronts.begin(), fronts.end(), Front{reversed, 0});
    const bool twice = twin != fronts.end() && twin->places == reversed;
    Triangle side = {kDarkSide, kDarkSide, kDarkSide};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (twice) {
        for (const std::uint32_t v : placed(mesh.triangles[twin->triangle], place, false).corners)
          if (place[v] == place[triangle[corner]]) side[corner] = v;
      } else if (open[t] != 0) {
        side[corner] = triangle[corner] + vertex_count;
      }
    }
    sides[t] = side;
  });
  return sides;
}

std::vector<Float4> vertexTangents(const TriangleMesh& mesh) {
  std::vector<Float4> tangents;
  tangents.reserve(mesh.vertexCount());
  for (const Float3& normal : mesh.normals) tangents.push_back(transport::anyTangent(normal));
  return tangents;
}

Eigen::Matrix3d localFromObject(const Float3& normal, const Float4& tangent) {
  const Vec3 n = vec3(normal).normalized();
  // Floats are orthogonal to 1e-7 only; rotations of SH want better.
  const Vec3 t0(tangent[0], tangent[1], tangent[2]);
  const Vec3 t = (t0 - n * n.dot(t0)).normalized();
  Eigen::Matrix3d local;
  local.row(0) = t;
  local.row(1) = tangent[3] * n.cross(t);
  local.row(2) = n;
  return local;
}

}  // namespace bakelight::transfer
