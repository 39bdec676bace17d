#include "tools/simplify/samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "surface/metrics.h"
#include "tools/simplify/surface_words.h"
#include "transport/triangle_distance.h"

namespace bakelight::simplify {
namespace {

// A triangle facing a sample's way is its closest up to this many times the distance of any other.
constexpr double kFacingFactor = 2;
constexpr std::size_t kGrain = 512;
// Steps to a next triangle; samples are at most a few away from where they were.
constexpr int kMaxSteps = 16;

}  // namespace

Samples::Samples(const SurfaceQuery& original, std::size_t min_count) {
  const SurfaceMesh& mesh = original.mesh();
  positions_ = mesh.positions;
  normals_.assign(mesh.positions.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 area = mesh.areaVector(t);
    for (const std::uint32_t v : mesh.triangles[t]) normals_[v] += area;
  }
  if (min_count <= positions_.size()) return;
  for (const SurfaceSample& sample : surfaceSamples(mesh, min_count - positions_.size())) {
    positions_.push_back(sample.position);
    normals_.push_back(original.triangleNormal(sample.triangle));
  }
}

void Samples::assign(const CornerMesh& mesh) {
  SurfaceMesh surface;
  surface.positions = mesh.positions;
  surface.triangles = mesh.triangles;
  const SurfaceQuery query(std::move(surface));
  triangle_.resize(count());
  distance2_.resize(count());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count(), kGrain), [&](const tbb::blocked_range<std::size_t>& range) {
        std::uint32_t near_triangle = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          // On a thin sheet the far side may be the nearer one. Where nothing facing is near, the normal
          // itself is noise.
          const ClosestPoint nearest =
              query.closestPreferFacing(positions_[i], normals_[i], kFacingFactor, near_triangle);
          near_triangle = triangle_[i] = nearest.triangle;
          distance2_[i] = nearest.distance * nearest.distance;
        }
      });
  chain(mesh.triangles.size());
}

void Samples::walk(const CornerMesh& mesh) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.triangles.size(), kGrain / 8),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t t = range.begin(); t < range.end(); ++t) {
                        forSamples(static_cast<std::uint32_t>(t), [&](std::uint32_t sample) {
                          const Foot foot = walked(mesh, static_cast<std::uint32_t>(t), positions_[sample]);
                          triangle_[sample] = foot.triangle;
                          distance2_[sample] = foot.distance2;
                        });
                      }
                    });
  chain(mesh.triangles.size());
}

Samples::Foot Samples::walked(const CornerMesh& mesh, std::uint32_t triangle, const Vec3& position) {
  Vec3 weights;
  const auto distance2 = [&](std::uint32_t t) {
    const Triangle& corners = mesh.triangles[t];
    const Vec3 &a = mesh.positions[corners[0]], &b = mesh.positions[corners[1]],
               &c = mesh.positions[corners[2]];
    weights = transport::closestWeights(a, b, c, position);
    return (weights[0] * a + weights[1] * b + weights[2] * c - position).squaredNorm();
  };
  Foot foot{triangle, distance2(triangle)};
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vec3 here = weights;
    Foot best = foot;
    Vec3 best_weights = here;
    for (std::uint32_t k = 0; k < 3; ++k) {
      // Corner k weighs nothing on the side from the next corner to the one after.
      const Side beyond = mesh.opposite[3 * foot.triangle + (k + 1) % 3];
      if (here[k] > 0 || beyond == kNone) continue;
      const double met = distance2(beyond / 3);
      if (met < best.distance2) best = {beyond / 3, met}, best_weights = weights;
    }
    if (best.triangle == foot.triangle) break;
    foot = best;
    weights = best_weights;
  }
  return foot;
}

void Samples::chain(std::size_t triangles) {
  first_.assign(triangles, kNone);
  next_.resize(count());
  for (std::uint32_t i = static_cast<std::uint32_t>(count()); i-- > 0;) {
    next_[i] = first_[triangle_[i]];
    first_[triangle_[i]] = i;
  }
}

double Samples::meanDistance2() const {
  double sum = 0;
  for (const double distance2 : distance2_) sum += distance2;
  return sum / static_cast<double>(count());
}

}  // namespace bakelight::simplify
