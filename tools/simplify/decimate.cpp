#include "tools/simplify/decimate.h"

#include <algorithm>
#include <array>
#include <OpenMesh/Core/Geometry/QuadricT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>

#include "tools/simplify/features.h"

namespace bakelight::simplify {
namespace {

using OpenMesh::Geometry::Quadricd;

// Collapsing an edge of length l costs as much as a deviation of this share of l does.
constexpr double kLengthPull = 0.04;
// Weight of the planes that stand on borders and creases, against the surface's own.
constexpr double kFeatureWeight = 10;
constexpr double kMaxTurn_deg = 60;

// OpenMesh's own ModQuadricT knows neither borders nor edge lengths.
template <class MeshT>
class QuadricModule : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(QuadricModule, MeshT, BakelightQuadric);

  explicit QuadricModule(MeshT& mesh) : Base(mesh, false) { Base::mesh().add_property(errors_); }
  ~QuadricModule() override { Base::mesh().remove_property(errors_); }

  void initialize() override {
    MeshT& mesh = Base::mesh();
    for (const auto vertex : mesh.vertices()) mesh.property(errors_, vertex) = {};
    for (const auto face : mesh.faces()) addFacePlane(face);
    for (const auto edge : mesh.edges()) {
      if (mesh.status(edge).feature()) addFeaturePlanes(edge);
    }
  }

  float collapse_priority(const CollapseInfo& collapse) override {
    Error sum = Base::mesh().property(errors_, collapse.v0);
    sum += Base::mesh().property(errors_, collapse.v1);
    const double mean2 = sum.area > 0 ? std::max(sum.quadric(collapse.p1), 0.0) / sum.area : 0.0;
    return static_cast<float>(mean2 + kLengthPull * kLengthPull * (collapse.p1 - collapse.p0).sqrnorm());
  }

  // The edges of v0 vanish into those of v1, which become the border where it ran along v0's.
  void preprocess_collapse(const CollapseInfo& collapse) override {
    MeshT& mesh = Base::mesh();
    const auto inherit = [&](HalfedgeHandle vanishing, HalfedgeHandle staying) {
      if (vanishing.is_valid() && isMaterialBorder(mesh, mesh.edge_handle(vanishing)))
        mesh.status(mesh.edge_handle(staying)).set_feature(true);
    };
    inherit(collapse.v0vl, collapse.vlv1);
    inherit(collapse.vrv0, collapse.v1vr);
  }

  void postprocess_collapse(const CollapseInfo& collapse) override {
    Base::mesh().property(errors_, collapse.v1) += Base::mesh().property(errors_, collapse.v0);
  }

 private:
  // Area-weighted squared distances from planes, and the area they stand for: their ratio is a mean squared
  // distance.
  struct Error {
    Quadricd quadric;
    double area = 0;
    Error& operator+=(const Error& other) {
      quadric += other.quadric;
      area += other.area;
      return *this;
    }
  };

  void addFacePlane(FaceHandle face) {
    MeshT& mesh = Base::mesh();
    const HalfedgeHandle h = mesh.halfedge_handle(face);
    Error error;
    error.area = mesh.calc_sector_area(h);
    error.quadric.set_distance_to_plane(mesh.normal(face), mesh.point(mesh.to_vertex_handle(h)));
    error.quadric *= error.area;
    for (const auto vertex : mesh.fv_range(face)) mesh.property(errors_, vertex) += error;
  }

  // Planes through the edge, perpendicular to its faces.
  void addFeaturePlanes(EdgeHandle edge) {
    MeshT& mesh = Base::mesh();
    for (const unsigned side : {0u, 1u}) {
      const HalfedgeHandle h = mesh.halfedge_handle(edge, side);
      if (mesh.is_boundary(h)) continue;
      const Point along = mesh.calc_edge_vector(h);
      Quadricd quadric;
      quadric.set_distance_to_plane((along % mesh.normal(mesh.face_handle(h))).normalize_cond(),
                                    mesh.point(mesh.to_vertex_handle(h)));
      quadric *= kFeatureWeight * along.sqrnorm();
      mesh.property(errors_, mesh.from_vertex_handle(h)).quadric += quadric;
      mesh.property(errors_, mesh.to_vertex_handle(h)).quadric += quadric;
    }
  }

  OpenMesh::VPropHandleT<Error> errors_;
};

std::size_t collapseTo(HalfEdgeMesh& mesh, std::size_t target, DecimationLevel level) {
  using Decimater = OpenMesh::Decimater::DecimaterT<HalfEdgeMesh>;
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModHandleT<QuadricModule<HalfEdgeMesh>> quadric;
  OpenMesh::Decimater::ModNormalFlippingT<HalfEdgeMesh>::Handle flipping;
  decimater.add(quadric);
  if (level != DecimationLevel::kUnconstrained) {
    decimater.add(flipping);
    decimater.module(flipping).set_max_normal_deviation(kMaxTurn_deg);
  }
  decimater.initialize();
  const std::size_t collapses = decimater.decimate_to_faces(0, target);
  mesh.garbage_collection();
  return collapses;
}

}  // namespace

const char* name(DecimationLevel level) {
  switch (level) {
    case DecimationLevel::kFull:
      return "full";
    case DecimationLevel::kWithoutCreases:
      return "without_creases";
    case DecimationLevel::kUnconstrained:
      break;
  }
  return "unconstrained";
}

DecimationResult decimate(HalfEdgeMesh& mesh, std::size_t target) {
  DecimationResult result;
  constexpr std::array kLevels = {DecimationLevel::kFull, DecimationLevel::kWithoutCreases,
                                  DecimationLevel::kUnconstrained};
  for (const DecimationLevel level : kLevels) {
    if (mesh.n_faces() <= target) break;
    result.level = level;
    if (level == DecimationLevel::kWithoutCreases) releaseCreases(mesh);
    result.collapses += collapseTo(mesh, target, level);
  }
  result.reached = mesh.n_faces() <= target;
  return result;
}

}  // namespace bakelight::simplify
