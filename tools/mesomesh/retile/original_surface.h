// The surface that a retiling keeps to: its regions, its feature lines, its normals.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "surface/corner_mesh.h"
#include "surface/features.h"
#include "surface/working_mesh.h"
#include "transport/surface_query.h"

namespace bakelight::mesomesh {

using surface::CornerMesh;
using surface::kNone;
using surface::nextSide;
using surface::previousSide;
using surface::Side;
using transport::ClosestPoint;
using transport::SurfaceQuery;
using transport::Vec3;

// A mesh whose vertices slide on an original surface. The materials of `mesh` are regions of the original.
struct SlidingMesh {
  CornerMesh mesh;
  std::vector<std::uint32_t>
      curve;  // of each vertex: the feature line it is kept on; kNone: none, or a corner
  std::vector<std::uint32_t> near;     // of each vertex: a triangle of the original at or near it
  std::vector<std::uint32_t> segment;  // of each vertex on a curve: a segment of it, at or near the vertex

  bool isCorner(std::uint32_t v) const { return mesh.locked[v] != 0; }
  bool isOnCurve(std::uint32_t v) const { return curve[v] != kNone; }
};

// Regions are what features (creases, borders, borders between materials) leave connected: a vertex never
// changes to another sheet or material however near that is. Curves are feature lines from corner to corner,
// or closed ones.
class OriginalSurface {
 public:
  // `mesh` as surface::repair leaves it. Creases: surface::markCreases. All TBB threads.
  OriginalSurface(const surface::WorkingMesh& mesh, double crease_angle_deg, double min_crease_length);

  // The original itself, its feature edges between two corners halved: each feature edge has an end that
  // says which curve it belongs to.
  const SlidingMesh& mesh() const { return mesh_; }
  std::uint32_t regionCount() const { return static_cast<std::uint32_t>(region_materials_.size()); }
  // A material of `mesh` of the constructor; 0 without materials.
  std::uint32_t materialOf(std::uint32_t region) const { return region_materials_[region]; }
  const surface::FeatureCounts& features() const { return features_; }

  // The closest point of the region that faces as `normal` does; invalid if none does.
  ClosestPoint onRegion(const Vec3& position, const Vec3& normal, std::uint32_t region,
                        std::uint32_t near_triangle) const;
  // `triangle` is the segment's number.
  ClosestPoint onCurve(const Vec3& position, std::uint32_t curve, std::uint32_t near_segment) const;
  // Unit, interpolated, smooth but across creases.
  Vec3 normalAt(std::uint32_t triangle, const Vec3& barycentric) const;
  const Vec3& triangleNormal(std::uint32_t triangle) const { return surface_->triangleNormal(triangle); }
  const SurfaceQuery& surface() const { return *surface_; }

 private:
  void findRegions(const surface::WorkingMesh& mesh);
  void halveCornerEdges();
  void findCurves();
  void makeNormals(const std::vector<std::uint8_t>& is_crease);

  SlidingMesh mesh_;
  std::vector<std::uint32_t> region_materials_;
  surface::FeatureCounts features_;
  std::vector<Vec3> corner_normals_;  // of each side's start, in its triangle
  std::optional<SurfaceQuery> surface_, curves_;
};

}  // namespace bakelight::mesomesh
