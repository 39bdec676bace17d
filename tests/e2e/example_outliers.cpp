#include "tests/e2e/example_outliers.h"

#include <map>

#include "formats/image.h"
#include "formats/mesh_ply.h"
#include "formats/tensors.h"
#include "transport/lights.h"

namespace bakelight::tests {

namespace fs = std::filesystem;

LitOutlier worstLitOutlier(const fs::path& asset_outputs, const fs::path& probes) {
  const formats::TriangleMesh mesh = formats::readPly(asset_outputs / "simplify/mesh.ply");
  const formats::TensorFile transfer =
      formats::readSafetensors(asset_outputs / "transfer/transfer.safetensors");
  const int order = std::stoi(transfer.metadata.at("order"));
  std::map<std::string, transport::ShLight> lights = {{"default light", transport::defaultLight(order)}};
  for (const auto& entry : fs::directory_iterator(probes))
    if (entry.path().extension() == ".exr")
      lights[entry.path().filename()] =
          transport::projectLatLong(formats::readImage(entry.path()), order, entry.path());

  LitOutlier worst;
  for (const char* name : {"transfer", "near_transfer"}) {
    const auto found = transfer.tensors.find(name);
    if (found == transfer.tensors.end()) continue;
    const auto channels = static_cast<int>(found->second.shape.at(1));
    for (const auto& [light, coefficients] : lights) {
      const OutlyingRadiance here =
          worstOutlier(mesh, found->second.as<float>(), order, channels, coefficients);
      if (here.excess > worst.worst.excess) worst = {here, std::string(name) + " under " + light};
    }
  }
  return worst;
}

}  // namespace bakelight::tests
