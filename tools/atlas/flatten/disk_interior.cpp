#include "tools/atlas/flatten/disk_interior.h"

#include <algorithm>
#include <cmath>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <limits>
#include <numeric>

#include "tools/atlas/charts/stretch.h"

namespace bakelight::atlas {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostSolves = 12;
constexpr int kMostSweeps = 60;
constexpr double kLeastGain = 1e-4;

// Whether a, b, c turn left, beyond doubt: the bound of the rounding error is Shewchuk's (1997).
bool turnsLeft(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double left = (a.x() - c.x()) * (b.y() - c.y()), right = (a.y() - c.y()) * (b.x() - c.x());
  return left - right > 4e-16 * (std::abs(left) + std::abs(right));
}

double tangentOfHalfAngle(const Vec2& u, const Vec2& v) {
  const double lengths = u.norm() * v.norm(), dot = u.dot(v), cross = u.x() * v.y() - u.y() * v.x();
  return dot > 0 ? cross / (lengths + dot) : (lengths - dot) / cross;
}

// The gradients of the three hat functions of each triangle on its shape, and its weighted area.
struct Element {
  std::array<Vec2, 3> gradients;
  double area;
};

std::vector<Element> elementsOf(const DiskMesh& mesh) {
  std::vector<Element> elements(mesh.triangles.size());
  for (std::size_t t = 0; t < elements.size(); ++t) {
    const auto& [a, b, c] = mesh.shapes[t];
    const double cross = crossOf(a, b, c);
    const auto gradient = [&](const Vec2& from, const Vec2& to) {
      return Vec2((from.y() - to.y()) / cross, (to.x() - from.x()) / cross);
    };
    elements[t] = {{gradient(b, c), gradient(c, a), gradient(a, b)}, mesh.weights[t] * cross / 2};
  }
  return elements;
}

// ‖J‖²/det² of the map from shape to plane is Γ² + γ².
double stretchOf(const Element& element, const Vec2& a, const Vec2& b, const Vec2& c) {
  if (!turnsLeft(a, b, c)) return kInfinity;
  const Vec2 du = a.x() * element.gradients[0] + b.x() * element.gradients[1] + c.x() * element.gradients[2];
  const Vec2 dv = a.y() * element.gradients[0] + b.y() * element.gradients[1] + c.y() * element.gradients[2];
  const double det = du.x() * dv.y() - du.y() * dv.x();
  return det > 0 ? (du.squaredNorm() + dv.squaredNorm()) / (2 * det * det) : kInfinity;
}

// The equations of the vertices that are not fixed; their pattern is analysed once.
class ConvexCombinations {
 public:
  explicit ConvexCombinations(const DiskMesh& mesh) : mesh_(mesh), index_(mesh.vertexCount(), -1) {
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
      if (!mesh.fixed[v]) index_[v] = count_++;
  }

  // `weight(t, i, j)` is what triangle t adds to the weight of its corner j in the equation of its corner i.
  template <class Weight>
  bool solve(const Weight& weight, std::vector<Vec2>& plane) {
    if (count_ == 0) return true;
    std::vector<double> sums(mesh_.vertexCount(), 0.0);
    forEach(weight, [&](std::uint32_t i, std::uint32_t, double w) { sums[i] += w; });
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(count_, 2);
    for (int i = 0; i < count_; ++i) entries.emplace_back(i, i, 1.0);
    forEach(weight, [&](std::uint32_t i, std::uint32_t j, double w) {
      if (index_[j] >= 0)
        entries.emplace_back(index_[i], index_[j], -w / sums[i]);
      else
        right.row(index_[i]) += w / sums[i] * plane[j].transpose();
    });
    Eigen::SparseMatrix<double> matrix(count_, count_);
    matrix.setFromTriplets(entries.begin(), entries.end());
    if (!analyzed_) solver_.analyzePattern(matrix);
    analyzed_ = true;
    solver_.factorize(matrix);
    if (solver_.info() != Eigen::Success) return false;
    const Eigen::MatrixX2d solution = solver_.solve(right);
    if (!solution.allFinite()) return false;
    for (std::size_t v = 0; v < index_.size(); ++v)
      if (index_[v] >= 0) plane[v] = solution.row(index_[v]);
    return true;
  }

