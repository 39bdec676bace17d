#include "tools/reference/ground.h"

#include <limits>

#include "transport/surface_points.h"

namespace bakelight::reference {

Ground::Ground(const GroundOptions& options, const formats::TriangleMesh& mesh,
               const transport::BoundingSphere& bounds, const Eigen::Matrix3d& world_from_object)
    : albedo_(transport::vec3(options.albedo)),
      center_(bounds.center),
      world_from_object_(world_from_object),
      offset_(transport::surfaceOffset(mesh, transport::kDefaultBias)) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const formats::Float3& position : mesh.positions) {
    low = low.cwiseMin(transport::vec3(position));
    high = high.cwiseMax(transport::vec3(position));
  }
  level_ = low.y();
  const Vec3 middle = (low + high) / 2,
             half = (high - low) / 2 + Vec3::Constant(options.reach * bounds.radius);
  fade_.middle = {static_cast<float>(middle.x()), static_cast<float>(middle.z())};
  fade_.half_size = {static_cast<float>(half.x()), static_cast<float>(half.z())};
}

std::optional<Ground::Seen> Ground::seen(const Vec3& eye, const Vec3& direction,
                                         std::uint32_t material) const {
  const Vec3 from = world_from_object_.transpose() * (eye - center_) + center_;
  const Vec3 way = world_from_object_.transpose() * direction;
  const double above = from.y() - level_;
  if (!(above > 0) || !(way.y() < 0)) return std::nullopt;
  const Vec3 at = from + way * (above / -way.y());
  const double opacity = fade_.opacityAt(at.x(), at.z());
  if (!(opacity > 0)) return std::nullopt;
  const auto inWorld = [&](const Vec3& place) {
    return Vec3(world_from_object_ * (place - center_) + center_);
  };
  ShadingPoint point{inWorld(at + offset_ * Vec3::UnitY()), world_from_object_ * Vec3::UnitY(), albedo_,
                     material};
  point.position = inWorld(at);
  return Seen{point, opacity};
}

}  // namespace bakelight::reference
