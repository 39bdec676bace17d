// Radiance transfer textures as pictures that texture is synthesized from.
#pragma once

#include "formats/image.h"
#include "formats/radiance_transfer_texture.h"

namespace bakelight::mesomesh {

// What tells places of the patch apart, towards at most 3 × 3 views evenly out of all, each coefficient weighed by
// 1/(1 + band) as light has less of the higher ones.
formats::Image appearanceOf(const formats::RadianceTransferTexture& texture);

// Of that, what a turn of the patch does not change: light that is alike all around, and the mean over views. What is
// symmetric about it shows there; in single coefficients it does not, as they turn with the patch.
formats::Image turnInvariant(const formats::RadianceTransferTexture& texture);

// R, G and B as the views nearest to the zenith show them under a uniform sky, 0–1.
formats::Image zenithColors(const formats::RadianceTransferTexture& texture);

}  // namespace bakelight::mesomesh
