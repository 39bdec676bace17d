// Points of the original surface, each kept with the triangle of the changing mesh that it lies closest to.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/simplify/half_edge_mesh.h"
#include "tools/simplify/surface_query.h"

namespace bakelight::simplify {

class Samples {
 public:
  // All vertices of `original` and, where those are few, points spread over its triangles: at least
  // `min_count`.
  Samples(const SurfaceQuery& original, std::size_t min_count);

  // Finds the closest triangle of every sample anew. `mesh` must have no deleted elements. All TBB threads.
  void assign(HalfEdgeMesh& mesh);

  std::size_t count() const { return positions_.size(); }
  const Vec3& position(std::uint32_t sample) const { return positions_[sample]; }
  double distance2(std::uint32_t sample) const { return distance2_[sample]; }
  const std::vector<std::uint32_t>& of(FaceHandle face) const {
    return of_face_[static_cast<std::size_t>(face.idx())];
  }

  void clear(FaceHandle face) { of_face_[static_cast<std::size_t>(face.idx())].clear(); }
  void put(FaceHandle face, std::uint32_t sample, double distance2) {
    of_face_[static_cast<std::size_t>(face.idx())].push_back(sample);
    distance2_[sample] = distance2;
  }
  double meanDistance2() const;

 private:
  std::vector<Vec3> positions_, normals_;
  std::vector<double> distance2_;
  std::vector<std::vector<std::uint32_t>> of_face_;
};

}  // namespace bakelight::simplify
