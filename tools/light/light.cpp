#include "tools/light/light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "transport/windowing.h"

namespace bakelight::light {
namespace {

using formats::Float3;
using transport::ShLight;

constexpr double kPi = std::numbers::pi;
constexpr double kLargestMovedEnergy = 0.5;  // beyond this the light looks like another one
const std::array<const char*, std::variant_size_v<formats::DistantLight>> kTypeNames = {
    "environment", "disk", "polygon", "directional", "sky"};

Float3 times(const Float3& color, double factor) {
  return {static_cast<float>(color[0] * factor), static_cast<float>(color[1] * factor),
          static_cast<float>(color[2] * factor)};
}

Float3 reconstruct(const ShLight& light, int order, const transport::Vec3& direction) {
  const std::vector<double> basis = transport::evaluateSh(order, direction);
  std::array<double, 3> radiance{};
  for (std::size_t i = 0; i < basis.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) radiance[c] += basis[i] * light[i][c];
  return {static_cast<float>(radiance[0]), static_cast<float>(radiance[1]), static_cast<float>(radiance[2])};
}

}  // namespace

LightFigures figuresOf(const formats::LightRig& rig, const ShLight& light) {
  LightFigures figures;
  double total = 0;
  for (const formats::DistantLight& distant : rig.distant) {
    // ∫ L dω = √4π × the first coefficient.
    const Float3 irradiance = times(transport::projectLight(distant, 1)[0], std::sqrt(4 * kPi));
    figures.lights.push_back({kTypeNames[distant.index()], irradiance, transport::luminance(irradiance)});
    total += transport::luminance(irradiance);
  }
  for (LightShare& share : figures.lights) share.energy_share = total > 0 ? share.energy_share / total : 0;
  figures.mean_radiance = times(light.at(0), 1 / std::sqrt(4 * kPi));
  figures.minimum_over_mean = transport::minimumOverMean(light);
  return figures;
}

formats::TensorFile tensorFile(const transport::RigLight& light, int order) {
  std::vector<float> values;
  for (const Float3& coefficient : light.light)
    values.insert(values.end(), coefficient.begin(), coefficient.end());
  formats::TensorFile file;
  file.tensors["light"] = formats::Tensor::from<float>(
      formats::ElementType::kFloat32, {light.light.size(), 3}, std::span<const float>(values));
  file.metadata = {{"order", std::to_string(order)},
                   {"basis", "real_sh_cartesian"},
                   {"unit", "radiance, linear RGB"},
                   {"window", formats::Json(light.window).dump()},
                   {"moved_energy", formats::Json(light.moved_energy).dump()}};
  return file;
}

formats::Image preview(const transport::RigLight& light, int order) {
  const formats::Image& backdrop = light.backdrop;
  formats::Image picture(backdrop.width, 2 * backdrop.height, {"R", "G", "B"});
  std::copy(backdrop.values.begin(), backdrop.values.end(), picture.values.begin());
  tbb::parallel_for(0, backdrop.height, [&](int y) {
    for (int x = 0; x < backdrop.width; ++x) {
      const transport::Vec3 direction =
          transport::directionOfLatLong((x + 0.5) / backdrop.width, (y + 0.5) / backdrop.height);
      const Float3 radiance = reconstruct(light.light, order, direction);
      std::copy(radiance.begin(), radiance.end(), picture.texel(x, backdrop.height + y));
    }
  });
  return picture;
}

void report(const transport::RigLight& light, const LightFigures& figures, const formats::LightRig& rig,
            stage::Run& run) {
  formats::Json lights = formats::Json::array();
  for (const LightShare& share : figures.lights)
    lights.push_back({{"type", share.type},
                      {"scalar_irradiance", share.scalar_irradiance},
                      {"energy_share", share.energy_share}});
  run.stat("lights", std::move(lights));
  run.stat("emitters", rig.emitters.size());
  run.stat("punctual", rig.punctual.size());
  run.stat("window", light.window);
  run.stat("moved_energy", light.moved_energy);
  run.stat("mean_radiance", figures.mean_radiance);
  run.stat("minimum_luminance_over_mean", figures.minimum_over_mean);
  if (figures.lights.empty())
    run.warn("no distant light: the coefficients are zero; emitters are near field");
  if (!rig.punctual.empty())
    run.warn("punctual lights have no spherical harmonics and are not in the coefficients");
  const std::string ringing = transport::ringingWarning(figures.minimum_over_mean, light.window);
  if (!ringing.empty()) run.warn(ringing);
  if (light.moved_energy > kLargestMovedEnergy)
    run.warn("the window took away " + std::to_string(std::lround(100 * light.moved_energy)) +
             "% of the light's variation: a number for \"windowing\" below " +
             formats::Json(light.window).dump() + " keeps more of it and rings more");
}

}  // namespace bakelight::light
