#include "tools/simplify/orientation.h"

#include <array>
#include <cstddef>

namespace bakelight::simplify {
namespace {

// Where each new coordinate comes from, and its sign; every entry is a rotation (determinant +1).
struct QuarterTurn {
  std::array<std::size_t, 3> source;
  std::array<float, 3> sign;
};

QuarterTurn turnFor(UpAxis up_axis) {
  switch (up_axis) {
    case UpAxis::kY:
      break;
    case UpAxis::kMinusY:
      return {{0, 1, 2}, {1, -1, -1}};  // half a turn about x
    case UpAxis::kZ:
      return {{0, 2, 1}, {1, 1, -1}};
    case UpAxis::kMinusZ:
      return {{0, 2, 1}, {1, -1, 1}};
    case UpAxis::kX:
      return {{1, 0, 2}, {-1, 1, 1}};
    case UpAxis::kMinusX:
      return {{1, 0, 2}, {1, -1, 1}};
  }
  return {{0, 1, 2}, {1, 1, 1}};
}

}  // namespace

void turnUpright(formats::TriangleMesh& mesh, UpAxis up_axis) {
  const QuarterTurn turn = turnFor(up_axis);
  for (auto* vectors : {&mesh.positions, &mesh.normals})
    for (formats::Float3& v : *vectors) {
      const formats::Float3 old = v;
      for (std::size_t c = 0; c < 3; ++c) v[c] = turn.sign[c] * old[turn.source[c]];
    }
}

}  // namespace bakelight::simplify
