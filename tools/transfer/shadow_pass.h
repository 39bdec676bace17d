// The first pass: what reaches each point directly, past the object's own shadows, and what blocks the rest.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/transfer/near_field.h"
#include "tools/transfer/quadrature.h"
#include "tools/transfer/surface_points.h"
#include "transport/form_factors.h"
#include "transport/ray_scene.h"

namespace bakelight::transfer {

struct ShadowOptions {
  int order = 5;
  int visibility_order = 0;             // > 0: also visibility vectors of that order
  std::optional<VirtualSphere> sphere;  // also near-field vectors
  bool record_hits = false;             // also what the blocked rays hit, for interreflection
  double entered_ior = 0;               // TransferOptions::entered_ior
  bool keep_blocked = false;            // also which rays were blocked, for findHits
};

// What the pass finds out about a point.
struct PointFigures {
  std::uint32_t rays = 0, blocked = 0, inside_hits = 0;
  float quadrature_error = 0;
  bool buried = false;
};
// The lists are filled where the options ask for them.
struct TracedPoint : PointFigures {
  std::vector<transport::SeenVertex> seen;  // sorted by side; the weights add up to the blocked share
  std::vector<bool> blocked_rays;           // of the hemisphere's directions, in their order
};
struct PointTransfer {
  std::span<float> vector;  // as many bands as it has room for, at most the options' or kJudgedOrder
  std::span<float> near_vector, visibility;  // empty where they are not wanted
};

class ShadowPass {
 public:
  struct Workspace;

  ShadowPass(const formats::TriangleMesh& mesh, const transport::RayScene& scene,
             const ShadowOptions& options, int directions, std::uint32_t turn = 0);

  // The control variate is that of transfer.h; `sides_from_behind` (surface_points.h) tells whose back sides
  // count, where hits are recorded: those of closed components are inside and dark. Reentrant with a
  // workspace a thread.
  TracedPoint trace(const SurfacePoint& point, std::span<const formats::Triangle> sides_from_behind,
                    const PointTransfer& result, Workspace& work) const;

  // Takes up a point again: the directions that `blocked_rays` says are blocked into work.blocked_directions,
  // and what they hit into work.hits.
  void findHits(const SurfacePoint& point, const std::vector<bool>& blocked_rays, Workspace& work) const;

  const Quadrature& quadrature() const { return quadrature_; }
  const formats::TriangleMesh& mesh() const { return mesh_; }

 private:
  static void listBlocked(Workspace& work);
  static void listVisible(Workspace& work);
  void traceBlocked(const SurfacePoint& point, Workspace& work) const;
  void combine(const SurfacePoint& point, const PointTransfer& result, Workspace& work,
               PointFigures& figures) const;
  void combineVisibility(const SurfacePoint& point, std::span<float> visibility, Workspace& work) const;
  std::vector<transport::SeenVertex> collectSeen(std::span<const formats::Triangle> sides_from_behind,
                                                 Workspace& work, PointFigures& figures) const;

  const formats::TriangleMesh& mesh_;
  const transport::RayScene& scene_;
  ShadowOptions options_;
  Quadrature quadrature_;
  std::vector<double> cosine_factors_, hemisphere_zonal_;
};

// What one thread reuses from point to point. Memory: some 100 bytes a direction, whatever the mesh.
struct ShadowPass::Workspace {
  explicit Workspace(const ShadowPass& pass);

  Hemisphere hemisphere;
  std::vector<std::uint8_t> blocked;  // of the hemisphere's directions
  bool sees_light = false;            // not all of them are
  transport::RayBundle blocked_rays;  // the first blocked_directions.size() of them count
  transport::HitBundle hits;          // likewise
  // The hemisphere's directions parted in two. What is visible is listed only where it is summed up itself.
  std::vector<std::uint32_t> blocked_directions, visible_directions;
  std::vector<float> blocked_cosines, visible_cosines, ones;
  std::vector<double> all_sums, blocked_sums;
  transport::SeenSums seen;  // empty between points
};

// Two queries of the ray tracer may differ about a ray that grazes an edge: one says that it is blocked, the
// other finds no hit. Such a ray passes; at a point that sees no light it counts as not traced, as nothing
// must shine into a closed cavity. Takes them out of the lists of what is blocked, so that each entry has a
// hit.
void letGrazingRaysPass(ShadowPass::Workspace& work);

}  // namespace bakelight::transfer
