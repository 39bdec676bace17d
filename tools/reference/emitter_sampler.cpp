#include "tools/reference/emitter_sampler.h"

#include <algorithm>
#include <cmath>

#include "transport/random.h"

namespace bakelight::reference {

using transport::vec3;

namespace {

constexpr std::size_t kTrianglesPerCluster = 64;

}  // namespace

EmitterSampler::EmitterSampler(const transport::EmitterMesh& emitters) {
  const auto& [mesh, radiance] = emitters;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 corner = vec3(mesh.positions[a]), edge1 = vec3(mesh.positions[b]) - corner,
               edge2 = vec3(mesh.positions[c]) - corner, cross = edge1.cross(edge2);
    const Vec3 normal = cross.norm() > 0 ? Vec3(cross.normalized()) : Vec3(Vec3::Zero());
    triangles_.push_back({corner, edge1, edge2, normal, vec3(radiance[a]), 0});
  }
  for (std::size_t first = 0; first < triangles_.size();) {
    std::size_t end = first + 1;
    while (end < triangles_.size() && end - first < kTrianglesPerCluster &&
           (triangles_[end].radiance == triangles_[first].radiance).all())
      ++end;
    addCluster(first, end);
    first = end;
  }
}

void EmitterSampler::addCluster(std::size_t first, std::size_t end) {
  Cluster cluster;
  cluster.first = first;
  cluster.cumulative_area.resize(end - first + 1);
  std::vector<double> areas;
  std::vector<Vec3> corners;
  for (std::size_t t = first; t < end; ++t) {
    Triangle& triangle = triangles_[t];
    triangle.cluster = static_cast<std::uint32_t>(clusters_.size());
    areas.push_back(triangle.edge1.cross(triangle.edge2).norm() / 2);
    for (const Vec3& offset : {Vec3(Vec3::Zero()), triangle.edge1, triangle.edge2})
      corners.emplace_back(triangle.corner + offset);
  }
  for (const Vec3& corner : corners) cluster.center += corner / static_cast<double>(corners.size());
  for (const Vec3& corner : corners)
    cluster.radius = std::max(cluster.radius, (corner - cluster.center).norm());
  cluster.area = transport::accumulateProbabilities(areas, cluster.cumulative_area);
  cluster.power = cluster.area * transport::luminance(transport::float3(triangles_[first].radiance.matrix()));
  clusters_.push_back(cluster);
}

double EmitterSampler::weight(const Cluster& cluster, const Vec3& origin, const Vec3& normal) const {
  if (!(cluster.power > 0)) return 0;
  const Vec3 offset = cluster.center - origin;
  const double square = offset.squaredNorm(), radius_square = cluster.radius * cluster.radius;
  if (square <= radius_square) return cluster.power / radius_square;
  // Largest cosine within the cone that holds the cluster.
  const double cosine = normal.dot(offset) / std::sqrt(square),
               sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double spread_sine = cluster.radius / std::sqrt(square),
               spread_cosine = std::sqrt(1 - spread_sine * spread_sine);
  const double largest = cosine >= spread_cosine ? 1.0 : cosine * spread_cosine + sine * spread_sine;
  return cluster.power * std::max(0.0, largest) / square;
}

EmitterSampler::Sample EmitterSampler::sample(const Vec3& origin, const Vec3& normal, double u,
                                              double v) const {
  thread_local std::vector<double> weights, cumulative;
  weights.clear();
  for (const Cluster& cluster : clusters_) weights.push_back(weight(cluster, origin, normal));
  cumulative.resize(weights.size() + 1);
  if (!(transport::accumulateProbabilities(weights, cumulative) > 0)) return {};
  const transport::DrawnInterval drawn = transport::drawInterval(cumulative, u);
  const Cluster& cluster = clusters_[drawn.index];
  const transport::DrawnInterval within = transport::drawInterval(cluster.cumulative_area, drawn.rest);
  const std::size_t index = cluster.first + within.index;
  const Triangle& triangle = triangles_[index];
  // Uniform in the triangle: Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
  double b1 = within.rest, b2 = v;
  if (b2 > b1) {
    b1 /= 2;
    b2 -= b1;
  } else {
    b2 /= 2;
    b1 -= b2;
  }
  const Vec3 offset = triangle.corner + b1 * triangle.edge1 + b2 * triangle.edge2 - origin;
  Sample sample;
  sample.distance = offset.norm();
  sample.triangle = static_cast<std::uint32_t>(index);
  if (!(sample.distance > 0)) return {};
  sample.direction = offset / sample.distance;
  const double density = densityOnTriangle(triangle, sample.direction, sample.distance);
  if (std::isfinite(density))
    sample.density_per_sr = density * (cumulative[drawn.index + 1] - cumulative[drawn.index]);
  return sample;
}

double EmitterSampler::densityOnTriangle(const Triangle& triangle, const Vec3& direction,
                                         double distance) const {
  return distance * distance / (clusters_[triangle.cluster].area * std::abs(triangle.normal.dot(direction)));
}

double EmitterSampler::densityPerSr(const Vec3& origin, const Vec3& normal, std::uint32_t index,
                                    const Vec3& direction, double distance) const {
  const Triangle& triangle = triangles_[index];
  double total = 0;
  for (const Cluster& cluster : clusters_) total += weight(cluster, origin, normal);
  if (!(total > 0)) return 0;
  return weight(clusters_[triangle.cluster], origin, normal) / total *
         densityOnTriangle(triangle, direction, distance);
}

}  // namespace bakelight::reference
