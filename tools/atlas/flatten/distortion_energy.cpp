#include "tools/atlas/flatten/distortion_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bakelight::atlas {
namespace {

using Matrix2 = Eigen::Matrix2d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::array<double, 3> kBendWeights = {-0.5, 1, -0.5};
// Relative to the Hessian's mean diagonal: the energy does not see motions of the whole chart.
constexpr double kRegularization = 1e-8;
// Conjugate gradients end when the residual has shrunk to this share, in the preconditioner's norm.
constexpr double kResidual = 0.05;
constexpr int kMostIterations = 200;
// More than so many tell that the preconditioner is no longer near.
constexpr int kManyIterations = 12;

Matrix2 jacobian(const RestTriangle& rest, const Triangle& t, const std::vector<Vec2>& plane) {
  return plane[t[0]] * rest.gradients[0].transpose() + plane[t[1]] * rest.gradients[1].transpose() +
         plane[t[2]] * rest.gradients[2].transpose();
}

// J = U · diag(a, b) · Vᵀ with rotations U and V by their first columns; b < 0 if J mirrors.
struct SignedSvd {
  Vec2 u, v;
  double a, b;
};

// J is a similarity (e, h) and a mirrored one (f, g); as complex numbers U = V · (e + ih) and V² = (f + ig) /
// (e + ih), of unit length.
SignedSvd signedSvd(const Matrix2& j) {
  const double e = (j(0, 0) + j(1, 1)) / 2, f = (j(0, 0) - j(1, 1)) / 2, g = (j(1, 0) + j(0, 1)) / 2,
               h = (j(1, 0) - j(0, 1)) / 2;
  const double similar = std::sqrt(e * e + h * h), mirrored = std::sqrt(f * f + g * g);
  const Vec2 p = similar > 0 ? Vec2(e / similar, h / similar) : Vec2(1, 0);
  const Vec2 q = mirrored > 0 ? Vec2(f / mirrored, g / mirrored) : p;
  const Vec2 v_squared(q.x() * p.x() + q.y() * p.y(), q.y() * p.x() - q.x() * p.y());
  // Half of the angle, without cancellation near a half turn.
  Vec2 v(0, 1);
  if (v_squared.x() >= 0) {
    const double c = std::sqrt((1 + v_squared.x()) / 2);
    v = {c, v_squared.y() / (2 * c)};
  } else {
    const double s = std::sqrt((1 - v_squared.x()) / 2);
    v = {v_squared.y() / (2 * s), s};
  }
  const Vec2 u(v.x() * p.x() - v.y() * p.y(), v.x() * p.y() + v.y() * p.x());
  return {u, v, similar + mirrored, similar - mirrored};
}

// The angle by which the border turns at each vertex, in radians, positive to the left.
std::vector<double> turnsAlong(const std::vector<std::uint32_t>& loop, const std::vector<Vec2>& plane) {
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
double teethAround(std::size_t i, const std::vector<double>& turns) {
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

double smallestPositiveRoot(double a, double b, double c) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double discriminant = b * b - 4 * a * c;
  if (discriminant < 0) return kNone;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
  double root = kNone;
  for (const double x : {a != 0 ? q / a : kNone, q != 0 ? c / q : kNone})
    if (x > 0) root = std::min(root, x);
  return root;
}

Vec2 bendOf(const std::array<std::uint32_t, 3>& vertices, const std::vector<Vec2>& plane) {
  const auto& [before, here, after] = vertices;
  return plane[here] - (plane[before] + plane[after]) / 2;
}

}  // namespace

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

SymmetricDirichlet::SymmetricDirichlet(const Chart& chart, const std::vector<Vec2>& plane,
                                       double straightness)
    : triangles_(chart.triangles), rest_(restTriangles(chart)), stiffness_(rest_.size()) {
  for (const RestTriangle& rest : rest_) isometric_ += 4 * rest.area;
  if (straightness > 0) findBends(chart, plane, straightness);
  findPattern(chart.vertexCount());
}

SymmetricDirichlet::Measured SymmetricDirichlet::measure(const std::vector<Vec2>& plane) const {
  double energy = 0, weighted = 0, plane_area = 0;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const Matrix2 j = jacobian(rest_[i], triangles_[i], plane);
    const double determinant = j.determinant(), squares = j.squaredNorm();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (!(determinant > 0)) return {kInfinity, kInfinity};
    const double inverse_squares = squares / (determinant * determinant);
    energy += rest_[i].area * (squares + inverse_squares - 4);
    weighted += rest_[i].area * inverse_squares / 2;
    plane_area += rest_[i].area * determinant;
  }
  for (const Bend& bend : bends_) energy += bend.weight * bendOf(bend.vertices, plane).squaredNorm();
  return {energy, std::sqrt(weighted * plane_area) / (isometric_ / 4)};
}

double SymmetricDirichlet::step(const std::vector<Vec2>& plane, Eigen::VectorXd& direction) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(hessian_.rows());
  std::fill_n(hessian_.valuePtr(), hessian_.nonZeros(), 0.0);
  for (std::size_t i = 0; i < rest_.size(); ++i) addTriangle(i, plane, gradient);
  for (const Bend& bend : bends_) addBend(bend, plane, gradient);
  const double shift = kRegularization * hessian_.diagonal().mean();
  for (Eigen::Index k = 0; k < hessian_.rows(); ++k) hessian_.coeffRef(k, k) += shift;
  if (last_iterations_ == 0 || last_iterations_ > kManyIterations) renewPreconditioner();
  last_iterations_ = solve(gradient, direction);
  return direction.dot(gradient);
}

