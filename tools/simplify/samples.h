// Points of the original surface, each kept with the triangle of the changing mesh that it lies closest to.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/corner_mesh.h"
#include "tools/simplify/surface_words.h"
#include "transport/surface_query.h"

namespace bakelight::simplify {

// Of each triangle a chain through the samples: operations on different triangles can move theirs at once.
class Samples {
 public:
  // All vertices of `original` and, where those are few, points spread over its triangles: at least
  // `min_count`.
  Samples(const SurfaceQuery& original, std::size_t min_count);

  // Finds the closest triangle of every sample. All TBB threads, as below.
  void assign(const CornerMesh& mesh);
  // Finds it again from where each sample is, by going on to the next triangle as long as that is closer.
  void walk(const CornerMesh& mesh);

  std::size_t count() const { return positions_.size(); }
  const Vec3& position(std::uint32_t sample) const { return positions_[sample]; }
  double distance2(std::uint32_t sample) const { return distance2_[sample]; }
  template <class Visit>
  void forSamples(std::uint32_t triangle, Visit visit) const {
    for (std::uint32_t s = first_[triangle]; s != kNone; s = next_[s]) visit(s);
  }

  void clear(std::uint32_t triangle) { first_[triangle] = kNone; }
  void put(std::uint32_t triangle, std::uint32_t sample, double distance2) {
    next_[sample] = first_[triangle];
    first_[triangle] = sample;
    distance2_[sample] = distance2;
  }
  // For triangles that were added.
  void resize(std::size_t triangles) { first_.resize(triangles, kNone); }
  double meanDistance2() const;

 private:
  struct Foot {
    std::uint32_t triangle;
    double distance2;
  };
  static Foot walked(const CornerMesh& mesh, std::uint32_t triangle, const Vec3& position);
  void chain(std::size_t triangles);

  std::vector<Vec3> positions_, normals_;
  std::vector<double> distance2_;
  std::vector<std::uint32_t> triangle_;  // of each sample, while they are put in chains
  std::vector<std::uint32_t> first_, next_;
};

}  // namespace bakelight::simplify
