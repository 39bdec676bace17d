// Whether what the driver baked has vertices that show as spots under any of the probes.
#pragma once

#include <filesystem>
#include <string>

#include "tests/support/outlying_radiance.h"

namespace bakelight::tests {

struct LitOutlier {
  OutlyingRadiance worst;
  std::string light;
  std::string text() const { return light + ": " + worst.text(); }
};

// The worst vertex of an asset's outputs (out/ASSET) under each image in `probes` and the default light; the
// diffuse vectors, and the near ones if there are.
LitOutlier worstLitOutlier(const std::filesystem::path& asset_outputs, const std::filesystem::path& probes);

}  // namespace bakelight::tests
