#include "tools/atlas/free_boundary.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/atlas/stretch.h"

namespace bakelight::atlas {
namespace {

using Matrix2 = Eigen::Matrix2d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using SparseMatrix = Eigen::SparseMatrix<double>;
using Solver = Eigen::SimplicialLDLT<SparseMatrix>;

// Triangles steeper than this to the mean normal (cosine) make the projection a bad start.
constexpr double kLeastCosine = 0.1;
// Share of the step at which the first triangle would collapse.
constexpr double kStepMargin = 0.8;
constexpr double kArmijo = 1e-4;
constexpr int kHalvings = 30;
// Relative to the Hessian's mean diagonal: the energy does not see motions of the whole chart.
constexpr double kRegularisation = 1e-8;

struct RestTriangle {
  double area;
  std::array<Vec2, 3> gradients;  // of the hat functions, in the triangle's own plane
};

std::vector<RestTriangle> restTriangles(const Chart& chart) {
  std::vector<RestTriangle> rest;
  rest.reserve(chart.triangles.size());
  for (const Triangle& t : chart.triangles) {
    const Vec3 ab = chart.positions[t[1]] - chart.positions[t[0]],
               ac = chart.positions[t[2]] - chart.positions[t[0]];
    const double bx = ab.norm(), cx = ab.dot(ac) / bx, cy = ab.cross(ac).norm() / bx;
    const Vec2 of_b(1 / bx, -cx / (bx * cy)), of_c(0, 1 / cy);
    rest.push_back({bx * cy / 2, {-of_b - of_c, of_b, of_c}});
  }
  return rest;
}

Matrix2 jacobian(const RestTriangle& rest, const Triangle& t, const std::vector<Vec2>& plane) {
  return plane[t[0]] * rest.gradients[0].transpose() + plane[t[1]] * rest.gradients[1].transpose() +
         plane[t[2]] * rest.gradients[2].transpose();
}

// J = U · diag(a, b) · Vᵀ with rotations U and V; b < 0 if J mirrors.
struct SignedSvd {
  Matrix2 u, v;
  double a, b;
};

SignedSvd signedSvd(const Matrix2& j) {
  const double e = (j(0, 0) + j(1, 1)) / 2, f = (j(0, 0) - j(1, 1)) / 2, g = (j(1, 0) + j(0, 1)) / 2,
               h = (j(1, 0) - j(0, 1)) / 2;
  const double similar = std::hypot(e, h), mirrored = std::hypot(f, g);
  const double sum = std::atan2(h, e), difference = std::atan2(g, f);
  const double u_angle = (sum + difference) / 2, v_angle = (difference - sum) / 2;
  return {Eigen::Rotation2Dd(u_angle).toRotationMatrix(), Eigen::Rotation2Dd(v_angle).toRotationMatrix(),
          similar + mirrored, similar - mirrored};
}

class SymmetricDirichlet {
 public:
  // Teeth of the border are those of `plane`.
  SymmetricDirichlet(const Chart& chart, const std::vector<Vec2>& plane, double straightness)
      : triangles_(chart.triangles), rest_(restTriangles(chart)) {
    for (const RestTriangle& rest : rest_) isometric_ += 4 * rest.area;
    if (straightness > 0) findBends(chart, plane, straightness);
    findPattern(chart.vertexCount());
  }

  // Above that of an isometry with straight borders; infinite if a triangle is flipped.
  double energy(const std::vector<Vec2>& plane) const {
    double sum = 0;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const Matrix2 j = jacobian(rest_[i], triangles_[i], plane);
      const double determinant = j.determinant();
      if (!(determinant > 0)) return std::numeric_limits<double>::infinity();
      sum += rest_[i].area * (j.squaredNorm() * (1 + 1 / (determinant * determinant)) - 4);
    }
    for (const Bend& bend : bends_) sum += bend.weight * bendOf(bend, plane).squaredNorm();
    return sum;
  }

  // The descent direction and its slope.
  double step(const std::vector<Vec2>& plane, Eigen::VectorXd& direction) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(hessian_.rows());
    std::fill_n(hessian_.valuePtr(), hessian_.nonZeros(), 0.0);
    for (std::size_t i = 0; i < rest_.size(); ++i) addTriangle(i, plane, gradient);
    for (const Bend& bend : bends_) addBend(bend, plane, gradient);
    const double shift = kRegularisation * hessian_.diagonal().mean();
    for (Eigen::Index k = 0; k < hessian_.rows(); ++k) hessian_.coeffRef(k, k) += shift;
    if (!analysed_) solver_.analyzePattern(hessian_), analysed_ = true;
    solver_.factorize(hessian_);
    direction = solver_.info() == Eigen::Success ? Eigen::VectorXd(-solver_.solve(gradient))
                                                 : Eigen::VectorXd(-gradient);
    return direction.dot(gradient);
  }

