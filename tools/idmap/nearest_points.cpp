#include "tools/idmap/nearest_points.h"

#include <algorithm>
#include <cmath>
#include <flann/flann.hpp>
#include <limits>
#include <utility>

namespace bakelight::idmap {
namespace {

constexpr int kLeafSize = 10;
constexpr std::size_t kLargestGroup = 16;
constexpr double kGroupSpread = 0.35;  // of the distance that the search before spanned
// Over the roundings of distances in single precision.
constexpr double kSlack = 1 + 1e-5;

double distanceBetween(const Float3& a, const Float3& b) {
  return std::sqrt(squaredDistance(a, b));
}

// All points within `margin` of the distance of the k-th nearest.
class WidenedResult final : public flann::ResultSet<float> {
 public:
  // `bound`: at least the distance of the k-th nearest.
  void begin(std::size_t k, double bound, double margin) {
    margin_ = margin;
    nearest_.assign(k, static_cast<float>(std::min(bound * bound * kSlack, kFarthest)));
    points_.clear();
    setWorst();
  }
  bool full() const override { return true; }
  float worstDist() const override { return worst_; }
  void addPoint(float squared_distance, std::size_t index) override {
    points_.push_back(static_cast<std::uint32_t>(index));
    if (squared_distance >= nearest_.back()) return;
    std::size_t i = nearest_.size() - 1;
    for (; i > 0 && nearest_[i - 1] > squared_distance; --i) nearest_[i] = nearest_[i - 1];
    nearest_[i] = squared_distance;
    setWorst();
  }

  std::span<const std::uint32_t> points() const { return points_; }
  double kthDistance() const { return std::sqrt(static_cast<double>(nearest_.back())); }

 private:
  static constexpr double kFarthest = std::numeric_limits<float>::max();

  void setWorst() {
    const double reach = (kthDistance() + margin_) * kSlack;
    worst_ = static_cast<float>(std::min(reach * reach, kFarthest));
  }

  double margin_ = 0;
  std::vector<float> nearest_;  // squared distances, rising
  std::vector<std::uint32_t> points_;
  float worst_ = 0;
};

struct Ball {
  std::size_t count = 0;  // of queries in it
  Float3 center{};
  double radius = 0;
};

// The first queries that lie within `spread` of a point; one at least.
Ball ballOf(std::span<const Float3> queries, double spread) {
  Float3 low = queries[0], high = queries[0];
  Ball ball;
  for (; ball.count < std::min(queries.size(), kLargestGroup); ++ball.count) {
    Float3 new_low = low, new_high = high;
    for (std::size_t c = 0; c < 3; ++c) {
      new_low[c] = std::min(low[c], queries[ball.count][c]);
      new_high[c] = std::max(high[c], queries[ball.count][c]);
    }
    if (ball.count > 0 && distanceBetween(new_low, new_high) > 2 * spread) break;
    low = new_low, high = new_high;
  }
  for (std::size_t c = 0; c < 3; ++c) ball.center[c] = low[c] + (high[c] - low[c]) / 2;
  for (const Float3& query : queries.first(ball.count))
    ball.radius = std::max(ball.radius, distanceBetween(ball.center, query));
  return ball;
}

}  // namespace

struct NearestPoints::Implementation {
  std::vector<Float3> points;
  flann::KDTreeSingleIndex<flann::L2_3D<float>> tree;

  explicit Implementation(std::span<const Float3> given)
      : points(given.begin(), given.end()),
        tree(flann::Matrix<float>(points.front().data(), points.size(), 3),
             flann::KDTreeSingleIndexParams(kLeafSize)) {
    tree.buildIndex();
  }
};

NearestPoints::NearestPoints(std::span<const Float3> points)
    : implementation_(std::make_unique<Implementation>(points)) {}

NearestPoints::~NearestPoints() = default;

struct NearestPoints::Walk::Result {
  WidenedResult widened;
};

NearestPoints::Walk::Walk(const NearestPoints& points, std::span<const Float3> queries, std::size_t k)
    : result_(std::make_unique<Result>()), points_(points), queries_(queries), k_(k) {}

NearestPoints::Walk::~Walk() = default;

bool NearestPoints::Walk::next() {
  if (queries_.empty()) return false;
  const Ball ball = ballOf(queries_, kGroupSpread * group_.reach);
  WidenedResult& result = result_->widened;
  const double bound = bound_ + (std::isinf(bound_) ? 0 : distanceBetween(group_.center, ball.center));
  result.begin(k_, bound, 2 * ball.radius);
  points_.implementation_->tree.findNeighbors(result, ball.center.data(),
                                              flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  bound_ = result.kthDistance();
  group_ = {queries_.first(ball.count), result.points(), ball.center, bound_ / kSlack};
  queries_ = queries_.subspan(ball.count);
  return true;
}

void NearestPoints::keepNearest(const Float3& query, std::size_t k,
                                std::vector<std::uint32_t>& candidates) const {
  if (candidates.size() <= k) return;
  std::vector<std::pair<double, std::uint32_t>> ranked;
  ranked.reserve(candidates.size());
  for (const std::uint32_t point : candidates)
    ranked.emplace_back(squaredDistance(query, implementation_->points[point]), point);
  std::nth_element(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(k) - 1, ranked.end());
  candidates.resize(k);
  for (std::size_t i = 0; i < k; ++i) candidates[i] = ranked[i].second;
}

}  // namespace bakelight::idmap
