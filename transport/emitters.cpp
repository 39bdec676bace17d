// Near-field emitters, placed in time.
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

#include "transport/light_rig.h"

namespace bakelight::transport {
namespace {

constexpr int kSphereSubdivisions = 3;

// Icosahedron split `subdivisions` times, on the unit sphere.
formats::TriangleMesh unitIcosphere(int subdivisions) {
  const double g = std::numbers::phi;
  std::vector<Vec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3& point : points) point.normalize();
  std::vector<formats::Triangle> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return it->second;
    };
    std::vector<formats::Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  formats::TriangleMesh mesh;
  for (const Vec3& point : points) mesh.positions.push_back(float3(point));
  mesh.normals = mesh.positions;
  mesh.triangles = std::move(triangles);
  return mesh;
}

double surfaceArea(const formats::TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 ab = vec3(mesh.positions[b]) - vec3(mesh.positions[a]);
    area += ab.cross(vec3(mesh.positions[c]) - vec3(mesh.positions[a])).norm() / 2;
  }
  return area;
}

// Mean projected area of a convex body is a quarter of its surface (Cauchy): with the sphere's surface it
// looks, on average, as large as the sphere.
formats::TriangleMesh sphereMesh(double radius) {
  static const formats::TriangleMesh kUnit = unitIcosphere(kSphereSubdivisions);
  static const double kScale = std::sqrt(4 * std::numbers::pi / surfaceArea(kUnit));
  formats::TriangleMesh mesh = kUnit;
  for (Float3& position : mesh.positions) position = float3(radius * kScale * vec3(position));
  return mesh;
}

formats::TriangleMesh quadMesh(const formats::Emitter& emitter) {
  const Vec3 normal = vec3(emitter.normal).normalized();
  Vec3 right = Vec3::UnitY().cross(normal);
  right = right.norm() > 1e-6 ? right.normalized() : Vec3::UnitX();
  const Vec3 up = normal.cross(right);
  formats::TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
    mesh.positions.push_back(float3(x * emitter.width * right + y * emitter.height * up));
  mesh.normals.assign(4, float3(normal));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// Area-weighted means of the triangles' normals; +Y at vertices of no triangle.
std::vector<Float3> vertexNormals(const formats::TriangleMesh& mesh) {
  std::vector<Vec3> sums(mesh.vertexCount(), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 ab = vec3(mesh.positions[b]) - vec3(mesh.positions[a]);
    const Vec3 normal = ab.cross(vec3(mesh.positions[c]) - vec3(mesh.positions[a]));
    for (const std::uint32_t vertex : {a, b, c}) sums[vertex] += normal;
  }
  std::vector<Float3> normals;
  for (const Vec3& sum : sums) normals.push_back(sum.norm() > 0 ? float3(sum.normalized()) : Float3{0, 1, 0});
  return normals;
}

formats::TriangleMesh scaledMesh(const formats::Emitter& emitter) {
  formats::TriangleMesh mesh = emitter.mesh;
  for (Float3& position : mesh.positions) position = float3(emitter.scale * vec3(position));
  if (mesh.normals.size() != mesh.vertexCount()) mesh.normals = vertexNormals(mesh);
  return mesh;
}

// About the emitter's own centre, in the rig's unit of length.
formats::TriangleMesh shapeOf(const formats::Emitter& emitter) {
  switch (emitter.shape) {
    case formats::Emitter::Shape::kQuad:
      return quadMesh(emitter);
    case formats::Emitter::Shape::kSphere:
      return sphereMesh(emitter.radius);
    case formats::Emitter::Shape::kMesh:
      break;
  }
  return scaledMesh(emitter);
}

void append(EmitterMesh& whole, const formats::TriangleMesh& part, const Float3& radiance) {
  const auto base = static_cast<std::uint32_t>(whole.mesh.vertexCount());
  whole.mesh.positions.insert(whole.mesh.positions.end(), part.positions.begin(), part.positions.end());
  whole.mesh.normals.insert(whole.mesh.normals.end(), part.normals.begin(), part.normals.end());
  for (const auto& [a, b, c] : part.triangles) whole.mesh.triangles.push_back({base + a, base + b, base + c});
  whole.radiance.resize(whole.mesh.vertexCount(), radiance);
}

}  // namespace

Eigen::Isometry3d rigFromBody(const Float3& position, const formats::Motion& motion, double time_s) {
  const Vec3 start = vec3(position);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  // Whole periods are taken off before anything rounds.
  const double phase_rad = 2 * std::numbers::pi * std::fmod(time_s / motion.period_s, 1.0);
  if (motion.kind == formats::Motion::Kind::kOrbit) {
    const Vec3 center = vec3(motion.center);
    pose.linear() = Eigen::AngleAxisd(phase_rad, vec3(motion.axis).normalized()).toRotationMatrix();
    pose.translation() = center + pose.linear() * (start - center);
  } else if (motion.kind == formats::Motion::Kind::kShuttle) {
    pose.translation() = start + (vec3(motion.to) - start) * (1 - std::cos(phase_rad)) / 2;
  } else {
    pose.translation() = start;
  }
  return pose;
}

EmitterMesh emitterMesh(const formats::LightRig& rig, const BoundingSphere& object, double time_s) {
  const double unit = rig.object_units ? object.radius : 1;
  const Vec3 origin = rig.object_units ? object.center : Vec3::Zero();
  EmitterMesh whole;
  for (const formats::Emitter& emitter : rig.emitters) {
    const Eigen::Isometry3d pose = rigFromBody(emitter.position, emitter.motion, time_s);
    formats::TriangleMesh part = shapeOf(emitter);
    for (Float3& position : part.positions) position = float3(origin + unit * (pose * vec3(position)));
    for (Float3& normal : part.normals) normal = float3(pose.linear() * vec3(normal));
    append(whole, part, emitter.radiance);
  }
  return whole;
}

}  // namespace bakelight::transport
