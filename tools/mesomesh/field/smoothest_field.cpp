#include "tools/mesomesh/field/smoothest_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/SparseCholesky>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace bakelight::mesomesh {
namespace {

constexpr int kIterations = 40;
// Of the mean weight of a node: makes the matrix definite where a field without any turn exists.
constexpr double kShift = 1e-7;
// How much more a node is pulled to what it is held to than to its neighbours.
constexpr double kHold = 1e4;
// A node's own part in a mean, over that of all its neighbours: what keeps them from swapping.
constexpr double kOwnShare = 0.3;

std::vector<std::uint32_t> partOfNodes(const ClusterLevel& level) {
  constexpr std::uint32_t kUnseen = ~std::uint32_t{0};
  std::vector<std::uint32_t> part(level.size(), kUnseen), stack;
  std::uint32_t count = 0;
  for (std::uint32_t seed = 0; seed < level.size(); ++seed) {
    if (part[seed] != kUnseen) continue;
    part[seed] = count;
    stack.assign(1, seed);
    while (!stack.empty()) {
      const std::uint32_t i = stack.back();
      stack.pop_back();
      for (std::uint32_t k = level.first[i]; k < level.first[i + 1]; ++k) {
        if (part[level.neighbors[k]] != kUnseen) continue;
        part[level.neighbors[k]] = count;
        stack.push_back(level.neighbors[k]);
      }
    }
    ++count;
  }
  return part;
}

double nodeWeight(const ClusterLevel& level, std::size_t i) {
  return std::accumulate(level.weights.begin() + level.first[i], level.weights.begin() + level.first[i + 1],
                         0.0);
}

// A start that no symmetry of the mesh makes orthogonal to what is sought.
Complex anyPhase(std::uint64_t i) {
  std::uint64_t x = i * 0x9e3779b97f4a7c15u + 0x632be59bd9b4e019u;
  x ^= x >> 29, x *= 0xbf58476d1ce4e5b9u, x ^= x >> 32;
  return std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(x >> 11) * 0x1p-53);
}

Eigen::SparseMatrix<double> connectionLaplacian(const ClusterLevel& level, int symmetry, const Held& held) {
  const auto count = static_cast<Eigen::Index>(level.size());
  double sum = 0;
  for (std::size_t i = 0; i < level.size(); ++i) sum += nodeWeight(level, i);
  const double shift = kShift * std::max(sum, 1.0) / static_cast<double>(level.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto node = static_cast<std::size_t>(i);
    double diagonal = shift;
    for (std::uint32_t k = level.first[node]; k < level.first[node + 1]; ++k) {
      const auto j = static_cast<Eigen::Index>(level.neighbors[k]);
      // z_i takes from z_j what is carried from j to i.
      const Complex turn = carried(level, level.neighbors[k], level, node, symmetry);
      if (turn == Complex(0)) continue;
      const double weight = level.weights[k];
      diagonal += weight;
      if (j > i) continue;  // the lower triangle
      entries.emplace_back(2 * i, 2 * j, -weight * turn.real());
      entries.emplace_back(2 * i, 2 * j + 1, weight * turn.imag());
      entries.emplace_back(2 * i + 1, 2 * j, -weight * turn.imag());
      entries.emplace_back(2 * i + 1, 2 * j + 1, -weight * turn.real());
    }
    if (held.contains(static_cast<std::uint32_t>(i))) diagonal += kHold * (1 + nodeWeight(level, node));
    entries.emplace_back(2 * i, 2 * i, diagonal);
    entries.emplace_back(2 * i + 1, 2 * i + 1, diagonal);
  }
  Eigen::SparseMatrix<double> matrix(2 * count, 2 * count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

std::vector<Complex> smoothestField(const ClusterLevel& level, int symmetry, const Held& held) {
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(connectionLaplacian(level, symmetry, held));
  if (solver.info() != Eigen::Success) throw std::runtime_error("the field's matrix could not be factorised");
  const std::vector<std::uint32_t> part = partOfNodes(level);
  const std::size_t parts = part.empty() ? 0 : 1 + *std::max_element(part.begin(), part.end());
  std::vector<bool> is_held(parts);
  for (const auto& [node, value] : held) is_held[part[node]] = true;

  std::vector<Complex> field(level.size());
  for (std::size_t i = 0; i < level.size(); ++i) field[i] = anyPhase(i);
  Eigen::VectorXd right(2 * static_cast<Eigen::Index>(level.size()));
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (std::size_t i = 0; i < level.size(); ++i) {
      Complex value = is_held[part[i]] ? Complex(0) : level.masses[i] * field[i];
      if (const auto found = held.find(static_cast<std::uint32_t>(i)); found != held.end())
        value = kHold * (1 + nodeWeight(level, i)) * found->second;
      right[2 * static_cast<Eigen::Index>(i)] = value.real();
      right[2 * static_cast<Eigen::Index>(i) + 1] = value.imag();
    }
    const Eigen::VectorXd solution = solver.solve(right);
    std::vector<double> squared(parts, 0);
    for (std::size_t i = 0; i < level.size(); ++i) {
      field[i] = {solution[2 * static_cast<Eigen::Index>(i)], solution[2 * static_cast<Eigen::Index>(i) + 1]};
      squared[part[i]] += level.masses[i] * std::norm(field[i]);
    }
    for (std::size_t i = 0; i < level.size(); ++i)
      if (!is_held[part[i]] && squared[part[i]] > 0) field[i] /= std::sqrt(squared[part[i]]);
  }
  return field;
}

void smoothField(const ClusterLevel& level, int symmetry, const Held& held, int sweeps,
                 std::vector<Complex>& field) {
  // Of each link, carried() from the neighbour, times the weight.
  std::vector<std::complex<float>> turns(level.neighbors.size());
  std::vector<float> own(level.size());
  const auto forNodes = [&](const auto& visit) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, field.size(), 2048), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i);
    });
  };
  forNodes([&](std::size_t i) {
    for (std::uint32_t k = level.first[i]; k < level.first[i + 1]; ++k) {
      const Complex turn = carried(level, level.neighbors[k], level, i, symmetry);
      turns[k] = std::complex<float>(static_cast<double>(level.weights[k]) * turn);
      own[i] += level.weights[k];
    }
  });
  std::vector<Complex> next(field.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    forNodes([&](std::size_t i) {
      double real = kOwnShare * own[i] * field[i].real(), imag = kOwnShare * own[i] * field[i].imag();
      for (std::uint32_t k = level.first[i]; k < level.first[i + 1]; ++k) {
        const Complex& z = field[level.neighbors[k]];
        const double c = turns[k].real(), s = turns[k].imag();
        real += c * z.real() - s * z.imag();
        imag += c * z.imag() + s * z.real();
      }
      const double length = std::sqrt(real * real + imag * imag);
      next[i] = length > 1e-9 * own[i] ? Complex(real / length, imag / length) : field[i];
    });
    for (const auto& [node, value] : held) next[node] = value;
    field.swap(next);
  }
}

}  // namespace bakelight::mesomesh
