// What patches of meso-structure reflect in the mean: the albedo that a surface covered with them has from afar, off which
// light bounces between parts of the object.
#pragma once

#include <span>

#include "formats/material.h"
#include "formats/radiance_transfer_texture.h"

namespace bakelight::formats {

// Of uniform light the share that is reflected, 0–1: mean over texels, and over views by their cosine.
Float3 meanAlbedo(const RadianceTransferTexture& texture);

// The materials of those names get the albedo of their textures instead of their own.
void takePatchAlbedo(Materials& materials, std::span<const RadianceTransferTexture> textures);

}  // namespace bakelight::formats
