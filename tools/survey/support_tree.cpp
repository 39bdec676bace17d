#include "tools/survey/support_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <Eigen/Eigenvalues>
#include <limits>

namespace bakelight::survey {

using transport::Vec3;

namespace {

constexpr std::size_t kLeafSize = 8;
constexpr std::size_t kParallelSize = 4096;
constexpr std::size_t kLargestDepth = 64;
constexpr double kRounding = 1e-12;

double heightOf(const Plane& plane, const Vec3& point) {
  const Vec3 offset = point - plane.origin;
  return plane.normal.dot(offset) - plane.tolerance - plane.slope * offset.norm();
}

}  // namespace

SupportTree::SupportTree(std::vector<Vec3> points)
    : points_(std::move(points)), nodes_(nodeCount(points_.size())) {
  if (!points_.empty()) build(0, 0, static_cast<std::uint32_t>(points_.size()));
}

// Halves differ by one point at most, so the shape of the tree follows from the number of points.
std::size_t SupportTree::nodeCount(std::size_t points) {
  if (points <= kLeafSize) return points > 0 ? 1 : 0;
  return 1 + nodeCount(points / 2) + nodeCount(points - points / 2);
}

void SupportTree::build(std::size_t index, std::uint32_t begin, std::uint32_t end) {
  Node& node = nodes_[index];
  node.begin = begin, node.end = end;
  const auto first = points_.begin() + begin, last = points_.begin() + end;

  Vec3 mean = Vec3::Zero();
  for (auto p = first; p != last; ++p) mean += *p;
  mean /= end - begin;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (auto p = first; p != last; ++p) covariance += (*p - mean) * (*p - mean).transpose();
  node.axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().transpose();

  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (auto p = first; p != last; ++p) {
    const Vec3 local = node.axes * (*p - mean);
    low = low.cwiseMin(local), high = high.cwiseMax(local);
  }
  node.center = mean + node.axes.transpose() * ((low + high) / 2);
  // Wider than rounding of this arithmetic, so that no point is ever missed.
  node.half_extent = ((high - low) / 2).array() + kRounding * (mean.norm() + (high - low).norm());
  if (end - begin <= kLeafSize) return;

  // Eigenvalues come in ascending order: the last axis is the longest.
  const Vec3 along = node.axes.row(2);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(first, points_.begin() + middle, last,
                   [&](const Vec3& a, const Vec3& b) { return along.dot(a) < along.dot(b); });
  node.right = static_cast<std::uint32_t>(index + 1 + nodeCount(middle - begin));
  const auto left = [&] { build(index + 1, begin, middle); };
  const auto right = [&] { build(node.right, middle, end); };
  if (end - begin > kParallelSize)
    tbb::parallel_invoke(left, right);
  else
    left(), right();
}

// Not below the height of any point of the node.
double SupportTree::bound(const Node& node, const Plane& plane) {
  const Vec3 local_normal = node.axes * plane.normal;
  const Vec3 offset = node.center - plane.origin;
  const double height =
      plane.normal.dot(offset) + local_normal.cwiseAbs().dot(node.half_extent) - plane.tolerance;
  const Vec3 local_offset = node.axes * offset;
  const double nearest = (local_offset.cwiseAbs() - node.half_extent).cwiseMax(0).norm();
  return height - plane.slope * nearest;
}

double SupportTree::highest(const Plane& plane, double known) const {
  if (nodes_.empty()) return known;
  struct Open {
    std::uint32_t node;
    double bound;
  };
  std::array<Open, kLargestDepth> open;
  std::size_t count = 0;
  open[count++] = {0, bound(nodes_[0], plane)};
  while (count > 0) {
    const Open next = open[--count];
    if (next.bound <= known) continue;
    const Node& node = nodes_[next.node];
    if (node.right == 0) {
      for (std::uint32_t p = node.begin; p < node.end; ++p)
        known = std::max(known, heightOf(plane, points_[p]));
      continue;
    }
    Open near = {next.node + 1, bound(nodes_[next.node + 1], plane)};
    Open far = {node.right, bound(nodes_[node.right], plane)};
    if (near.bound < far.bound) std::swap(near, far);
    open[count++] = far, open[count++] = near;  // the more promising one first
  }
  return known;
}

}  // namespace bakelight::survey
