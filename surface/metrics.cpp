#include "surface/metrics.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>
#include <vector>

namespace bakelight::surface {
namespace {

double minAngle(const WorkingMesh& mesh, std::size_t t) {
  double smallest = std::numbers::pi;
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k),
               v = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
    smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
  }
  return smallest;
}

// Greatest and mean distance from samples of one surface to the other.
Deviation oneWay(const SurfaceMesh& from, const SurfaceQuery& to, std::size_t samples) {
  std::vector<Vec3> points = from.positions;
  for (const SurfaceSample& sample : surfaceSamples(from, samples)) points.push_back(sample.position);
  std::vector<double> distances(points.size());
  constexpr std::size_t kGrain = 512;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      std::uint32_t near_triangle = 0;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const ClosestPoint met = to.closestFrom(near_triangle, points[i]);
                        near_triangle = met.triangle;
                        distances[i] = met.distance;
                      }
                    });
  Deviation result;
  for (const double distance : distances) {
    result.hausdorff = std::max(result.hausdorff, distance);
    result.mean += distance / static_cast<double>(distances.size());
  }
  return result;
}

}  // namespace

double area(const SurfaceMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += mesh.areaVector(t).norm() / 2;
  return sum;
}

double volume(const WorkingMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& position : mesh.positions) box.extend(position);
  if (box.isEmpty()) return 0;
  const Vec3 center = box.center();
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sum += (mesh.corner(t, 0) - center).dot(mesh.areaVector(t)) / 6;
  return sum;
}

double boundingBoxDiagonal(const SurfaceMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& position : mesh.positions) box.extend(position);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

std::vector<SurfaceSample> surfaceSamples(const SurfaceMesh& mesh, std::size_t count) {
  // The R2 sequence (Roberts 2018).
  constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532;
  std::vector<SurfaceSample> samples;
  samples.reserve(count + 1);
  const double stride = area(mesh) / static_cast<double>(count);
  double next = stride / 2, passed = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    passed += mesh.areaVector(t).norm() / 2;
    for (; next < passed; next += stride) {
      const auto k = static_cast<double>(samples.size());
      double u = std::fmod(0.5 + k * kStepU, 1.0), v = std::fmod(0.5 + k * kStepV, 1.0);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      samples.push_back({mesh.corner(t, 0) * (1 - u - v) + mesh.corner(t, 1) * u + mesh.corner(t, 2) * v, t});
    }
  }
  return samples;
}

AngleQuality angleQuality(const WorkingMesh& mesh) {
  if (mesh.triangles.empty()) return {};
  AngleQuality quality{0, 180};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double angle_deg = minAngle(mesh, t) * 180 / std::numbers::pi;
    quality.mean_min_angle_deg += angle_deg / static_cast<double>(mesh.triangles.size());
    quality.worst_min_angle_deg = std::min(quality.worst_min_angle_deg, angle_deg);
  }
  return quality;
}

Deviation deviation(const SurfaceQuery& a, const SurfaceQuery& b, std::size_t samples) {
  const Deviation ab = oneWay(a.mesh(), b, samples), ba = oneWay(b.mesh(), a, samples);
  return {std::max(ab.hausdorff, ba.hausdorff), (ab.mean + ba.mean) / 2};
}

}  // namespace bakelight::surface
