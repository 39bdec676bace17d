// A picture of heights as a surface.
#pragma once

#include <string>

#include "formats/image.h"
#include "patch/patch_geometry.h"

namespace bakelight::patch {

// The first channel ("height" or "Z" goes before) times `depth` is the height above black, in widths of the patch;
// vertices are at the texels' middles, two triangles between four of them, along the flatter diagonal. With
// `periodic` the picture continues itself, otherwise its mirror images do. Texels are square. Of the result only
// mesh, aspect, periods and notes are set. Throws Error(kBadInput) naming `file`: no texel, more than 4096 a
// side, a height that is not finite or beyond 1000 widths.
PatchGeometry heightField(const formats::Image& heights, double depth, bool periodic,
                          const std::string& file);

}  // namespace bakelight::patch