double SymmetricDirichlet::largestStep(const std::vector<Vec2>& plane,
                                       const Eigen::VectorXd& direction) const {
  double largest = std::numeric_limits<double>::infinity();
  const auto moves = [&](std::uint32_t v) { return Vec2(direction[2 * v], direction[2 * v + 1]); };
  for (const Triangle& t : triangles_) {
    const Vec2 ab = plane[t[1]] - plane[t[0]], ac = plane[t[2]] - plane[t[0]];
    const Vec2 ab_move = moves(t[1]) - moves(t[0]), ac_move = moves(t[2]) - moves(t[0]);
    const auto cross = [](const Vec2& p, const Vec2& q) { return p.x() * q.y() - p.y() * q.x(); };
    largest = std::min(largest, smallestPositiveRoot(cross(ab_move, ac_move),
                                                     cross(ab_move, ac) + cross(ab, ac_move), cross(ab, ac)));
  }
  return largest;
}

void SymmetricDirichlet::findBends(const Chart& chart, const std::vector<Vec2>& plane, double straightness) {
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

void SymmetricDirichlet::addBend(const Bend& bend, const std::vector<Vec2>& plane,
                                 Eigen::VectorXd& gradient) {
  const Vec2 amount = bendOf(bend.vertices, plane);
  for (std::size_t p = 0; p < 3; ++p)
    for (int axis = 0; axis < 2; ++axis) {
      const auto row = static_cast<Eigen::Index>(2 * bend.vertices[p]) + axis;
      gradient[row] += 2 * bend.weight * kBendWeights[p] * amount[axis];
      for (std::size_t q = 0; q < 3; ++q)
        hessian_.coeffRef(row, static_cast<Eigen::Index>(2 * bend.vertices[q]) + axis) +=
            2 * bend.weight * kBendWeights[p] * kBendWeights[q];
    }
}

void SymmetricDirichlet::findPattern(std::size_t vertices) {
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
  // Where the two entries of each block of two unknowns begin, so that sums need no search. Rows are sorted.
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
  std::vector<PairLaplacian::Group> groups(triangles_.begin(), triangles_.end());
  for (const Bend& bend : bends_) groups.push_back(bend.vertices);
  preconditioner_.setPattern(vertices, groups);
}

void SymmetricDirichlet::addTriangle(std::size_t i, const std::vector<Vec2>& plane,
                                     Eigen::VectorXd& gradient) {
  const RestTriangle& rest = rest_[i];
  const Triangle& t = triangles_[i];
  const SignedSvd svd = signedSvd(jacobian(rest, t, plane));
  const double a = svd.a, b = svd.b, ab = a * b;
  const double slope_a = 2 * (a - 1 / (a * a * a)), slope_b = 2 * (b - 1 / (b * b * b));
  // Eigenvectors of the energy's Hessian in J: the two stretches, the rotation, the mirrored shear.
  const Vec2 &u0 = svd.u, &v0 = svd.v, u1(-u0.y(), u0.x()), v1(-v0.y(), v0.x());
  const std::array<double, 4> curvatures = {2 + 6 / (a * a * a * a), 2 + 6 / (b * b * b * b),
                                            std::max(0.0, (slope_a + slope_b) / (a + b)),
                                            2 + 2 * (a * a + ab + b * b) / (ab * ab * ab)};
  const std::array<Matrix2, 4> modes = {u0 * v0.transpose(), u1 * v1.transpose(),
                                        (u1 * v0.transpose() - u0 * v1.transpose()) * M_SQRT1_2,
                                        (u1 * v0.transpose() + u0 * v1.transpose()) * M_SQRT1_2};
  stiffness_[i] = rest.area * (curvatures[0] + curvatures[1] + curvatures[2] + curvatures[3]) / 4;
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

void SymmetricDirichlet::renewPreconditioner() {
  preconditioner_.begin();
  const auto addGroup = [&](std::size_t group, double weight, const auto& product) {
    preconditioner_.add(group, {weight * product(0, 0), weight * product(1, 0), weight * product(1, 1),
                                weight * product(2, 0), weight * product(2, 1), weight * product(2, 2)});
  };
  for (std::size_t i = 0; i < rest_.size(); ++i)
    addGroup(i, stiffness_[i],
             [&](std::size_t p, std::size_t q) { return rest_[i].gradients[p].dot(rest_[i].gradients[q]); });
  for (std::size_t i = 0; i < bends_.size(); ++i)
    addGroup(rest_.size() + i, 2 * bends_[i].weight,
             [&](std::size_t p, std::size_t q) { return kBendWeights[p] * kBendWeights[q]; });
  preconditioner_.factorize();
}

// Preconditioned conjugate gradients, from zero: so that what they end with goes downhill whenever they end.
int SymmetricDirichlet::solve(const Eigen::VectorXd& gradient, Eigen::VectorXd& direction) {
  Eigen::VectorXd residual = -gradient, preconditioned(gradient.size()), image(gradient.size());
  direction.setZero(gradient.size());
  preconditioner_.solve(residual, preconditioned);
  Eigen::VectorXd search = preconditioned;
  double product = residual.dot(preconditioned);
  const double enough = kResidual * kResidual * product;
  int iteration = 0;
  while (iteration < kMostIterations && product > enough) {
    image.noalias() = hessian_.transpose() * search;  // by rows, as it is symmetric
    const double curvature = search.dot(image);
    if (!(curvature > 0)) break;
    ++iteration;
    const double length = product / curvature;
    direction += length * search;
    residual -= length * image;
    preconditioner_.solve(residual, preconditioned);
    const double next = residual.dot(preconditioned);
    search = preconditioned + next / product * search;
    product = next;
  }
  return iteration;
}

}  // namespace bakelight::atlas
