// Products of functions on the sphere in the SH basis.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transport/sh.h"

namespace bakelight::transport {

// The tensor Γ_ijk = ∫ y_i y_j y_k ds for i < rows², j < columns², k < (rows + columns − 1)², of which few
// entries differ from zero. Exact to rounding (Gauss–Legendre × trapezoid). Since y_i y_j = Σ_k Γ_ijk y_k
// holds pointwise, projecting V to order rows + columns − 1 loses nothing of the matrix M_ij = ∫ V y_i y_j =
// Σ_k Γ_ijk V_k.
class TripleProduct {
 public:
  struct Entry {
    std::uint16_t i, j, k;
    float value;
  };

  // Orders 1–10. Cost: about 30 ms at 5 × 5; build it once.
  TripleProduct(int row_order, int column_order);

  int rowOrder() const { return row_order_; }
  int columnOrder() const { return column_order_; }
  int visibilityOrder() const { return row_order_ + column_order_ - 1; }
  // Sorted by i, then j, then k.
  std::span<const Entry> entries() const { return entries_; }

  // matrix[i · columns² + j] = Σ_k Γ_ijk visibility[k]. Sums in double in a fixed order.
  void matrixOf(std::span<const float> visibility, std::span<float> matrix) const;
  // operator[i · K + k] = Σ_j Γ_ijk light[j], K = visibilityOrder()²: with it, transferred = operator ·
  // visibility for every vertex under the same light.
  void operatorOf(std::span<const float> light, std::span<float> result) const;

 private:
  int row_order_, column_order_;
  std::vector<Entry> entries_;
};

}  // namespace bakelight::transport
