#include "transport/vertex_fit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace bakelight::transport {

using formats::TriangleMesh;

namespace {

constexpr std::size_t kColumnsAtOnce = 32;
constexpr std::size_t kVerticesPerTask = 512;
// Of the right side's norm, in each column. Corrections are small beside the values.
constexpr double kTolerance = 1e-6;
constexpr int kMostIterations = 200;

constexpr std::size_t entryOf(std::size_t i, std::size_t j) {
  constexpr std::array<std::array<std::size_t, 3>, 3> kEntries = {{{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}};
  return kEntries[i][j];
}

double fraction(double x) {
  return x - std::floor(x);
}

std::vector<std::uint32_t> firstCopies(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertexCount()), first(mesh.vertexCount());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::uint32_t v) { return std::tie(mesh.positions[v], mesh.normals[v]); };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
  return first;
}

}  // namespace

std::vector<FitSample> samplesOn(const TriangleMesh& mesh, std::uint32_t triangle, int count) {
  // Roberts' R2 sequence, folded; it goes on from triangle to triangle, so that no place is favoured.
  constexpr double kPlastic = 1.32471795724474602596;
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Vec3 origin = vec3(mesh.positions[a]);
  const double area = (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin).norm() / 2;
  std::vector<FitSample> samples(count);
  for (int i = 0; i < count; ++i) {
    const double number = static_cast<double>(triangle) * count + i + 0.5;
    double u = fraction(number / kPlastic), v = fraction(number / (kPlastic * kPlastic));
    if (u + v > 1) u = 1 - u, v = 1 - v;
    samples[i] = {{1 - u - v, u, v}, area / count};
  }
  return samples;
}

VertexFit::VertexFit(const TriangleMesh& mesh, std::size_t columns, double smoothness)
    : mesh_(mesh),
      columns_(columns),
      smoothness_(smoothness),
      first_copy_(firstCopies(mesh)),
      mass_(mesh.triangleCount()),
      right_(mesh.vertexCount() * columns, 0.0F) {}

VertexFit::Element VertexFit::element(std::span<const FitSample> samples,
                                      std::span<const float> residuals) const {
  std::array<double, 6> mass{};
  std::vector<double> right(3 * columns_, 0.0);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const FitSample& sample = samples[s];
    if (sample.area == 0) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const double weight = sample.area * sample.weights[static_cast<Eigen::Index>(i)];
      for (std::size_t j = i; j < 3; ++j)
        mass[entryOf(i, j)] += weight * sample.weights[static_cast<Eigen::Index>(j)];
      for (std::size_t c = 0; c < columns_; ++c)
        right[i * columns_ + c] += weight * residuals[s * columns_ + c];
    }
  }
  Element element;
  std::copy(mass.begin(), mass.end(), element.mass.begin());
  element.right.assign(right.begin(), right.end());
  return element;
}

void VertexFit::add(std::uint32_t triangle, const Element& element) {
  mass_[triangle] = element.mass;
  for (std::size_t i = 0; i < 3; ++i) {
    float* const row = &right_[first_copy_[mesh_.triangles[triangle][i]] * columns_];
    for (std::size_t c = 0; c < columns_; ++c) row[c] += element.right[i * columns_ + c];
  }
}

