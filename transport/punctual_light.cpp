#include "transport/punctual_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/light_rig.h"

namespace bakelight::transport {
namespace {

using formats::PunctualLight;

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// 1 − cos without what rounding would take from narrow cones.
double versine(double angle_deg) {
  const double half_sine = std::sin(angle_deg * kRadiansPerDegree / 2);
  return 2 * half_sine * half_sine;
}

Eigen::Matrix3d axesOf(const PunctualLight& light) {
  const Vec3 forward = vec3(light.direction).normalized();
  const Vec3 right = light.type == PunctualLight::Type::kSlide ? forward.cross(vec3(light.up)).normalized()
                                                               : forward.unitOrthogonal();
  Eigen::Matrix3d axes;
  axes << right, right.cross(forward), -forward;
  return axes;
}

Eigen::Array3d meanOf(const formats::Image& image) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float* texel = image.texel(x, y);
      sum += vec3({texel[0], texel[1], texel[2]}).array();
    }
  return sum / (static_cast<double>(image.width) * image.height);
}

}  // namespace

Eigen::Array3d PlacedPunctualLight::intensityTowards(const Vec3& direction) const {
  if (type == Type::kPoint) return intensity;
  if (type == Type::kSpot) {
    const double away = (direction + axes.col(2)).squaredNorm() / 2;  // 1 − cos θ
    const double share = std::clamp((outer - away) / (outer - inner), 0.0, 1.0);
    return intensity * (share * share);
  }
  const Vec3 local = axes.transpose() * direction;
  if (!(local.z() < 0)) return Eigen::Array3d::Zero();
  const double column = (local.x() / (-local.z() * half_width) + 1) / 2 * image->width,
               row = (1 - local.y() / (-local.z() * half_height)) / 2 * image->height;
  if (!(column >= 0 && column < image->width && row >= 0 && row < image->height))
    return Eigen::Array3d::Zero();
  const float* pixel = image->texel(static_cast<int>(column), static_cast<int>(row));
  return intensity * vec3({pixel[0], pixel[1], pixel[2]}).array();
}

Eigen::Array3d PlacedPunctualLight::irradianceFacing(const Vec3& point) const {
  const Vec3 way = point - position;
  const double distance = way.norm();
  if (!(distance > 0)) return Eigen::Array3d::Zero();
  return intensityTowards(way / distance) / (distance * distance);
}

std::vector<PlacedPunctualLight> placedPunctualLights(const formats::LightRig& rig,
                                                      const BoundingSphere& object, double time_s) {
  const double unit = rig.object_units ? object.radius : 1;
  const Vec3 origin = rig.object_units ? object.center : Vec3::Zero();
  std::vector<PlacedPunctualLight> placed;
  for (const PunctualLight& light : rig.punctual) {
    const Eigen::Isometry3d pose = rigFromBody(light.position, light.motion, time_s);
    PlacedPunctualLight& result = placed.emplace_back();
    result.type = light.type;
    result.position = origin + unit * pose.translation();
    result.intensity = vec3(light.intensity).array() * (unit * unit);
    result.axes = pose.linear() * axesOf(light);
    result.inner = versine(light.inner_half_angle_deg);
    result.outer = versine(light.outer_half_angle_deg);
    if (light.image == nullptr) continue;
    result.image = light.image;
    result.half_height = std::tan(light.field_of_view_deg * kRadiansPerDegree / 2);
    result.half_width = result.half_height * light.image->width / light.image->height;
  }
  return placed;
}

void turnAbout(const Vec3& center, const Eigen::Matrix3d& rotation,
               std::vector<PlacedPunctualLight>& lights) {
  for (PlacedPunctualLight& light : lights) {
    light.position = rotation * (light.position - center) + center;
    light.axes = rotation * light.axes;
  }
}

ShLight withMeanLight(ShLight light, const std::vector<PlacedPunctualLight>& lights, const Vec3& center) {
  if (lights.empty()) return light;
  Eigen::Array3d irradiance = Eigen::Array3d::Zero();
  for (const PlacedPunctualLight& punctual : lights) {
    const double squared_distance = (punctual.position - center).squaredNorm();
    if (!(squared_distance > 0)) continue;
    const Eigen::Array3d share = punctual.image ? meanOf(*punctual.image) : Eigen::Array3d::Ones();
    irradiance += punctual.intensity * share / squared_distance;
  }
  // ∫ L y₀ = ∫ L dω · √(1/4π)
  const Float3 more = float3((irradiance / std::sqrt(4 * std::numbers::pi)).matrix());
  for (std::size_t c = 0; c < 3; ++c) light.at(0)[c] += more[c];
  return light;
}

}  // namespace bakelight::transport