  // How far one can go before the first triangle collapses.
  double largestStep(const std::vector<Vec2>& plane, const Eigen::VectorXd& direction) const {
    double largest = std::numeric_limits<double>::infinity();
    const auto moves = [&](std::uint32_t v) { return Vec2(direction[2 * v], direction[2 * v + 1]); };
    for (const Triangle& t : triangles_) {
      const Vec2 ab = plane[t[1]] - plane[t[0]], ac = plane[t[2]] - plane[t[0]];
      const Vec2 ab_move = moves(t[1]) - moves(t[0]), ac_move = moves(t[2]) - moves(t[0]);
      const auto cross = [](const Vec2& p, const Vec2& q) { return p.x() * q.y() - p.y() * q.x(); };
      largest =
          std::min(largest, smallestPositiveRoot(cross(ab_move, ac_move),
                                                 cross(ab_move, ac) + cross(ab, ac_move), cross(ab, ac)));
    }
    return largest;
  }

  double isometricEnergy() const { return isometric_; }

 private:
  static double smallestPositiveRoot(double a, double b, double c) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double discriminant = b * b - 4 * a * c;
    if (discriminant < 0) return kNone;
    const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
    double root = kNone;
    for (const double x : {a != 0 ? q / a : kNone, q != 0 ? c / q : kNone})
      if (x > 0) root = std::min(root, x);
    return root;
  }

  // Three vertices in a row along a border, where that has teeth.
  struct Bend {
    std::array<std::uint32_t, 3> vertices;
    double weight;
  };
  static constexpr std::array<double, 3> kBendWeights = {-0.5, 1, -0.5};

  void findBends(const Chart& chart, const std::vector<Vec2>& plane, double straightness) {
    for (const auto& loop : chart.borders) {
      const std::vector<double> turns = turnsAlong(loop, plane);
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const double share = teethAround(i, turns);
        if (share > 0)
          bends_.push_back({{loop[(i + loop.size() - 1) % loop.size()], loop[i], loop[(i + 1) % loop.size()]},
                            straightness * share});
      }
    }
  }

  // The angle by which the border turns at each vertex, in radians, positive to the left.
  static std::vector<double> turnsAlong(const std::vector<std::uint32_t>& loop,
                                        const std::vector<Vec2>& plane) {
    std::vector<double> turns(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec2& here = plane[loop[i]];
      const Vec2 in = here - plane[loop[(i + loop.size() - 1) % loop.size()]],
                 out = plane[loop[(i + 1) % loop.size()]] - here;
      turns[i] = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    }
    return turns;
  }

  // How much of the turning around a vertex goes to and fro: 0 along straight lines, arcs and at corners
  // between them, near 1 amid teeth.
  static double teethAround(std::size_t i, const std::vector<double>& turns) {
    constexpr std::size_t kReach = 3;
    constexpr double kLeastTurning = 0.1;  // radians, in all; less is no teeth
    if (turns.size() < 2 * kReach + 2) return 0;
    double net = 0, all = 0;
    for (std::size_t k = 0; k <= 2 * kReach; ++k) {
      const double turn = turns[(i + turns.size() - kReach + k) % turns.size()];
      net += turn, all += std::abs(turn);
    }
    return all > kLeastTurning ? 1 - std::abs(net) / all : 0;
  }

  static Vec2 bendOf(const Bend& bend, const std::vector<Vec2>& plane) {
    const auto& [before, here, after] = bend.vertices;
    return plane[here] - (plane[before] + plane[after]) / 2;
  }

  void addBend(const Bend& bend, const std::vector<Vec2>& plane, Eigen::VectorXd& gradient) {
    const Vec2 amount = bendOf(bend, plane);
    for (std::size_t p = 0; p < 3; ++p)
      for (int axis = 0; axis < 2; ++axis) {
        const auto row = static_cast<Eigen::Index>(2 * bend.vertices[p]) + axis;
        gradient[row] += 2 * bend.weight * kBendWeights[p] * amount[axis];
        for (std::size_t q = 0; q < 3; ++q)
          hessian_.coeffRef(row, static_cast<Eigen::Index>(2 * bend.vertices[q]) + axis) +=
              2 * bend.weight * kBendWeights[p] * kBendWeights[q];
      }
  }

  void findPattern(std::size_t vertices) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(36 * triangles_.size());
    const auto addBlocks = [&](const std::array<std::uint32_t, 3>& corners) {
      for (const std::uint32_t p : corners)
        for (const std::uint32_t q : corners)
          for (int k = 0; k < 4; ++k)
            entries.emplace_back(static_cast<int>(2 * p) + k / 2, static_cast<int>(2 * q) + k % 2, 0.0);
    };
    for (const Triangle& t : triangles_) addBlocks(t);
    for (const Bend& bend : bends_) addBlocks(bend.vertices);
    const auto unknowns = static_cast<Eigen::Index>(2 * vertices);
    hessian_.resize(unknowns, unknowns);
    hessian_.setFromTriplets(entries.begin(), entries.end());
    hessian_.makeCompressed();
    // Where the two entries of each block of two unknowns begin, so that sums need no search. Rows are
    // sorted.
    slots_.reserve(triangles_.size());
    for (const Triangle& t : triangles_) {
      std::array<int, 18> slots{};
      for (std::size_t q = 0; q < 3; ++q)
        for (std::size_t column = 0; column < 2; ++column)
          for (std::size_t p = 0; p < 3; ++p) {
            const auto outer = static_cast<Eigen::Index>(2 * t[q] + column);
            const int* begin = hessian_.innerIndexPtr() + hessian_.outerIndexPtr()[outer];
            const int* end = hessian_.innerIndexPtr() + hessian_.outerIndexPtr()[outer + 1];
            slots[6 * q + 3 * column + p] = static_cast<int>(
                std::lower_bound(begin, end, static_cast<int>(2 * t[p])) - hessian_.innerIndexPtr());
          }
      slots_.push_back(slots);
    }
  }

  void addTriangle(std::size_t i, const std::vector<Vec2>& plane, Eigen::VectorXd& gradient) {
    const RestTriangle& rest = rest_[i];
    const Triangle& t = triangles_[i];
    const SignedSvd svd = signedSvd(jacobian(rest, t, plane));
    const double a = svd.a, b = svd.b, ab = a * b;
    const double slope_a = 2 * (a - 1 / (a * a * a)), slope_b = 2 * (b - 1 / (b * b * b));
    // Eigenvectors of the energy's Hessian in J: the two stretches, the rotation, the mirrored shear.
    const Vec2 u0 = svd.u.col(0), u1 = svd.u.col(1), v0 = svd.v.col(0), v1 = svd.v.col(1);
    const std::array<double, 4> curvatures = {2 + 6 / (a * a * a * a), 2 + 6 / (b * b * b * b),
                                              std::max(0.0, (slope_a + slope_b) / (a + b)),
                                              2 + 2 * (a * a + ab + b * b) / (ab * ab * ab)};
    const std::array<Matrix2, 4> modes = {u0 * v0.transpose(), u1 * v1.transpose(),
                                          (u1 * v0.transpose() - u0 * v1.transpose()) * M_SQRT1_2,
                                          (u1 * v0.transpose() + u0 * v1.transpose()) * M_SQRT1_2};
    const Matrix2 force = modes[0] * slope_a + modes[1] * slope_b;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 pull = rest.area * (force * rest.gradients[k]);
      gradient[2 * t[k]] += pull.x();
      gradient[2 * t[k] + 1] += pull.y();
    }
    Matrix6 block = Matrix6::Zero();
    for (std::size_t m = 0; m < 4; ++m) {
      Vector6 moved;
      for (int k = 0; k < 3; ++k) moved.segment<2>(2 * k) = modes[m] * rest.gradients[k];
      block.noalias() += (rest.area * curvatures[m]) * moved * moved.transpose();
    }
    double* values = hessian_.valuePtr();
    for (std::size_t q = 0; q < 3; ++q)
      for (std::size_t column = 0; column < 2; ++column)
        for (std::size_t p = 0; p < 3; ++p) {
          double* slot = values + slots_[i][6 * q + 3 * column + p];
          slot[0] += block(static_cast<int>(2 * p), static_cast<int>(2 * q + column));
          slot[1] += block(static_cast<int>(2 * p + 1), static_cast<int>(2 * q + column));
        }
  }

  const std::vector<Triangle>& triangles_;
  std::vector<RestTriangle> rest_;
  double isometric_ = 0;
  std::vector<Bend> bends_;
  SparseMatrix hessian_;
  std::vector<std::array<int, 18>> slots_;
  Solver solver_;
  bool analysed_ = false;
};

