#include "tools/player/light_file.h"

#include <utility>

#include "formats/image.h"
#include "formats/light_rig_file.h"

namespace bakelight::player {

Lighting readLighting(const std::filesystem::path& environment_path, const std::filesystem::path& rig_path,
                      int order, double windowing) {
  if (rig_path.empty()) {
    if (environment_path.empty()) return defaultLighting(order, windowing);
    return lightingFromImage(formats::readImage(environment_path), order, environment_path.string(),
                             windowing);
  }
  formats::LightRig rig = formats::readLightRig(rig_path);
  if (!environment_path.empty()) {
    formats::EnvironmentLight environment;
    environment.path = environment_path;
    environment.image = formats::readImage(environment_path);
    rig.distant.emplace_back(std::move(environment));
  }
  if (windowing != 0) rig.windowing = windowing;
  return lightingFromRig(std::move(rig), order, rig_path.string());
}

}  // namespace bakelight::player
