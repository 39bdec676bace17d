#include "tools/atlas/flatten/free_boundary.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/flatten/distortion_energy.h"
#include "tools/atlas/flatten/untangling.h"

namespace bakelight::atlas {
namespace {

// Triangles steeper than this to the mean normal (cosine) make the projection a bad start.
constexpr double kLeastCosine = 0.1;
// Share of the step at which the first triangle would collapse.
constexpr double kStepMargin = 0.8;
constexpr double kArmijo = 1e-4;
constexpr int kHalvings = 30;
// A layout is given up when, after so many steps, its stretch exceeds the limit by so many times what the
// next step is likely to gain.
constexpr int kTrustedSteps = 2;
constexpr double kHopelessness = 2;

std::vector<Vec2> moved(const std::vector<Vec2>& plane, const Eigen::VectorXd& direction, double length) {
  std::vector<Vec2> result(plane.size());
  for (std::size_t v = 0; v < plane.size(); ++v)
    result[v] = plane[v] + length * Vec2(direction[static_cast<Eigen::Index>(2 * v)],
                                         direction[static_cast<Eigen::Index>(2 * v + 1)]);
  return result;
}

std::optional<std::vector<Vec2>> projection(const Chart& chart) {
  Vec3 mean = Vec3::Zero();
  const auto areaVector = [&](const Triangle& t) {
    return Vec3(
        (chart.positions[t[1]] - chart.positions[t[0]]).cross(chart.positions[t[2]] - chart.positions[t[0]]));
  };
  for (const Triangle& t : chart.triangles) mean += areaVector(t);
  if (!(mean.norm() > 0)) return std::nullopt;
  mean.normalize();
  for (const Triangle& t : chart.triangles) {
    const Vec3 vector = areaVector(t);
    if (!(vector.dot(mean) > kLeastCosine * vector.norm())) return std::nullopt;
  }
  return projectedAlong(chart, mean);
}

// The two border vertices that are farthest along the border from each other, roughly: far apart in space.
std::array<std::uint32_t, 2> pins(const Chart& chart) {
  const auto farthestFrom = [&](std::uint32_t from) {
    return *std::max_element(chart.borders[0].begin(), chart.borders[0].end(),
                             [&](std::uint32_t a, std::uint32_t b) {
                               return (chart.positions[a] - chart.positions[from]).squaredNorm() <
                                      (chart.positions[b] - chart.positions[from]).squaredNorm();
                             });
  };
  const std::uint32_t first = farthestFrom(chart.borders[0][0]);
  return {first, farthestFrom(first)};
}

// Least squares conformal maps: the Dirichlet energy less the area, with two vertices held. With the plane as
// complex numbers both are Hermitian forms, the area's of the borders only.
std::vector<Vec2> conformal(const Chart& chart) {
  using Complex = std::complex<double>;
  const std::array<std::uint32_t, 2> held_vertices = pins(chart);
  const std::uint32_t pin_a = held_vertices[0], pin_b = held_vertices[1];
  std::vector<int> unknown(chart.vertexCount());
  int count = 0;
  for (std::uint32_t v = 0; v < unknown.size(); ++v) unknown[v] = v == pin_a || v == pin_b ? -1 : count++;
  const double length = (chart.positions[pin_b] - chart.positions[pin_a]).norm();

  std::vector<Eigen::Triplet<Complex>> entries;
  entries.reserve(6 * chart.triangles.size());
  Eigen::VectorXcd right = Eigen::VectorXcd::Zero(count);
  // Of pin_a, which is held at 0, nothing remains on the right side.
  const auto add = [&](std::uint32_t p, std::uint32_t q, const Complex& value) {
    if (unknown[p] < 0) return;
    if (unknown[q] < 0)
      right[unknown[p]] -= q == pin_b ? value * length : 0;
    else if (unknown[p] >= unknown[q])
      entries.emplace_back(unknown[p], unknown[q], value);
  };
  const std::vector<RestTriangle> rest = restTriangles(chart);
  for (std::size_t i = 0; i < rest.size(); ++i)
    for (std::size_t p = 0; p < 3; ++p)
      for (std::size_t q = 0; q < 3; ++q)
        add(chart.triangles[i][p], chart.triangles[i][q],
            rest[i].area * rest[i].gradients[p].dot(rest[i].gradients[q]));
  for (const auto& loop : chart.borders)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::uint32_t from = loop[i], to = loop[(i + 1) % loop.size()];
      add(from, to, {0, 0.5});
      add(to, from, {0, -0.5});
    }
  Eigen::SparseMatrix<Complex> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> solver(matrix);
  const Eigen::VectorXcd solution = solver.solve(right);
  std::vector<Vec2> plane(chart.vertexCount(), Vec2::Zero());
  plane[pin_b] = {length, 0};
  for (std::uint32_t v = 0; v < plane.size(); ++v)
    if (unknown[v] >= 0) plane[v] = {solution[unknown[v]].real(), solution[unknown[v]].imag()};
  return plane;
}

}  // namespace

std::vector<Vec2> projectedAlong(const Chart& chart, const Vec3& normal) {
  const Vec3 x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<Vec2> plane;
  plane.reserve(chart.vertexCount());
  for (const Vec3& p : chart.positions) plane.emplace_back(x.dot(p), y.dot(p));
  return plane;
}

std::optional<std::vector<Vec2>> flatStart(const Chart& chart) {
  if (!chart.isPlanar()) return std::nullopt;
  if (auto plane = projection(chart); plane && !hasFlipped(chart, *plane)) return plane;
  std::vector<Vec2> plane = conformal(chart);
  if (!untangle(chart, plane)) return std::nullopt;
  return plane;
}

std::vector<Vec2> minimizeDistortion(const Chart& chart, std::vector<Vec2> plane,
                                     const FreeBoundaryOptions& options) {
  scaleForLeastStretch(chart, plane);
  SymmetricDirichlet objective(chart, plane, options.straightness);
  auto [energy, l2] = objective.measure(plane);
  Eigen::VectorXd direction;
  for (int i = 0; i < options.iterations && energy > 1e-12 * objective.isometricEnergy(); ++i) {
    if (l2 <= options.enough_l2) break;
    const double slope = objective.step(plane, direction);
    if (!(slope < 0) || !direction.allFinite()) break;
    // What a parabola would still lose, twice, and near an isometry half of the energy is stretch.
    if (i >= kTrustedSteps && l2 - kHopelessness * -slope / objective.isometricEnergy() > options.enough_l2 &&
        options.enough_l2 > 0)
      break;
    double length = std::min(1.0, kStepMargin * objective.largestStep(plane, direction));
    std::vector<Vec2> next;
    SymmetricDirichlet::Measured there{energy, l2};
    for (int halving = 0; halving < kHalvings; ++halving, length /= 2) {
      next = moved(plane, direction, length);
      there = objective.measure(next);
      if (there.energy <= energy + kArmijo * length * slope) break;
    }
    if (!(there.energy < energy)) break;
    const bool done = energy - there.energy < options.least_progress * energy;
    plane = std::move(next);
    energy = there.energy, l2 = there.l2;
    if (done) break;
  }
  return plane;
}

}  // namespace bakelight::atlas