std::vector<Vec2> moved(const std::vector<Vec2>& plane, const Eigen::VectorXd& direction, double length) {
  std::vector<Vec2> result(plane.size());
  for (std::size_t v = 0; v < plane.size(); ++v)
    result[v] = plane[v] + length * Vec2(direction[static_cast<Eigen::Index>(2 * v)],
                                         direction[static_cast<Eigen::Index>(2 * v + 1)]);
  return result;
}

bool flips(const Chart& chart, const std::vector<Vec2>& plane) {
  return std::any_of(chart.triangles.begin(), chart.triangles.end(), [&](const Triangle& t) {
    return !(crossOf(plane[t[0]], plane[t[1]], plane[t[2]]) > 0);
  });
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

// Least squares conformal maps: the Dirichlet energy less the area, with two vertices held.
std::vector<Vec2> conformal(const Chart& chart) {
  const std::array<std::uint32_t, 2> held_vertices = pins(chart);
  const std::uint32_t pin_a = held_vertices[0], pin_b = held_vertices[1];
  std::vector<int> unknown(chart.vertexCount());
  int count = 0;
  for (std::uint32_t v = 0; v < unknown.size(); ++v) unknown[v] = v == pin_a || v == pin_b ? -1 : count++;
  const double length = (chart.positions[pin_b] - chart.positions[pin_a]).norm();
  const auto held = [&](std::uint32_t v) { return v == pin_b ? Vec2(length, 0) : Vec2(Vec2::Zero()); };

  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * count);
  const std::vector<RestTriangle> rest = restTriangles(chart);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Triangle& t = chart.triangles[i];
    // The residual of the Cauchy–Riemann equations: J₀₀ − J₁₁ and J₀₁ + J₁₀.
    for (int equation = 0; equation < 2; ++equation) {
      std::array<Vec2, 3> weights;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec2& g = rest[i].gradients[k];
        weights[k] = std::sqrt(rest[i].area) * (equation == 0 ? Vec2(g.x(), -g.y()) : Vec2(g.y(), g.x()));
      }
      double constant = 0;
      for (std::size_t k = 0; k < 3; ++k)
        if (unknown[t[k]] < 0) constant += weights[k].dot(held(t[k]));
      for (std::size_t p = 0; p < 3; ++p) {
        if (unknown[t[p]] < 0) continue;
        for (int a = 0; a < 2; ++a) {
          const int row = 2 * unknown[t[p]] + a;
          right[row] -= weights[p][a] * constant;
          for (std::size_t q = 0; q < 3; ++q)
            if (unknown[t[q]] >= 0)
              for (int b = 0; b < 2; ++b)
                entries.emplace_back(row, 2 * unknown[t[q]] + b, weights[p][a] * weights[q][b]);
        }
      }
    }
  }
  SparseMatrix normal(2 * count, 2 * count);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Solver solver(normal);
  const Eigen::VectorXd solution = solver.solve(right);
  std::vector<Vec2> plane(chart.vertexCount());
  for (std::uint32_t v = 0; v < plane.size(); ++v)
    plane[v] = unknown[v] < 0 ? held(v) : Vec2(solution[2 * unknown[v]], solution[2 * unknown[v] + 1]);
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
  if (auto plane = projection(chart); plane && !flips(chart, *plane)) return plane;
  std::vector<Vec2> plane = conformal(chart);
  if (flips(chart, plane)) return std::nullopt;
  return plane;
}

std::vector<Vec2> minimiseDistortion(const Chart& chart, std::vector<Vec2> plane,
                                     const FreeBoundaryOptions& options) {
  scaleForLeastStretch(chart, plane);
  SymmetricDirichlet objective(chart, plane, options.straightness);
  double energy = objective.energy(plane);
  Eigen::VectorXd direction;
  for (int i = 0; i < options.iterations && energy > 1e-12 * objective.isometricEnergy(); ++i) {
    const double slope = objective.step(plane, direction);
    if (!(slope < 0) || !direction.allFinite()) break;
    double length = std::min(1.0, kStepMargin * objective.largestStep(plane, direction));
    std::vector<Vec2> next;
    double next_energy = energy;
    for (int halving = 0; halving < kHalvings; ++halving, length /= 2) {
      next = moved(plane, direction, length);
      next_energy = objective.energy(next);
      if (next_energy <= energy + kArmijo * length * slope) break;
    }
    if (!(next_energy < energy)) break;
    const bool done = energy - next_energy < options.least_progress * energy;
    plane = std::move(next);
    energy = next_energy;
    if (done) break;
  }
  return plane;
}

}  // namespace bakelight::atlas
