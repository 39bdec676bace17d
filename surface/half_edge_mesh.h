// The half-edge structure (OpenMesh) for operations that flat arrays do not suit.
#pragma once

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "surface/working_mesh.h"

namespace bakelight::surface {

inline constexpr std::uint32_t kNoMaterial = ~std::uint32_t{0};

struct HalfEdgeTraits : OpenMesh::DefaultTraitsDouble {
  FaceTraits { std::uint32_t material = kNoMaterial; };
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
  HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge | OpenMesh::Attributes::Status);
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;
using Point = HalfEdgeMesh::Point;
using VertexHandle = HalfEdgeMesh::VertexHandle;
using EdgeHandle = HalfEdgeMesh::EdgeHandle;
using HalfedgeHandle = HalfEdgeMesh::HalfedgeHandle;
using FaceHandle = HalfEdgeMesh::FaceHandle;

inline Vec3 vec3(const Point& p) {
  return {p[0], p[1], p[2]};
}
inline Point point(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

// An edge between triangles of two materials.
bool isMaterialBorder(const HalfEdgeMesh& mesh, EdgeHandle edge);

// Throws std::logic_error if `mesh` is not an oriented manifold (repair() makes it one).
HalfEdgeMesh halfEdgeMesh(const WorkingMesh& mesh);
// Collects garbage first.
WorkingMesh workingMesh(HalfEdgeMesh& mesh);

}  // namespace bakelight::surface
