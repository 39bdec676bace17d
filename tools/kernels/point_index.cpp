#include "tools/kernels/point_index.h"

#include <algorithm>
#include <flann/flann.hpp>

namespace bakelight::kernels {

// In double precision: what is within a radius must not depend on roundings of the tree.
struct PointIndex::Implementation {
  static constexpr int kLeafSize = 10;
  std::vector<Vec3> points;
  flann::KDTreeSingleIndex<flann::L2_3D<double>> tree;

  explicit Implementation(std::span<const Vec3> given)
      : points(given.begin(), given.end()),
        tree(flann::Matrix<double>(points.front().data(), points.size(), 3),
             flann::KDTreeSingleIndexParams(kLeafSize)) {
    tree.buildIndex();
  }
};

PointIndex::PointIndex(std::span<const Vec3> points)
    : implementation_(std::make_unique<Implementation>(points)) {}
PointIndex::~PointIndex() = default;

void PointIndex::within(const Vec3& place, double radius, std::vector<std::uint32_t>& found) const {
  flann::RadiusResultSet<double> result(radius * radius);
  implementation_->tree.findNeighbors(result, place.data(),
                                      flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  std::vector<std::size_t> indices(result.size());
  std::vector<double> distances(result.size());
  if (!indices.empty()) result.copy(indices.data(), distances.data(), indices.size(), false);
  found.assign(indices.begin(), indices.end());
  std::sort(found.begin(), found.end());
}

void PointIndex::nearest(const Vec3& place, std::size_t count, std::vector<std::uint32_t>& found) const {
  count = std::min(count, implementation_->points.size());
  flann::KNNSimpleResultSet<double> nearest(count);
  implementation_->tree.findNeighbors(nearest, place.data(),
                                      flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  // All that are as near as the last one: which of them the tree met first does not matter then.
  within(place, std::sqrt(nearest.worstDist()) * (1 + 1e-12), found);
  const auto distance = [&](std::uint32_t i) { return (implementation_->points[i] - place).squaredNorm(); };
  std::sort(found.begin(), found.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double da = distance(a), db = distance(b);
    return da < db || (da == db && a < b);
  });
  if (found.size() > count) found.resize(count);
}

}  // namespace bakelight::kernels