 private:
  template <class Weight, class Visit>
  void forEach(const Weight& weight, const Visit& visit) const {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t v = mesh_.triangles[t][i];
        if (index_[v] < 0) continue;
        for (const std::size_t j : {(i + 1) % 3, (i + 2) % 3})
          visit(v, mesh_.triangles[t][j], weight(t, i, j));
      }
  }

  const DiskMesh& mesh_;
  std::vector<int> index_;
  int count_ = 0;
  bool analyzed_ = false;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver_;
};

// Floater's weights, the part of each corner of each triangle towards the other two.
struct MeanValueWeights {
  explicit MeanValueWeights(const DiskMesh& mesh) : parts(mesh.triangles.size()) {
    for (std::size_t t = 0; t < parts.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& shape = mesh.shapes[t];
        const Vec2 u = shape[(i + 1) % 3] - shape[i], v = shape[(i + 2) % 3] - shape[i];
        const double tangent = tangentOfHalfAngle(u, v);
        parts[t][i] = {tangent / u.norm(), tangent / v.norm()};
      }
  }
  double operator()(std::size_t t, std::size_t i, std::size_t j) const {
    return parts[t][i][(i + 1) % 3 == j ? 0 : 1];
  }
  std::vector<std::array<std::array<double, 2>, 3>> parts;
};

class StretchDescent {
 public:
  StretchDescent(const DiskMesh& mesh, std::vector<Vec2>& plane)
      : mesh_(mesh), elements_(elementsOf(mesh)), plane_(plane), first_(mesh.vertexCount() + 1, 0) {
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    around_.resize(3 * mesh.triangles.size());
    std::vector<std::uint32_t> filled(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) around_[filled[v]++] = t;
  }

  double total() const {
    double sum = 0;
    for (std::uint32_t t = 0; t < elements_.size(); ++t) sum += stretchOfTriangle(t);
    return sum;
  }

  // Root mean square of the stretch around each vertex.
  std::vector<double> stretchOfVertices() const {
    std::vector<double> weighted(mesh_.vertexCount(), 0.0), area(mesh_.vertexCount(), 0.0);
    for (std::uint32_t t = 0; t < elements_.size(); ++t)
      for (const std::uint32_t v : mesh_.triangles[t]) {
        weighted[v] += stretchOfTriangle(t);
        area[v] += elements_[t].area;
      }
    for (std::size_t v = 0; v < weighted.size(); ++v) weighted[v] = std::sqrt(weighted[v] / area[v]);
    return weighted;
  }

  // Each vertex once, forwards and then backwards, so that no direction is preferred.
  void sweep() {
    const auto count = static_cast<std::uint32_t>(mesh_.vertexCount());
    for (std::uint32_t v = 0; v < count; ++v)
      if (!mesh_.fixed[v]) improve(v);
    for (std::uint32_t v = count; v-- > 0;)
      if (!mesh_.fixed[v]) improve(v);
  }

 private:
  double stretchOfTriangle(std::uint32_t t) const {
    const auto& [a, b, c] = mesh_.triangles[t];
    return elements_[t].area * stretchOf(elements_[t], plane_[a], plane_[b], plane_[c]);
  }

  double stretchAround(std::uint32_t v) const {
    double sum = 0;
    for (std::uint32_t i = first_[v]; i < first_[v + 1] && sum < kInfinity; ++i)
      sum += stretchOfTriangle(around_[i]);
    return sum;
  }

