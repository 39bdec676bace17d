#include "tools/player/lights/gpu_light.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "formats/error.h"

namespace bakelight::player {
namespace {

constexpr std::size_t kLightSize = transport::coefficientCount(transport::kMaxOrder);
using PaddedLight = std::array<formats::Float4, kLightSize>;

}  // namespace

GpuLight darkLight() {
  const PaddedLight dark{};
  return {makeBuffer(sizeof(dark), dark.data(), GL_DYNAMIC_STORAGE_BIT)};
}

void setLight(GpuLight& gpu_light, std::span<const transport::Float3> light) {
  if (light.size() > kLightSize) throw std::invalid_argument("the light has too many coefficients");
  PaddedLight padded{};
  for (std::size_t i = 0; i < light.size(); ++i) {
    for (const float value : light[i])
      if (!std::isfinite(value))
        throw badInput({"", "light coefficient " + std::to_string(i), ""}, "is not a finite number",
                       "a finite number", "another light");
    padded[i] = {light[i][0], light[i][1], light[i][2], 0};
  }
  glNamedBufferSubData(gpu_light.sh.name(), 0, sizeof(padded), padded.data());
  ++gpu_light.revision;
}

}  // namespace bakelight::player
