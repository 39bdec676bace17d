// Figures that judge a simplified mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surface/working_mesh.h"
#include "transport/surface_query.h"

namespace bakelight::surface {

double area(const SurfaceMesh& mesh);
// Signed volume enclosed, about the bounding box's centre; meaningful for closed meshes.
double volume(const WorkingMesh& mesh);
double boundingBoxDiagonal(const SurfaceMesh& mesh);

// Points spread over the surface: `count` of them (to rounding), stratified by area in triangle order, placed
// in their triangles by a fixed low-discrepancy sequence.
struct SurfaceSample {
  Vec3 position;
  std::uint32_t triangle;
};
std::vector<SurfaceSample> surfaceSamples(const SurfaceMesh& mesh, std::size_t count);

// The smallest angle of each triangle: its mean and its minimum over the mesh, degrees (60 at best). A
// triangle without area has 0.
struct AngleQuality {
  double mean_min_angle_deg = 0, worst_min_angle_deg = 0;
};
AngleQuality angleQuality(const WorkingMesh& mesh);

// Distances in the unit of the meshes.
struct Deviation {
  double hausdorff = 0;  // the greatest distance found, either way
  double mean = 0;       // average over both ways
};
// Symmetric, sampled: on each surface all vertices and `samples` points, stratified by area, placed by a
// fixed low-discrepancy sequence. All TBB threads, same result whatever their number.
Deviation deviation(const SurfaceQuery& a, const SurfaceQuery& b, std::size_t samples);

}  // namespace bakelight::surface
