#include "tools/survey/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "transport/camera.h"
#include "transport/mesh_topology.h"

namespace bakelight::survey {

using formats::Triangle;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

// Over the bounding radius. A tenth of what transfer starts its rays with, as the points lie within triangles
// rather than at creases.
constexpr double kRelativeOffset = 1e-5;

double surfaceOffset(const TriangleMesh& mesh) {
  const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
  const double farthest_coordinate = bounds.center.cwiseAbs().maxCoeff() + bounds.radius;
  return std::max(kRelativeOffset * bounds.radius,
                  4 * std::numeric_limits<float>::epsilon() * farthest_coordinate);
}

// By places, the smallest first: the same for each way to write a triangle.
Triangle canonical(const Triangle& triangle, const std::vector<std::uint32_t>& place) {
  Triangle places = {place[triangle[0]], place[triangle[1]], place[triangle[2]]};
  std::rotate(places.begin(), std::min_element(places.begin(), places.end()), places.end());
  return places;
}

// 1 where the back of a triangle can be seen, or is that of another triangle.
std::vector<std::uint8_t> litBehind(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = transport::coincidentVertices(mesh);
  std::vector<std::uint8_t> lit = transport::openTriangles(mesh, place);
  std::vector<Triangle> fronts;
  fronts.reserve(mesh.triangleCount());
  for (const Triangle& triangle : mesh.triangles) fronts.push_back(canonical(triangle, place));
  std::sort(fronts.begin(), fronts.end());
  for (std::size_t t = 0; t < lit.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    const Triangle reversed = canonical({triangle[0], triangle[2], triangle[1]}, place);
    if (std::binary_search(fronts.begin(), fronts.end(), reversed)) lit[t] = 1;
  }
  return lit;
}

}  // namespace

Surface::Surface(const TriangleMesh& mesh, const formats::Float3& albedo)
    : mesh_(mesh), albedo_(vec3(albedo)), offset_(surfaceOffset(mesh)), lit_behind_(litBehind(mesh)) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) area_up_to_.push_back(sum += across(t).norm() / 2);
  if (!(sum > 0)) throw std::invalid_argument("the mesh has no triangle with an area");
}

Vec3 Surface::across(std::uint32_t triangle) const {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const Vec3 origin = vec3(mesh_.positions[a]);
  return (vec3(mesh_.positions[b]) - origin).cross(vec3(mesh_.positions[c]) - origin);
}

SurfacePoint Surface::pointOn(std::uint32_t triangle, double u, double v, bool back) const {
  const Triangle& corners = mesh_.triangles[triangle];
  const auto interpolated = [&](const std::vector<formats::Float3>& values) -> Vec3 {
    return (1 - u - v) * vec3(values[corners[0]]) + u * vec3(values[corners[1]]) +
           v * vec3(values[corners[2]]);
  };
  SurfacePoint point;
  point.triangle = triangle;
  point.normal = across(triangle).normalized() * (back ? -1 : 1);
  point.origin = interpolated(mesh_.positions) + offset_ * point.normal;
  point.albedo = mesh_.colors.empty() ? albedo_ : interpolated(mesh_.colors);
  return point;
}

SurfacePoint Surface::pointAt(double along, double u, double v) const {
  const auto found = std::upper_bound(area_up_to_.begin(), area_up_to_.end(), along * area_up_to_.back());
  // Rounding may lead past the end, and to triangles without an area there.
  auto triangle = static_cast<std::uint32_t>(
      std::min<std::ptrdiff_t>(found - area_up_to_.begin(), std::ssize(area_up_to_) - 1));
  while (!(across(triangle).norm() > 0)) --triangle;
  const double root = std::sqrt(u);
  return pointOn(triangle, root * (1 - v), root * v, false);
}

bool Surface::pointAt(std::uint32_t triangle, double u, double v, bool back_face, SurfacePoint& point) const {
  if (back_face && lit_behind_[triangle] == 0) return false;
  point = pointOn(triangle, u, v, back_face);
  return true;
}

Vec3 Surface::meanAlbedo() const {
  if (mesh_.colors.empty()) return albedo_;
  Vec3 sum = Vec3::Zero();
  double before = 0;
  for (std::size_t t = 0; t < mesh_.triangleCount(); ++t) {
    Vec3 mean = Vec3::Zero();
    for (const std::uint32_t v : mesh_.triangles[t]) mean += vec3(mesh_.colors[v]) / 3;
    sum += (area_up_to_[t] - before) * mean;
    before = area_up_to_[t];
  }
  return sum / area_up_to_.back();
}

Vec3 Surface::mean(const std::vector<formats::Float3>& of_triangles) const {
  Vec3 sum = Vec3::Zero();
  double before = 0;
  for (std::size_t t = 0; t < mesh_.triangleCount(); ++t) {
    sum += (area_up_to_[t] - before) * vec3(of_triangles[t]);
    before = area_up_to_[t];
  }
  return sum / area_up_to_.back();
}

}  // namespace bakelight::survey