  // Gradient and Hessian of stretchAround by the vertex's two coordinates.
  void derivatives(std::uint32_t v, Vec2& gradient, Eigen::Matrix2d& hessian) const {
    gradient.setZero();
    hessian.setZero();
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      const Triangle& triangle = mesh_.triangles[around_[i]];
      const Element& element = elements_[around_[i]];
      Vec2 du = Vec2::Zero(), dv = Vec2::Zero(), own = Vec2::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        du += plane_[triangle[k]].x() * element.gradients[k];
        dv += plane_[triangle[k]].y() * element.gradients[k];
        if (triangle[k] == v) own = element.gradients[k];
      }
      // F = |∇u|² + |∇v|² and d = ∇u × ∇v of F/d².
      const double f = du.squaredNorm() + dv.squaredNorm(), d = du.x() * dv.y() - du.y() * dv.x();
      const Vec2 f1 = 2 * Vec2(du.dot(own), dv.dot(own));
      const Vec2 d1(own.x() * dv.y() - own.y() * dv.x(), du.x() * own.y() - du.y() * own.x());
      const double scale = element.area / (2 * d * d);
      gradient += scale * (f1 - 2 * f / d * d1);
      hessian += scale * (2 * own.squaredNorm() * Eigen::Matrix2d::Identity() -
                          2 / d * (f1 * d1.transpose() + d1 * f1.transpose()) +
                          6 * f / (d * d) * d1 * d1.transpose());
    }
  }

  // A step of Newton's method, halved until it lowers the stretch; it never leaves the ring, as the stretch
  // is infinite there.
  void improve(std::uint32_t v) {
    Vec2 gradient;
    Eigen::Matrix2d hessian;
    derivatives(v, gradient, hessian);
    const double trace = hessian.trace(), determinant = hessian.determinant();
    Vec2 step = determinant > 1e-9 * trace * trace && trace > 0 ? Vec2(-hessian.inverse() * gradient)
                                                                : Vec2(-gradient / std::abs(trace));
    if (!step.allFinite() || step.isZero(0)) return;
    const Vec2 before = plane_[v];
    const double stretch = stretchAround(v);
    for (int halvings = 0; halvings < 12; ++halvings, step /= 2) {
      plane_[v] = before + step;
      if (stretchAround(v) < stretch) return;
    }
    plane_[v] = before;
  }

  const DiskMesh& mesh_;
  const std::vector<Element> elements_;
  std::vector<Vec2>& plane_;
  std::vector<std::uint32_t> first_,
      around_;  // the triangles around vertex v: around_[first_[v] … first_[v + 1])
};

}  // namespace

double weightedStretch(const DiskMesh& mesh, const std::vector<Vec2>& plane) {
  std::vector<Vec2> copy = plane;
  return StretchDescent(mesh, copy).total();
}

bool solveInterior(const DiskMesh& mesh, InteriorWeights weights, std::vector<Vec2>& plane) {
  ConvexCombinations equations(mesh);
  if (weights == InteriorWeights::kMeanValue) return equations.solve(MeanValueWeights(mesh), plane);
  return equations.solve([](std::size_t, std::size_t, std::size_t) { return 1.0; }, plane);
}

void minimizeStretch(const DiskMesh& mesh, std::vector<Vec2>& plane) {
  StretchDescent descent(mesh, plane);
  double best = descent.total();
  MeanValueWeights weights(mesh);
  ConvexCombinations equations(mesh);
  for (int i = 0; i < kMostSolves; ++i) {
    const std::vector<Vec2> before = plane;
    const std::vector<double> stretch = descent.stretchOfVertices();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t side = 0; side < 2; ++side)
          weights.parts[t][k][side] /= stretch[mesh.triangles[t][(k + 1 + side) % 3]];
    const double total = equations.solve(weights, plane) ? descent.total() : kInfinity;
    if (!(total < best)) {
      plane = before;
      break;
    }
    best = total;
  }
  for (int i = 0; i < kMostSweeps; ++i) {
    descent.sweep();
    const double total = descent.total();
    const double gain = (best - total) / best;
    best = total;
    if (gain < kLeastGain) break;
  }
}

}  // namespace bakelight::atlas
