// Where evaluation gets what the plan names, so that it can do without files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "formats/image.h"
#include "formats/light_rig.h"
#include "formats/pack_contents.h"

namespace bakelight::report {

struct Sources {
  std::function<formats::Pack(const std::filesystem::path&)> pack;
  std::function<std::uint64_t(const std::filesystem::path&)> bytes;  // of a pack's file
  std::function<formats::Image(const std::filesystem::path&)> image;
  std::function<std::map<std::string, std::string>(const std::filesystem::path&)> image_metadata;
  // Of formats::readLights: environment, rig, windowing.
  std::function<formats::LightRig(const std::filesystem::path&, const std::filesystem::path&,
                                  std::optional<double>)>
      lights;
};

// The files themselves. formats::read… throw.
Sources fileSources();

}  // namespace bakelight::report
