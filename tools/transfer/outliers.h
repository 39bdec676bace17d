// Single vertices whose light is unlike that of everything around them.
//
// Transfer is taken at a point and stands for the area that the vertex's hat function covers. A point at the
// bottom of a fold or a pit far narrower than the triangles around it stands for no area: it shows as one
// black vertex among bright ones, as wide as its triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/transfer/surface_points.h"

namespace bakelight::transfer {

// The triangles at each vertex, in their order.
class IncidentTriangles {
 public:
  explicit IncidentTriangles(const formats::TriangleMesh& mesh);
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(triangles_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }

 private:
  std::vector<std::uint32_t> begin_, triangles_;
};

// Bands that vertices are judged by, whatever the order of the bake: which vertex stands out does not depend
// on it.
inline constexpr int kJudgedOrder = 3;

// Judges diffuse transfer vectors by what they show under lamps from all around.
class OutlierJudge {
 public:
  // All are kept by reference. `vectors`: one channel, n rows of `row_size` ≥ kJudgedOrder² coefficients.
  // `left_out` has one entry a vertex: those that are 1 are no outliers, and say nothing of their neighbours.
  OutlierJudge(const formats::TriangleMesh& mesh, const IncidentTriangles& incident,
               std::span<const float> vectors, std::size_t row_size, std::span<const std::uint8_t> left_out);

  // How far `vector` in place of the vertex's own would leave the range of the neighbours that face the same
  // way, beyond half that range's width: the worst lamp, as a share of what a lamp gives a surface that faces
  // it. At most 0 for a vertex with too few such neighbours to say.
  double score(std::uint32_t vertex, std::span<const float> vector) const;
  // Whether the vertex's own vector is beyond all of `area` (rows as in the table) under some lamp, by a
  // margin: its point stands for nothing around it, not even for what is nearest. Where light changes over
  // the area, as where two parts meet, it does not.
  bool standsAlone(std::uint32_t vertex, std::span<const float> area) const;
  // Vertices whose own vector scores more than kOutlierScore, worst first. Cost: n × lamps × kJudgedOrder² ×
  // 7 multiply-adds, in parallel.
  std::vector<std::uint32_t> outliers() const;

 private:
  const formats::TriangleMesh& mesh_;
  const IncidentTriangles& incident_;
  std::span<const float> vectors_;
  std::size_t row_size_;
  std::span<const std::uint8_t> left_out_;
  std::vector<float> lamps_;  // lamps × kJudgedOrder²
};

// About where a vertex begins to be seen as a spot on a smoothly lit surface.
inline constexpr double kOutlierScore = 0.07;

// Points on the triangles at a vertex, distributed as its hat function is, so that a plain mean over them is
// the mean over the function; normals interpolated, `offset` off the surface. None for a vertex without area.
std::vector<SurfacePoint> hatSamples(const formats::TriangleMesh& mesh, const IncidentTriangles& incident,
                                     std::uint32_t vertex, float offset, int count);

}  // namespace bakelight::transfer
