#include "tools/simplify/decimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <OpenMesh/Core/Geometry/QuadricT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModRoundnessT.hh>

#include "tools/simplify/features.h"

namespace bakelight::simplify {
namespace {

using OpenMesh::Geometry::Quadricd;

// Collapsing an edge of length l costs as much as a deviation of this share of l does.
const double kLengthPull = 0.03;
// Weight of the planes that stand on borders and creases, against the surface's own.
constexpr double kFeatureWeight = 10;

const double KE = 1;
const double kMinRoundness = 0.3;
constexpr double kMaxTurn_deg = 60;

// OpenMesh's own ModQuadricT knows neither borders nor edge lengths.
template <class MeshT>
class QuadricModule : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(QuadricModule, MeshT, BakelightQuadric);

  explicit QuadricModule(MeshT& mesh) : Base(mesh, false) {
    Base::mesh().add_property(quadrics_);
    Base::mesh().add_property(weights_);
  }
  ~QuadricModule() override { Base::mesh().remove_property(quadrics_); }

  void initialize() override {
    MeshT& mesh = Base::mesh();
    for (const auto vertex : mesh.vertices())
      mesh.property(quadrics_, vertex).clear(), mesh.property(weights_, vertex) = 0;
    for (const auto face : mesh.faces()) addFacePlane(face);
    for (const auto edge : mesh.edges()) {
      if (mesh.status(edge).feature()) addFeaturePlanes(edge);
    }
  }

  float collapse_priority(const CollapseInfo& collapse) override {
    Quadricd sum = Base::mesh().property(quadrics_, collapse.v0);
    sum += Base::mesh().property(quadrics_, collapse.v1);
    const double length2 = (collapse.p1 - collapse.p0).sqrnorm();
    const double weight =
        Base::mesh().property(weights_, collapse.v0) + Base::mesh().property(weights_, collapse.v1);
    const double pull = kLengthPull * kLengthPull * length2;
    return static_cast<float>(std::max(sum(collapse.p1) / std::pow(weight, KE), 0.0) +
                              pull * std::pow(length2, 1 - KE));
  }

  void postprocess_collapse(const CollapseInfo& collapse) override {
    Base::mesh().property(quadrics_, collapse.v1) += Base::mesh().property(quadrics_, collapse.v0);
    Base::mesh().property(weights_, collapse.v1) += Base::mesh().property(weights_, collapse.v0);
  }

 private:
  void addFacePlane(FaceHandle face) {
    MeshT& mesh = Base::mesh();
    Quadricd quadric;
    const HalfedgeHandle h = mesh.halfedge_handle(face);
    quadric.set_distance_to_plane(mesh.normal(face), mesh.point(mesh.to_vertex_handle(h)));
    quadric *= mesh.calc_sector_area(h);
    for (const auto vertex : mesh.fv_range(face))
      mesh.property(quadrics_, vertex) += quadric,
          mesh.property(weights_, vertex) += mesh.calc_sector_area(h);
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
      mesh.property(quadrics_, mesh.from_vertex_handle(h)) += quadric;
      mesh.property(quadrics_, mesh.to_vertex_handle(h)) += quadric;
    }
  }

  OpenMesh::VPropHandleT<Quadricd> quadrics_;
  OpenMesh::VPropHandleT<double> weights_;
};

std::size_t collapseTo(HalfEdgeMesh& mesh, std::size_t target, DecimationLevel level) {
  using Decimater = OpenMesh::Decimater::DecimaterT<HalfEdgeMesh>;
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModHandleT<QuadricModule<HalfEdgeMesh>> quadric;
  OpenMesh::Decimater::ModNormalFlippingT<HalfEdgeMesh>::Handle flipping;
  OpenMesh::Decimater::ModRoundnessT<HalfEdgeMesh>::Handle roundness;
  decimater.add(quadric);
  if (level != DecimationLevel::kUnconstrained) {
    decimater.add(flipping);
    decimater.module(flipping).set_max_normal_deviation(kMaxTurn_deg);
  }
  if (level == DecimationLevel::kFull) {
    decimater.add(roundness);
    decimater.module(roundness).set_min_roundness(kMinRoundness, true);
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
    case DecimationLevel::kAnyShape:
      return "any_shape";
    case DecimationLevel::kWithoutCreases:
      return "without_creases";
    case DecimationLevel::kUnconstrained:
      break;
  }
  return "unconstrained";
}

DecimationResult decimate(HalfEdgeMesh& mesh, std::size_t target) {
  DecimationResult result;
  constexpr std::array kLevels = {DecimationLevel::kFull, DecimationLevel::kAnyShape,
                                  DecimationLevel::kWithoutCreases, DecimationLevel::kUnconstrained};
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
