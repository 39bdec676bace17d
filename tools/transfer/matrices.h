// Transfer matrices for glossy surfaces (Sloan et al. 2002, section 5): from distant light in the object's
// frame to what arrives at a vertex, in its local frame.
//   M_ij = ∫ V(s) y_i(local s) y_j(s) ds + Σ of what the blocked directions receive from the surface they
//   meet.
#pragma once

#include <span>
#include <vector>

#include "tools/transfer/shadow_pass.h"
#include "transport/interreflection.h"
#include "transport/triple_product.h"

namespace bakelight::transfer {

class MatrixBaker {
 public:
  MatrixBaker(int row_order, int order);

  // From visibility to the matrix, in the object's frame on both sides; exact (transport/triple_product.h).
  // `matrix` is row_order² × order².
  void fromVisibility(std::span<const float> visibility, std::span<float> matrix) const;

  // Turns the rows into the local frame.
  void turnRows(const Eigen::Matrix3d& local_from_object, std::span<float> matrix) const;

 private:
  int row_order_, order_;
  transport::TripleProduct product_;
};

// What a point's blocked directions (ShadowPass::findHits) send back: matrix_ij += Σ_k weight y_i(s_k)
// B_j(k), B the exit radiance of the surface at the hit, interpolated from `exit`, whose columns begin with
// channels × order² of distant light; a row a side of the vertices, `row_of_side` tells which (or kDarkSide).
// Times `share`, of points that share a vertex. Object frame; `matrices` is channels × row_order² × order².
// Cost: hits × row_order² × channels × order² multiply-adds, beside the rays.
void addBouncedLight(const ShadowPass& pass, const SurfacePoint& point, const std::vector<bool>& blocked_rays,
                     const transport::TransferField& exit,
                     std::span<const formats::Triangle> sides_from_behind,
                     std::span<const std::uint32_t> row_of_side, int channels, int row_order, int order,
                     double share, ShadowPass::Workspace& work, std::span<float> matrices);

}  // namespace bakelight::transfer
