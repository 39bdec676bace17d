// Radiance transfer textures: figures, and a picture of them under a light.
#pragma once

#include <vector>

#include "formats/radiance_transfer_texture.h"
#include "tools/inspect/preview.h"
#include "tools/inspect/summary.h"

namespace bakelight::inspect {

std::vector<Section> describeRtt(const std::vector<formats::RadianceTransferTexture>& textures);

// All views of each texture under transport::defaultLight, which stands in the patch's frame: the zenith's in the
// middle, that from +x at the right, from +y at the top; textures one below the other.
Preview previewRtt(const std::vector<formats::RadianceTransferTexture>& textures,
                   const PreviewOptions& options);

}  // namespace bakelight::inspect
