#include "tools/player/frame.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>
#include <utility>

#include "formats/error.h"
#include "transport/sh.h"

namespace bakelight::player {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// Exactly the channels R, G, B, whatever names and further channels the probe has.
formats::Image rgbImage(formats::Image image) {
  if (image.channel_names == std::vector<std::string>{"R", "G", "B"}) return image;
  formats::Image rgb(image.width, image.height, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto center = transport::directionOfLatLong((x + 0.5) / image.width, (y + 0.5) / image.height);
      std::ranges::copy(transport::lookUpLatLong(image, center), rgb.texel(x, y));
    }
  return rgb;
}

void requireFinite(const transport::ShLight& light, const std::string& file) {
  for (std::size_t i = 0; i < light.size(); ++i)
    for (const float value : light[i])
      if (!std::isfinite(value))
        throw badInput({file, "SH coefficient " + std::to_string(i), ""}, "the light is not finite",
                       "radiance in every texel that a float can sum up", "repairing or scaling the image");
}

}  // namespace

const std::vector<std::string>& backgroundNames() {
  static const std::vector<std::string> kNames = {"environment", "black", "transparent"};
  return kNames;
}

Background backgroundNamed(const std::string& name) {
  if (name == "black") return Background::kBlack;
  return name == "transparent" ? Background::kTransparent : Background::kEnvironment;
}

Environment environmentFromImage(formats::Image image, int order, const std::string& file) {
  Environment environment;
  environment.light = transport::projectLatLong(image, order, file);
  requireFinite(environment.light, file);
  environment.image = rgbImage(std::move(image));
  return environment;
}

Environment defaultEnvironment(int order) {
  constexpr int kHeight = 128;  // px; ten bands vary by half a period in 18°
  Environment environment{formats::Image(2 * kHeight, kHeight, {"R", "G", "B"}),
                          transport::defaultLight(order)};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 2 * kHeight; ++x) {
      const auto basis = transport::evaluateSh(
          order, transport::directionOfLatLong((x + 0.5) / (2 * kHeight), (y + 0.5) / kHeight));
      for (std::size_t channel = 0; channel < 3; ++channel) {
        double radiance = 0;
        for (std::size_t i = 0; i < basis.size(); ++i) radiance += basis[i] * environment.light[i][channel];
        environment.image.texel(x, y)[channel] = static_cast<float>(std::max(radiance, 0.0));
      }
    }
  return environment;
}

transport::OrbitCamera frameCamera(const FrameSettings& settings, const transport::BoundingSphere& bounds) {
  const double aspect = static_cast<double>(settings.width_px) / settings.height_px;
  transport::OrbitCamera camera = transport::frameSphere(bounds, settings.yaw_deg, settings.pitch_deg,
                                                         settings.field_of_view_deg, aspect);
  camera.distance *= settings.distance;
  return camera;
}

Eigen::Matrix3d worldFromLight(const FrameSettings& settings) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return (AngleAxisd(settings.light_pitch_deg * kRadiansPerDegree, Vector3d::UnitX()) *
          AngleAxisd(settings.light_yaw_deg * kRadiansPerDegree, Vector3d::UnitY()))
      .toRotationMatrix();
}

double exposureFactor(const FrameSettings& settings, const transport::ShLight& light) {
  const double stops = std::exp2(settings.exposure_ev);
  if (!settings.auto_exposure || light.empty()) return stops;
  // The first coefficient is ∫ L y_0 = mean · 4π · √(1/4π).
  const double luminance = 0.2126 * light[0][0] + 0.7152 * light[0][1] + 0.0722 * light[0][2];
  const double mean = luminance / (2 * std::sqrt(std::numbers::pi));
  return mean > 0 ? stops * kMiddleValue / mean : stops;
}

}  // namespace bakelight::player
