// Points in space by their neighborhood: FLANN's k-d tree behind it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::kernels {

using transport::Vec3;

class PointIndex {
 public:
  // Keeps a copy; one point at least.
  explicit PointIndex(std::span<const Vec3> points);
  ~PointIndex();
  PointIndex(const PointIndex&) = delete;
  PointIndex& operator=(const PointIndex&) = delete;

  // Those within `radius`, ascending. From several threads at once.
  void within(const Vec3& place, double radius, std::vector<std::uint32_t>& found) const;
  // The `count` nearest, nearest first, of equally near ones that of the lower index; fewer if there are no more.
  void nearest(const Vec3& place, std::size_t count, std::vector<std::uint32_t>& found) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::kernels
