#include "tools/simplify/samples.h"

#include <tbb/parallel_for.h>

#include "tools/simplify/metrics.h"

namespace bakelight::simplify {
namespace {

// A triangle facing a sample's way is its closest up to this many times the distance of any other.
constexpr double kFacingFactor = 2;

}  // namespace

Samples::Samples(const SurfaceQuery& original, std::size_t min_count) {
  const WorkingMesh& mesh = original.mesh();
  positions_ = mesh.positions;
  normals_.assign(mesh.positions.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) normals_[v] += mesh.areaVector(t);
  }
  if (min_count <= positions_.size()) return;
  for (const SurfaceSample& sample : surfaceSamples(mesh, min_count - positions_.size())) {
    positions_.push_back(sample.position);
    normals_.push_back(original.triangleNormal(sample.triangle));
  }
}

void Samples::assign(HalfEdgeMesh& mesh) {
  const SurfaceQuery query(workingMesh(mesh));
  std::vector<SurfacePoint> nearest(count());
  tbb::parallel_for(std::size_t{0}, count(), [&](std::size_t i) {
    nearest[i] = query.closest(positions_[i]);
    // On a thin sheet the far side may be the nearer one. Where nothing facing is near, the normal itself is
    // noise.
    const SurfacePoint facing = query.closestFacing(positions_[i], normals_[i]);
    if (facing.valid && facing.distance <= kFacingFactor * nearest[i].distance) nearest[i] = facing;
  });
  of_face_.assign(mesh.n_faces(), {});
  distance2_.resize(count());
  for (std::uint32_t i = 0; i < count(); ++i) {
    put(mesh.face_handle(nearest[i].triangle), i, nearest[i].distance * nearest[i].distance);
  }
}

double Samples::meanDistance2() const {
  double sum = 0;
  for (const double distance2 : distance2_) sum += distance2;
  return sum / static_cast<double>(count());
}

}  // namespace bakelight::simplify
