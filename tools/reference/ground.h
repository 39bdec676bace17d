// The plane that an object stands on, as a receiver: it gets the object's shadow and the light that it reflects, and the object does not see it. What packs
// show by neighborhood transfer.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "tools/reference/scene.h"
#include "transport/neighborhood_shading.h"

namespace bakelight::reference {

struct GroundOptions {
  formats::Float3 albedo = {0.5F, 0.5F, 0.5F};
  double reach =
      2;  // beyond the object's bounding box, in radii of its bounding sphere, where it has faded out
};

class Ground {
 public:
  // `mesh` is in the object's space, and turns about the middle of `bounds`.
  Ground(const GroundOptions& options, const formats::TriangleMesh& mesh,
         const transport::BoundingSphere& bounds, const Eigen::Matrix3d& world_from_object);

  struct Seen {
    ShadingPoint point;  // in the world
    double opacity;      // above 0
  };
  // Where a ray meets its upper side; `material` is that of its points.
  std::optional<Seen> seen(const Vec3& eye, const Vec3& direction, std::uint32_t material) const;

 private:
  Rgb albedo_;
  Vec3 center_;
  Eigen::Matrix3d world_from_object_;
  double level_, offset_;
  transport::GroundFade fade_;
};

}  // namespace bakelight::reference
