#include "transport/lighting.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "formats/error.h"
#include "transport/light_rig.h"
#include "transport/sh.h"
#include "transport/windowing.h"

namespace bakelight::transport {
namespace {

void requireFinite(const ShLight& light, const std::string& file) {
  for (std::size_t i = 0; i < light.size(); ++i)
    for (const float value : light[i])
      if (!std::isfinite(value))
        throw badInput({file, "SH coefficient " + std::to_string(i), ""}, "the light is not finite",
                       "radiance in every texel that a float can sum up", "repairing or scaling the light");
}

void applyWindow(Lighting& lighting, double windowing) {
  if (windowing == 0) return;
  WindowedLight windowed =
      windowing < 0 ? windowUntilPositive(lighting.distant) : window(lighting.distant, windowing);
  lighting.distant = std::move(windowed.light);
  lighting.window = windowed.lambda;
  lighting.moved_energy = windowed.moved_energy;
}

formats::Image imageOf(const ShLight& light, int order) {
  constexpr int kHeight = 128;  // px; ten bands vary by half a period in 18°
  formats::Image image(2 * kHeight, kHeight, {"R", "G", "B"});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 2 * kHeight; ++x) {
      const auto basis =
          evaluateSh(order, directionOfLatLong((x + 0.5) / (2 * kHeight), (y + 0.5) / kHeight));
      for (std::size_t channel = 0; channel < 3; ++channel) {
        double radiance = 0;
        for (std::size_t i = 0; i < basis.size(); ++i) radiance += basis[i] * light[i][channel];
        image.texel(x, y)[channel] = static_cast<float>(std::max(radiance, 0.0));
      }
    }
  return image;
}

// DefaultLight as a rig has it.
std::vector<formats::DistantLight> defaultSources() {
  const DefaultLight light;
  constexpr double kDegrees = 180 / std::numbers::pi;
  formats::DiskLight key, sky;
  key.direction = float3(light.key_direction);
  key.half_angle_deg = light.key_half_angle_rad * kDegrees;
  key.radiance = light.key_radiance;
  sky.half_angle_deg = 180;
  sky.radiance = light.sky_radiance;
  return {key, sky};
}

}  // namespace

Lighting lightingFromImage(const formats::Image& image, int order, const std::string& file,
                           double windowing) {
  Lighting lighting;
  lighting.distant = projectLatLong(image, order, file);
  requireFinite(lighting.distant, file);
  lighting.backdrop = rgbImage(image, file);
  formats::EnvironmentLight source;
  source.path = file;
  source.image = lighting.backdrop;
  lighting.sources = {std::move(source)};
  applyWindow(lighting, windowing);
  return lighting;
}

Lighting lightingFromRig(formats::LightRig rig, int order, const std::string& file) {
  Lighting lighting;
  if (rig.distant.empty()) {
    lighting.distant = uniformLight(order, {0, 0, 0});
    lighting.backdrop = formats::Image(2, 1, {"R", "G", "B"});
  } else {
    RigLight light = distantLight(rig, order);
    requireFinite(light.light, file);
    lighting.distant = std::move(light.light);
    lighting.backdrop = std::move(light.backdrop);
    lighting.window = light.window;
    lighting.moved_energy = light.moved_energy;
  }
  lighting.sources = std::exchange(rig.distant, {});
  lighting.near = std::move(rig);
  return lighting;
}

Lighting defaultLighting(int order, double windowing) {
  Lighting lighting;
  lighting.distant = defaultLight(order);
  lighting.backdrop = imageOf(lighting.distant, order);
  lighting.sources = defaultSources();
  applyWindow(lighting, windowing);
  return lighting;
}

namespace {

bool isPlainEnvironment(const formats::LightRig& rig) {
  if (rig.distant.size() != 1 || !rig.emitters.empty() || !rig.punctual.empty()) return false;
  const auto* environment = std::get_if<formats::EnvironmentLight>(&rig.distant.front());
  return environment != nullptr && environment->yaw_deg == 0 && environment->intensity == 1 &&
         environment->image.width == 2 * environment->image.height;
}

}  // namespace

Lighting lightingFor(formats::LightRig rig, int order, const std::string& file) {
  if (rig.empty()) return defaultLighting(order, rig.windowing);
  if (!isPlainEnvironment(rig)) return lightingFromRig(std::move(rig), order, file);
  const auto& environment = std::get<formats::EnvironmentLight>(rig.distant.front());
  return lightingFromImage(environment.image, order, environment.path.string(), rig.windowing);
}

}  // namespace bakelight::transport
