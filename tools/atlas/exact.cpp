#include "tools/atlas/exact.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <tuple>

namespace bakelight::atlas {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

bool isBefore(const Vec2& a, const Vec2& b) {
  return std::tuple(a.x(), a.y()) < std::tuple(b.x(), b.y());
}

// p lies on the line through a and b: whether it lies strictly between them.
bool isStrictlyBetween(const Vec2& p, const Vec2& a, const Vec2& b) {
  return isBefore(a, b) ? isBefore(a, p) && isBefore(p, b) : isBefore(b, p) && isBefore(p, a);
}

}  // namespace

int orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  return static_cast<int>(CGAL::orientation(Kernel::Point_2(a.x(), a.y()), Kernel::Point_2(b.x(), b.y()),
                                            Kernel::Point_2(c.x(), c.y())));
}

bool segmentsCross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const int c_side = orientation(a, b, c), d_side = orientation(a, b, d);
  const int a_side = orientation(c, d, a), b_side = orientation(c, d, b);
  if (c_side * d_side < 0 && a_side * b_side < 0) return true;
  if ((c_side == 0 && isStrictlyBetween(c, a, b)) || (d_side == 0 && isStrictlyBetween(d, a, b)) ||
      (a_side == 0 && isStrictlyBetween(a, c, d)) || (b_side == 0 && isStrictlyBetween(b, c, d)))
    return true;
  // The same segment twice has no end strictly inside.
  return a != b && ((a == c && b == d) || (a == d && b == c));
}

}  // namespace bakelight::atlas
