// Closest points on a triangle mesh; Embree's point query behind it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// A surface in double precision: positions, and materials where they matter.
struct SurfaceMesh {
  std::vector<Vec3> positions;
  std::vector<formats::Triangle> triangles;   // counter-clockwise seen from outside
  std::vector<std::uint32_t> materials = {};  // of each triangle; empty where there are none

  const Vec3& corner(std::size_t triangle, int k) const { return positions[triangles[triangle][k]]; }
  // Twice the area, along the normal.
  Vec3 areaVector(std::size_t triangle) const {
    return (corner(triangle, 1) - corner(triangle, 0)).cross(corner(triangle, 2) - corner(triangle, 0));
  }
};

struct ClosestPoint {
  bool valid = false;  // false only if no triangle qualifies
  double distance = 0;
  Vec3 position = Vec3::Zero();
  std::uint32_t triangle = 0;
  Vec3 barycentric = Vec3::Zero();  // weights of the triangle's three vertices, sum 1
};

// The tree is in single precision, distances are double; the search radius keeps a margin over the tree's
// rounding, and equal distances go to the smallest triangle index, so that the answer depends neither on the
// instruction set Embree chose nor on the order in which it walks. Thread-safe. About 2 µs a query near the
// surface; less where a triangle is named that is about as near as the closest (it changes no answer).
class SurfaceQuery {
 public:
  // Keeps its own copy of the mesh.
  explicit SurfaceQuery(SurfaceMesh mesh);
  ~SurfaceQuery();
  SurfaceQuery(const SurfaceQuery&) = delete;
  SurfaceQuery& operator=(const SurfaceQuery&) = delete;

  // Only among triangles of one material, if that is given; the mesh must have materials then.
  using Material = std::optional<std::uint32_t>;

  ClosestPoint closest(const Vec3& position, Material material = std::nullopt,
                       std::optional<std::uint32_t> near_triangle = std::nullopt) const;
  // Only among triangles whose normal is within 90° of `normal`, so that the far side of a thin sheet is
  // never met.
  ClosestPoint closestFacing(const Vec3& position, const Vec3& normal, Material material = std::nullopt,
                             std::optional<std::uint32_t> near_triangle = std::nullopt) const;

  // The closest of those where it is no farther than `factor` (≥ 1) times the closest of all; else that one.
  ClosestPoint closestPreferFacing(const Vec3& position, const Vec3& normal, double factor,
                                   std::uint32_t near_triangle) const;
  // The closest of all, from a triangle near it.
  ClosestPoint closestFrom(std::uint32_t near_triangle, const Vec3& position) const;
  // Whether any point of the surface is that near.
  bool within(const Vec3& position, double distance) const;

  const SurfaceMesh& mesh() const;
  const Vec3& triangleNormal(std::uint32_t triangle) const;  // unit; zero for a triangle without area

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::transport
