#include "transport/frame.h"

#include <cmath>
#include <Eigen/Geometry>
#include <numbers>

#include "transport/sh.h"

namespace bakelight::transport {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

Eigen::Matrix3d turned(double yaw_deg, double pitch_deg) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return (AngleAxisd(pitch_deg * kRadiansPerDegree, Vector3d::UnitX()) *
          AngleAxisd(yaw_deg * kRadiansPerDegree, Vector3d::UnitY()))
      .toRotationMatrix();
}

}  // namespace

OrbitCamera frameCamera(const formats::FrameSettings& settings, const BoundingSphere& bounds) {
  const double aspect = static_cast<double>(settings.width_px) / settings.height_px;
  OrbitCamera camera =
      frameSphere(bounds, settings.yaw_deg, settings.pitch_deg, settings.field_of_view_deg, aspect);
  camera.distance *= settings.distance;
  return camera;
}

Eigen::Matrix3d worldFromLight(const formats::FrameSettings& settings) {
  return turned(settings.light_yaw_deg, settings.light_pitch_deg);
}

Eigen::Matrix3d worldFromObject(const formats::FrameSettings& settings) {
  return turned(settings.object_yaw_deg, settings.object_pitch_deg);
}

double exposureFactor(const formats::FrameSettings& settings, const ShLight& light) {
  const double stops = std::exp2(settings.exposure_ev);
  if (!settings.auto_exposure || light.empty()) return stops;
  // The first coefficient is ∫ L y_0 = mean · 4π · √(1/4π).
  const double luminance = 0.2126 * light[0][0] + 0.7152 * light[0][1] + 0.0722 * light[0][2];
  const double mean = luminance / (2 * std::sqrt(std::numbers::pi));
  return mean > 0 ? stops * kMiddleValue / mean : stops;
}

}  // namespace bakelight::transport
