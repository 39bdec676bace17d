#include "tools/mesomesh/field/direction_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "formats/error.h"
#include "tools/mesomesh/field/cluster_graph.h"
#include "tools/mesomesh/field/smoothest_field.h"
#include "tools/stage/stopwatch.h"

namespace bakelight::mesomesh {
namespace {

using transport::vec3;

// Nodes of the graph that is solved for the smoothest field of all.
constexpr std::size_t kSolvedNodes = 4000;
constexpr int kSweeps = 10;
// A hint whose direction is nearer to the normal than this (a sine) says nothing.
constexpr double kLeastSine = 0.02;
// A hint farther from the surface than this share of its diagonal is told.
constexpr double kFarHint = 0.02;
constexpr double kCalmCosine = 0.7072;

Complex power(Complex z, int symmetry) {
  for (int n = 1; n < symmetry; n *= 2) z *= z;
  return z;
}

// `direction` in the tangent plane of a node; nothing if it is along the normal.
std::optional<Complex> inPlane(const ClusterLevel& level, std::size_t node, const Vec3& direction) {
  const Vec3 &n = level.normals[node], &axis = level.axes[node];
  const Complex z(direction.dot(axis), direction.dot(n.cross(axis)));
  if (std::abs(z) < kLeastSine) return std::nullopt;
  return z / std::abs(z);
}

struct PlacedHint {
  std::uint32_t vertex = 0;
  double distance = 0;
  Vec3 direction = Vec3::Zero();
};

// The nearest vertex; of copies at one place the one whose tangent plane the direction is nearest to.
PlacedHint placed(const DirectionHint& hint, const formats::TriangleMesh& mesh) {
  struct Best {
    double distance2 = std::numeric_limits<double>::infinity(), lift = 0;
    std::uint32_t vertex = 0;
    bool operator<(const Best& o) const {
      return std::tie(distance2, lift, vertex) < std::tie(o.distance2, o.lift, o.vertex);
    }
  };
  const Vec3 point = vec3(hint.point), direction = vec3(hint.direction).normalized();
  const Best best = tbb::parallel_reduce(
      tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(mesh.vertexCount())), Best{},
      [&](const auto& range, Best found) {
        for (std::uint32_t v = range.begin(); v < range.end(); ++v)
          found = std::min(found, Best{(vec3(mesh.positions[v]) - point).squaredNorm(),
                                       std::abs(direction.dot(vec3(mesh.normals[v]))), v});
        return found;
      },
      [](const Best& a, const Best& b) { return std::min(a, b); });
  return {best.vertex, std::sqrt(best.distance2), direction};
}

double diagonalOf(const formats::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const formats::Float3& p : mesh.positions) box.extend(vec3(p));
  return box.diagonal().norm();
}

// What the hints hold in each level.
std::vector<Held> heldNodes(const std::vector<PlacedHint>& hints, const std::vector<ClusterLevel>& levels,
                            int symmetry) {
  std::vector<Held> held(levels.size());
  for (const PlacedHint& hint : hints) {
    std::uint32_t node = hint.vertex;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      // Several hints in one node: their mean.
      if (const auto z = inPlane(levels[l], node, hint.direction)) held[l][node] += power(*z, symmetry);
      if (!levels[l].cluster.empty()) node = levels[l].cluster[node];
    }
  }
  for (Held& level : held) {
    std::erase_if(level, [](const auto& entry) { return std::abs(entry.second) < 1e-9; });
    for (auto& [node, z] : level) z /= std::abs(z);
  }
  return held;
}

std::vector<Complex> solved(const std::vector<ClusterLevel>& levels, int symmetry,
                            const std::vector<Held>& held) {
  std::vector<Complex> field = smoothestField(levels.back(), symmetry, held.back());
  for (Complex& z : field) z = std::abs(z) > 1e-300 ? z / std::abs(z) : Complex(1);
  smoothField(levels.back(), symmetry, held.back(), kSweeps, field);
  for (std::size_t l = levels.size() - 1; l-- > 0;) {
    const ClusterLevel &fine = levels[l], &coarse = levels[l + 1];
    std::vector<Complex> finer(fine.size());
    tbb::parallel_for(std::size_t{0}, fine.size(), [&](std::size_t i) {
      const std::uint32_t c = fine.cluster[i];
      const Complex z = field[c] * carried(coarse, c, fine, i, symmetry);
      finer[i] = std::abs(z) > 0 ? z / std::abs(z) : Complex(1);
    });
    for (const auto& [node, z] : held[l]) finer[node] = z;
    field = std::move(finer);
    smoothField(fine, symmetry, held[l], kSweeps, field);
  }
  return field;
}

