// Gauss–Legendre quadrature.
#pragma once

#include <vector>

namespace bakelight::transport {

struct QuadratureNode {
  double x, weight;
};

// `count` nodes on [−1, 1], from the largest down; exact for polynomials of degree 2 · count − 1. Newton's
// iteration on P_count, to rounding for a few hundred nodes.
std::vector<QuadratureNode> gaussLegendreRule(int count);

}  // namespace bakelight::transport
