#include "tools/simplify/orientation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>

namespace bakelight::simplify {
namespace {

// Where each new coordinate comes from, and its sign; every entry is a rotation (determinant +1).
struct QuarterTurn {
  std::array<std::size_t, 3> source;
  std::array<float, 3> sign;
};

constexpr std::array<QuarterTurn, 6> kTurns = {{
    {{0, 1, 2}, {1, 1, 1}},    // y
    {{0, 1, 2}, {1, -1, -1}},  // -y: half a turn about x
    {{0, 2, 1}, {1, 1, -1}},   // z
    {{0, 2, 1}, {1, -1, 1}},   // -z
    {{1, 0, 2}, {-1, 1, 1}},   // x
    {{1, 0, 2}, {1, -1, 1}},   // -x
}};

}  // namespace

const std::vector<std::string>& upAxes() {
  static const std::vector<std::string> names = {"y", "-y", "z", "-z", "x", "-x"};
  return names;
}

void turnUpright(formats::TriangleMesh& mesh, const std::string& up_axis) {
  const auto found = std::find(upAxes().begin(), upAxes().end(), up_axis);
  if (found == upAxes().end()) throw std::invalid_argument("no such axis: " + up_axis);
  const QuarterTurn& turn = kTurns[static_cast<std::size_t>(found - upAxes().begin())];
  for (auto* vectors : {&mesh.positions, &mesh.normals})
    for (formats::Float3& v : *vectors) {
      const formats::Float3 old = v;
      for (std::size_t c = 0; c < 3; ++c) v[c] = turn.sign[c] * old[turn.source[c]];
    }
}

}  // namespace bakelight::simplify