// Columns side by side, each with coefficients of its own.
class VertexFit::Solver {
 public:
  explicit Solver(const VertexFit& fit) : fit_(fit), count_(fit.mesh_.vertexCount()), begin_(count_ + 1, 0) {
    // Matrices of the elements, with the smoothness, and the corners at each unknown.
    const TriangleMesh& mesh = fit.mesh_;
    stiffness_.resize(mesh.triangleCount());
    corners_.resize(3 * mesh.triangleCount());
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t v : triangle) ++begin_[fit.first_copy_[v] + 1];
    for (std::size_t v = 0; v < count_; ++v) begin_[v + 1] += begin_[v];
    std::vector<std::uint32_t> end(begin_.begin(), begin_.end() - 1);
    inverse_diagonal_.assign(count_, 0.0F);
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      std::array<Vec3, 3> edges;
      for (std::size_t i = 0; i < 3; ++i)
        edges[i] = vec3(mesh.positions[mesh.triangles[t][(i + 2) % 3]]) -
                   vec3(mesh.positions[mesh.triangles[t][(i + 1) % 3]]);
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j)
          stiffness_[t][entryOf(i, j)] =
              static_cast<float>(fit.mass_[t][entryOf(i, j)] + fit.smoothness_ * edges[i].dot(edges[j]));
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t v = fit.first_copy_[mesh.triangles[t][i]];
        corners_[end[v]++] = 3 * t + i;
        inverse_diagonal_[v] += stiffness_[t][entryOf(i, i)];
      }
    }
    for (float& value : inverse_diagonal_) value = value > 0 ? 1 / value : 0;
  }

  // Into `x`, of the columns from `first`: count × width.
  int solve(std::size_t first, std::size_t width, std::vector<float>& x) const {
    std::vector<float> residual(count_ * width), direction(count_ * width), image(count_ * width);
    x.assign(count_ * width, 0.0F);
    for (std::size_t v = 0; v < count_; ++v)
      std::copy_n(&fit_.right_[v * fit_.columns_ + first], width, &residual[v * width]);
    std::vector<double> energy = preconditionedEnergy(residual, width);
    std::vector<double> target = energy;
    for (double& value : target) value *= kTolerance * kTolerance;
    std::vector<float> momentum(width, 0.0F);
    int iterations = 0;
    for (; iterations < kMostIterations; ++iterations) {
      bool done = true;
      for (std::size_t c = 0; c < width; ++c) done = done && energy[c] <= target[c];
      if (done) break;
      forVertices([&](std::size_t v) {
        for (std::size_t c = 0; c < width; ++c)
          direction[v * width + c] =
              inverse_diagonal_[v] * residual[v * width + c] + momentum[c] * direction[v * width + c];
      });
      multiply(direction, image, width);
      const std::vector<double> curvature = products(direction, image, width);
      std::vector<float> step(width);
      for (std::size_t c = 0; c < width; ++c)
        step[c] = curvature[c] > 0 ? static_cast<float>(energy[c] / curvature[c]) : 0.0F;
      forVertices([&](std::size_t v) {
        for (std::size_t i = v * width, c = 0; c < width; ++c, ++i) {
          x[i] += step[c] * direction[i];
          residual[i] -= step[c] * image[i];
        }
      });
      const std::vector<double> next = preconditionedEnergy(residual, width);
      for (std::size_t c = 0; c < width; ++c)
        momentum[c] = energy[c] > 0 ? static_cast<float>(next[c] / energy[c]) : 0.0F;
      energy = next;
    }
    return iterations;
  }

  // Σ over the columns of 2 right · x − x · mass x.
  double squaresRemoved(std::size_t first, std::size_t width, const std::vector<float>& x) const {
    const TriangleMesh& mesh = fit_.mesh_;
    double sum = 0;
    for (std::size_t v = 0; v < count_; ++v)
      for (std::size_t c = 0; c < width; ++c)
        sum += 2.0 * fit_.right_[v * fit_.columns_ + first + c] * x[v * width + c];
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
          const float* const a = &x[fit_.first_copy_[mesh.triangles[t][i]] * width];
          const float* const b = &x[fit_.first_copy_[mesh.triangles[t][j]] * width];
          double product = 0;
          for (std::size_t c = 0; c < width; ++c) product += static_cast<double>(a[c]) * b[c];
          sum -= fit_.mass_[t][entryOf(i, j)] * product;
        }
    return sum;
  }

 private:
  template <class Function>
  void forVertices(const Function& function) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count_, kVerticesPerTask), [&](const auto& range) {
      for (std::size_t v = range.begin(); v < range.end(); ++v) function(v);
    });
  }

  void multiply(const std::vector<float>& x, std::vector<float>& result, std::size_t width) const {
    forVertices([&](std::size_t v) {
      float* const row = &result[v * width];
      std::fill_n(row, width, 0.0F);
      for (std::uint32_t k = begin_[v]; k < begin_[v + 1]; ++k) {
        const std::uint32_t t = corners_[k] / 3, i = corners_[k] % 3;
        for (std::size_t j = 0; j < 3; ++j) {
          const float entry = stiffness_[t][entryOf(i, j)];
          const float* const other = &x[fit_.first_copy_[fit_.mesh_.triangles[t][j]] * width];
          for (std::size_t c = 0; c < width; ++c) row[c] += entry * other[c];
        }
      }
    });
  }

  // Column by column, in pieces whose order does not depend on the threads.
  template <class Value>
  std::vector<double> sums(std::size_t width, const Value& value) const {
    const std::size_t pieces = (count_ + kVerticesPerTask - 1) / kVerticesPerTask;
    std::vector<double> of_pieces(pieces * width, 0.0), sum(width, 0.0);
    tbb::parallel_for(std::size_t{0}, pieces, [&](std::size_t p) {
      for (std::size_t v = p * kVerticesPerTask; v < std::min(count_, (p + 1) * kVerticesPerTask); ++v)
        for (std::size_t c = 0; c < width; ++c) of_pieces[p * width + c] += value(v, c);
    });
    for (std::size_t p = 0; p < pieces; ++p)
      for (std::size_t c = 0; c < width; ++c) sum[c] += of_pieces[p * width + c];
    return sum;
  }
  std::vector<double> products(const std::vector<float>& a, const std::vector<float>& b,
                               std::size_t width) const {
    return sums(width, [&](std::size_t v, std::size_t c) {
      return static_cast<double>(a[v * width + c]) * b[v * width + c];
    });
  }
  std::vector<double> preconditionedEnergy(const std::vector<float>& residual, std::size_t width) const {
    return sums(width, [&](std::size_t v, std::size_t c) {
      const double value = residual[v * width + c];
      return value * value * inverse_diagonal_[v];
    });
  }

  const VertexFit& fit_;
  std::size_t count_;
  std::vector<std::array<float, 6>> stiffness_;
  std::vector<std::uint32_t> begin_, corners_;  // 3 × triangle + corner
  std::vector<float> inverse_diagonal_;
};

VertexFit::Corrections VertexFit::solve() {
  const Solver solver(*this);
  Corrections result;
  std::vector<float> x;
  for (std::size_t first = 0; first < columns_; first += kColumnsAtOnce) {
    const std::size_t width = std::min(kColumnsAtOnce, columns_ - first);
    result.iterations = std::max(result.iterations, solver.solve(first, width, x));
    result.squares_removed += solver.squaresRemoved(first, width, x);
    for (std::size_t v = 0; v < first_copy_.size(); ++v)
      std::copy_n(&x[v * width], width, &right_[v * columns_ + first]);
  }
  result.rows = std::move(right_);
  return result;
}

}  // namespace bakelight::transport
