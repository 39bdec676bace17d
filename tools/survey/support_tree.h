// The highest of many points above a plane, by a tree of oriented boxes.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::survey {

// Of a triangle, outward.
struct Plane {
  transport::Vec3 normal = transport::Vec3::Zero();  // unit length
  transport::Vec3 origin = transport::Vec3::Zero();  // centroid
  // A point at distance r from the origin counts as lower by tolerance + slope · r.
  double tolerance = 0, slope = 0;
};

// Boxes along the principal axes of their points: thin on flat and on gently curved surfaces, whichever way
// these face, so that few boxes reach above the plane of a triangle of a convex body.
class SupportTree {
 public:
  explicit SupportTree(std::vector<transport::Vec3> points);

  // The largest height of a point over the plane, its tolerance taken off, or `known` if none is higher.
  double highest(const Plane& plane, double known) const;

 private:
  struct Node {
    transport::Vec3 center, half_extent;
    Eigen::Matrix3d axes;              // rows
    std::uint32_t begin = 0, end = 0;  // points
    std::uint32_t right = 0;           // the left child follows its parent; 0: a leaf
  };
  static std::size_t nodeCount(std::size_t points);
  void build(std::size_t node, std::uint32_t begin, std::uint32_t end);
  static double bound(const Node& node, const Plane& plane);

  std::vector<transport::Vec3> points_;
  std::vector<Node> nodes_;
};

}  // namespace bakelight::survey
