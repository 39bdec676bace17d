// The k nearest of a set of points, exactly, for many queries of which those side by side are near each other.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::idmap {

using formats::Float3;

// Squared, in double precision.
inline double squaredDistance(const Float3& a, const Float3& b) {
  const double x = static_cast<double>(a[0]) - b[0], y = static_cast<double>(a[1]) - b[1],
               z = static_cast<double>(a[2]) - b[2];
  return x * x + y * y + z * z;
}

class NearestPoints {
 public:
  // Keeps a copy; one point at least. O(n log n), on one thread.
  explicit NearestPoints(std::span<const Float3> points);
  ~NearestPoints();
  NearestPoints(const NearestPoints&) = delete;
  NearestPoints& operator=(const NearestPoints&) = delete;

  // Some queries that lie near each other, and points that the k nearest of each are among.
  struct Group {
    std::span<const Float3> queries;
    std::span<const std::uint32_t> points;
    // Of a query's k nearest are surely those that are nearer than `reach` less its distance from `center`.
    Float3 center{};
    double reach = 0;
  };

  // Goes through the queries group by group. FLANN's k-d tree is asked once for each: with r the distance of
  // the k-th nearest of the center, and all queries within ρ of it, their k nearest are within r + 2ρ.
  class Walk {
   public:
    // 1 ≤ k ≤ number of points.
    Walk(const NearestPoints& points, std::span<const Float3> queries, std::size_t k);
    ~Walk();
    Walk(const Walk&) = delete;
    Walk& operator=(const Walk&) = delete;
    bool next();  // false at the end
    const Group& group() const { return group_; }

   private:
    struct Result;
    std::unique_ptr<Result> result_;  // what the group's points are in
    const NearestPoints& points_;
    std::span<const Float3> queries_;  // that are left
    std::size_t k_;
    double bound_ = std::numeric_limits<double>::infinity();  // of the distance of the k-th nearest
    Group group_;
  };

  // Leaves the k nearest of `candidates`, of equally far ones those of lower index, in no order.
  void keepNearest(const Float3& query, std::size_t k, std::vector<std::uint32_t>& candidates) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::idmap