// Of one triangle, in units of 1/symmetry of a turn: how far the field turns along its sides, beyond what the
// surface's curvature explains.
int indexOf(const ClusterLevel& level, const std::vector<Complex>& field, const formats::Triangle& triangle,
            int symmetry) {
  std::array<Complex, 3> turns;
  Complex around = 1;
  bool is_calm = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
    const Complex carry = carried(level, a, level, b, 1);
    turns[k] = field[b] * std::conj(field[a] * power(carry, symmetry));
    around *= carry;
    is_calm = is_calm && turns[k].real() > kCalmCosine;
  }
  // Three turns of less than 45° and a curvature of less than 45°: no angle need be taken.
  if (is_calm && power(around, symmetry).real() > kCalmCosine && around.real() > kCalmCosine) return 0;
  double turn = 0;
  for (const Complex& z : turns) turn += std::arg(z);
  return static_cast<int>(std::lround((turn + symmetry * std::arg(around)) / (2 * std::numbers::pi)));
}

}  // namespace

DirectionField directionField(const formats::TriangleMesh& mesh, const FieldOptions& options,
                              std::span<const DirectionHint> hints, const std::string& hints_file) {
  const int symmetry = options.symmetry;
  if (symmetry != 1 && symmetry != 2 && symmetry != 4)
    throw std::invalid_argument("a field has a symmetry of 1, 2 or 4");
  DirectionField result;
  stage::Stopwatch watch(result.seconds);
  const std::vector<ClusterLevel> levels = clusterLevels(mesh, options.crease_angle_deg, kSolvedNodes);
  watch.lap("clusters");
  std::vector<PlacedHint> places;
  const double diagonal = hints.empty() ? 0 : diagonalOf(mesh);
  for (std::size_t i = 0; i < hints.size(); ++i) {
    places.push_back(placed(hints[i], mesh));
    if (!inPlane(levels.front(), places.back().vertex, places.back().direction))
      throw badInput({hints_file, "", "/" + std::to_string(i) + "/direction"},
                     "it is along the normal of the surface there", "a direction along the surface");
    if (places.back().distance > kFarHint * diagonal)
      result.warnings.push_back("hint " + std::to_string(i) + " is " +
                                std::to_string(places.back().distance / diagonal) +
                                " of the mesh's diagonal away from the surface");
  }
  const std::vector<Complex> field = solved(levels, symmetry, heldNodes(places, levels, symmetry));
  watch.lap("smooth");

  const ClusterLevel& vertices = levels.front();
  result.tangents.resize(mesh.vertexCount());
  tbb::parallel_for(std::size_t{0}, mesh.vertexCount(), [&](std::size_t v) {
    const Complex z = std::polar(1.0, std::arg(field[v]) / symmetry);
    const Vec3 &n = vertices.normals[v], &axis = vertices.axes[v];
    result.tangents[v] = transport::float3((z.real() * axis + z.imag() * n.cross(axis)).normalized());
  });
  std::vector<std::int8_t> indices(mesh.triangleCount());
  tbb::parallel_for(std::size_t{0}, mesh.triangleCount(), [&](std::size_t t) {
    indices[t] = static_cast<std::int8_t>(indexOf(vertices, field, mesh.triangles[t], symmetry));
  });
  for (std::uint32_t t = 0; t < indices.size(); ++t) {
    if (indices[t] == 0) continue;
    result.singularities.push_back({t, indices[t]});
    result.index_sum += indices[t];
  }
  watch.lap("singularities");
  return result;
}

}  // namespace bakelight::mesomesh
